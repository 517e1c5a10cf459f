#include "perception/refinement/refinement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "common/format.h"

namespace vantage {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

// Gauss-Newton on a small motion of the model: a rotation vector about its center and a
// translation, in the camera's axes.
class MotionEquations {
 public:
  explicit MotionEquations(const Eigen::Vector3d& center_camera) : center_(center_camera) {}

  // A measurement `distance` (m) off the model's surface along `normal` at `p_camera`.
  void Add(const Eigen::Vector3d& p_camera,
           const Eigen::Vector3d& normal,
           double distance,
           double weight) {
    Vector6 jacobian;
    jacobian << (p_camera - center_).cross(normal), normal;
    information_.selfadjointView<Eigen::Lower>().rankUpdate(jacobian, weight);
    right_ += weight * distance * jacobian;
    weighted_square_ += weight * distance * distance;
    weight_ += weight;
    ++pairs_;
  }
  // Directions that no measurement fixes stay where they are: a weak prior at no motion.
  [[nodiscard]] Matrix6 Information() const {
    constexpr double kPriorRotation = 0.1;      // rad
    constexpr double kPriorTranslation = 0.02;  // m
    Matrix6 full = information_.selfadjointView<Eigen::Lower>();
    full.diagonal().head<3>().array() += 1.0 / (kPriorRotation * kPriorRotation);
    full.diagonal().tail<3>().array() += 1.0 / (kPriorTranslation * kPriorTranslation);
    return full;
  }
  [[nodiscard]] Vector6 Solve() const { return Information().ldlt().solve(right_); }
  [[nodiscard]] int pairs() const { return pairs_; }
  [[nodiscard]] double rms() const {
    return weight_ > 0.0 ? std::sqrt(weighted_square_ / weight_) : 0.0;
  }

 private:
  Eigen::Vector3d center_;
  Matrix6 information_ = Matrix6::Zero();
  Vector6 right_ = Vector6::Zero();
  double weighted_square_ = 0.0;
  double weight_ = 0.0;
  int pairs_ = 0;
};

void Move(const Vector6& motion, const Eigen::Vector3d& center, Pose* T_camera_object) {
  const Eigen::Vector3d place = *T_camera_object * center + motion.tail<3>();
  const Eigen::Quaterniond rotation =
      (ExpSo3(motion.head<3>()) * Eigen::Quaterniond(T_camera_object->linear())).normalized();
  T_camera_object->linear() = rotation.toRotationMatrix();
  T_camera_object->translation() = place - T_camera_object->linear() * center;
}

double Biweight(double scaled) {
  if (!(std::abs(scaled) < 1.0)) return 0.0;
  const double rest = 1.0 - scaled * scaled;
  return rest * rest;
}

// Between `start` and `end` in geometric progression.
double Anneal(double start, double end, int i, int count) {
  return count > 1 ? start * std::pow(end / start, static_cast<double>(i) / (count - 1)) : end;
}

constexpr int kFewestPairs = 12;

}  // namespace

Result<void> RefinementParameters::Validate() const {
  if (coarse_iterations < 0 || coarse_iterations > 1000 || fine_iterations < 0 ||
      fine_iterations > 1000 || final_iterations < 0 || final_iterations > 1000) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("refinement: %d coarse, %d fine and %d final iterations, expected 0 to 1000",
               coarse_iterations,
               fine_iterations,
               final_iterations)};
  }
  if (!(coarse_reach > 0.0 && coarse_reach_end > 0.0 && coarse_reach_end <= coarse_reach &&
        fine_reach > 0.0 && coarse_reach <= 1.0 && tukey_sigmas > 0.0 && model_error >= 0.0 &&
        converged >= 0.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("refinement: reaches %g to %g and %g of the diameter (expected 0 to 1, "
                        "descending), tukey_sigmas = %g (expected above 0), model_error = %g m and "
                        "converged = %g (expected 0 or more)",
                        coarse_reach,
                        coarse_reach_end,
                        fine_reach,
                        tukey_sigmas,
                        model_error,
                        converged)};
  }
  return {};
}

Refined RefineCoarse(const NearestGrid& grid,
                     const ModelShape& model,
                     const Pose& T_camera_object,
                     std::span<const SurfacePoint> scene,
                     double focal,
                     const RefinementParameters& parameters) {
  constexpr double kLikeNormals = 0.7;  // Cosine of 45 deg.
  Refined refined{T_camera_object};
  for (int i = 0; i < parameters.coarse_iterations; ++i) {
    const double reach = model.diameter * Anneal(parameters.coarse_reach,
                                                 parameters.coarse_reach_end,
                                                 i,
                                                 parameters.coarse_iterations);
    const Pose& T = refined.T_camera_object;
    const Eigen::Isometry3f T_object_camera(T.inverse().matrix().cast<float>());
    MotionEquations equations(T * model.center);
    for (const SurfacePoint& point : scene) {
      const uint32_t nearest = grid.Find(T_object_camera * point.position);
      if (nearest == NearestGrid::kNone) continue;
      const SurfacePoint& target = grid.points()[nearest];
      const Eigen::Vector3d p = point.position.cast<double>();
      const Eigen::Vector3d q = T * target.position.cast<double>();
      const Eigen::Vector3d n = T.linear() * target.normal.cast<double>();
      if (n.dot(point.normal.cast<double>()) < kLikeNormals) continue;
      const double apart = (p - q).norm();
      const double cosine = std::abs(n.dot(p)) / p.norm();
      const double sigma =
          std::hypot(parameters.noise.AlongNormal(p.z(), focal, cosine), 0.005 * model.diameter);
      equations.Add(q, n, n.dot(p - q), Biweight(apart / (1.5 * reach)) / (sigma * sigma));
    }
    refined.pairs = equations.pairs();
    refined.rms = equations.rms();
    if (equations.pairs() < kFewestPairs) break;
    const Vector6 motion = equations.Solve();
    Move(motion, model.center, &refined.T_camera_object);
    refined.covariance = equations.Information().inverse();
    if (motion.norm() < 1e-4) break;
  }
  return refined;
}

Refined RefineFine(const ModelShape& model,
                   const Pose& T_camera_object,
                   const SegmentedImage& image,
                   int step,
                   int iterations,
                   double reach,
                   const RefinementParameters& parameters,
                   ModelView* view) {
  const CameraModel& camera = image.camera;
  Refined refined{T_camera_object};
  constexpr double kTightening = 0.2;  // Of the reach, at the last iteration.
  for (int i = 0; i < iterations; ++i) {
    const double loose = reach > 0.0 ? Anneal(reach, kTightening * reach, i, iterations) : 0.0;
    const Pose& T = refined.T_camera_object;
    const Eigen::Matrix3f R = T.linear().cast<float>();
    MotionEquations equations(T * model.center);
    view->Render(model.mesh, T, camera, ModelWindow(camera, model, T), step);
    view->ForEachPixel([&](const ModelView::Pixel& pixel) {
      const size_t index = image.depth.Index(pixel.u, pixel.v);
      if (image.segmentation.labels[index] < 0) return;
      const auto measured = static_cast<double>(image.depth.depth[index]);
      const auto rendered = static_cast<double>(pixel.depth);
      const Eigen::Vector3d ray = camera.Unproject(pixel.u, pixel.v, 1.0);
      const Eigen::Vector3d normal =
          VisibleNormal(model.mesh, R, pixel.triangle, ray.cast<float>()).cast<double>();
      const double along = normal.dot(ray);  // Negative: the normal faces the camera.
      const double distance = along * (measured - rendered);
      const double sigma =
          std::hypot(parameters.noise.AlongNormal(rendered, camera.fx, -along / ray.norm()),
                     parameters.model_error);
      const double cut = std::max(loose, parameters.tukey_sigmas * sigma);
      const double weight = Biweight(distance / cut);
      if (weight > 0.0) equations.Add(rendered * ray, normal, distance, weight / (sigma * sigma));
    });
    refined.pairs = equations.pairs();
    refined.rms = equations.rms();
    if (equations.pairs() < kFewestPairs) break;
    const Vector6 motion = equations.Solve();
    Move(motion, model.center, &refined.T_camera_object);
    refined.covariance = equations.Information().inverse();
    const double size = std::max(motion.head<3>().norm(), 10.0 * motion.tail<3>().norm());
    if (size < parameters.converged) break;
  }
  return refined;
}

}  // namespace vantage
