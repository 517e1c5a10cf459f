#include "perception/refinement/refiner.h"

#include <algorithm>
#include <cmath>

#include "perception/refinement/pose_covariance.h"

namespace vantage {
namespace {

constexpr int kFewestPairs = 12;

// What the loop over pixels needs, in floats.
struct Setup {
  float turn[9];    // Since the model was drawn, row by row.
  float center[3];  // m, of the model
  const float* depth;
  int columns;
  float last_column, last_row;  // px
  float focal_u, focal_v;       // px
  float middle_u, middle_v;     // px, principal point in the window
  float axial_base, axial_quadratic, axial_offset, lateral, model_variance;
  float least_squared_cut;  // m^2
  float squared_sigmas;     // Of the cut.
};

VANTAGE_SIMD void Accumulate(const Setup& setup,
                             std::span<const Refiner::Block> blocks,
                             MotionSums* sums) {
  constexpr float kSteepest = 0.003F;  // Squared cosine, of 87 deg.
  const float inverse_u = 1.0F / setup.focal_u;
  const float inverse_v = 1.0F / setup.focal_v;
  for (const Refiner::Block& block : blocks) {
    F8s<3> arm;
    F8s<3> normal;
    F8s<3> p;
    for (size_t i = 0; i < 3; ++i) {
      const float* row = setup.turn + 3 * i;
      arm[i] = row[0] * block.arm[0] + row[1] * block.arm[1] + row[2] * block.arm[2];
      normal[i] = row[0] * block.normal[0] + row[1] * block.normal[1] + row[2] * block.normal[2];
      p[i] = arm[i] + setup.center[i];
    }
    const F8 inverse_z = 1.0F / p[2];
    const F8 u = setup.focal_u * p[0] * inverse_z + (setup.middle_u + 0.5F);
    const F8 v = setup.focal_v * p[1] * inverse_z + (setup.middle_v + 0.5F);
    const I8 is_inside = (p[2] > 0.0F) & (u >= 0.0F) & (u < setup.last_column + 1.0F) &
                         (v >= 0.0F) & (v < setup.last_row + 1.0F);
    const I8 column = __builtin_convertvector(is_inside ? u : F8{}, I8);
    const I8 row = __builtin_convertvector(is_inside ? v : F8{}, I8);
    const I8 place = row * setup.columns + column;
    F8 measured;
    for (int i = 0; i < kLanes; ++i) measured[i] = setup.depth[place[i]];
    const F8 ray_u = (__builtin_convertvector(column, F8) - setup.middle_u) * inverse_u;
    const F8 ray_v = (__builtin_convertvector(row, F8) - setup.middle_v) * inverse_v;
    const F8 along = normal[0] * p[0] + normal[1] * p[1] + normal[2] * p[2];
    const F8 cosine = along * along / (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);  // Squared.
    const F8 distance = measured * (normal[0] * ray_u + normal[1] * ray_v + normal[2]) - along;
    const F8 beyond_offset = p[2] - setup.axial_offset;
    const F8 beyond = beyond_offset > 0.0F ? beyond_offset : F8{};
    const F8 axial = setup.axial_base + setup.axial_quadratic * beyond * beyond;
    const F8 lateral = setup.lateral * p[2];
    const F8 variance =
        axial * axial * cosine + lateral * lateral * (1.0F - cosine) + setup.model_variance;
    const F8 narrow = setup.squared_sigmas * variance;
    const F8 cut = narrow > setup.least_squared_cut ? narrow : F8{} + setup.least_squared_cut;
    const F8 rest = 1.0F - distance * distance / cut;  // Of Tukey's biweight.
    const I8 is_pair =
        is_inside & (measured > 0.0F) & (along < 0.0F) & (cosine > kSteepest) & (rest > 0.0F);
    const F8 weight = rest * rest / variance;
    sums->Add(arm, normal, distance, is_pair ? weight : F8{});
  }
}

// The depth of pixels that measure and are of a segment; 0 of others.
VANTAGE_SIMD void KeepLabeled(const float* depth,
                              const int32_t* labels,
                              size_t count,
                              float* kept) {
  constexpr float kFarthest = 100.0F;  // m
  for (size_t i = 0; i < count; ++i) {
    const float measured = depth[i] > 0.0F ? depth[i] : 0.0F;
    const float finite = measured < kFarthest ? measured : 0.0F;
    kept[i] = labels[i] >= 0 ? finite : 0.0F;
  }
}

// Between `start` and `end` in geometric progression.
double Anneal(double start, double end, int i, int count) {
  return count > 1 ? start * std::pow(end / start, static_cast<double>(i) / (count - 1)) : end;
}

// m, a typical distance of the surface from the center.
double Lever(const ModelShape& model) { return 0.25 * model.diameter; }

}  // namespace

void Refiner::Cut(const SegmentedImage& image, const PixelWindow& window) {
  window_ = window;
  const auto columns = static_cast<size_t>(window.u1 - window.u0 + 1);
  window_depth_.resize(columns * static_cast<size_t>(window.v1 - window.v0 + 1));
  float* out = window_depth_.data();
  for (int v = window.v0; v <= window.v1; ++v, out += columns) {
    const size_t first = image.depth.Index(window.u0, v);
    KeepLabeled(
        image.depth.depth.data() + first, image.segmentation.labels.data() + first, columns, out);
  }
}

void Refiner::Draw(const ModelShape& model,
                   const CameraModel& camera,
                   int points,
                   ModelView* view) {
  constexpr double kFilled = 0.35;  // Of its ball's window, by a model.
  constexpr int kCoarsest = 16;     // px
  const PixelWindow window = ModelWindow(camera, model, T_);
  blocks_.clear();
  R_drawn_ = T_.linear();
  if (window.empty()) return;
  const double area = static_cast<double>(window.u1 - window.u0 + 1) * (window.v1 - window.v0 + 1);
  const int step =
      std::clamp(static_cast<int>(std::lround(std::sqrt(kFilled * area / points))), 1, kCoarsest);
  pixels_per_point_ = step * step;
  view->Render(model.mesh, T_, camera, window, step);
  const Eigen::Matrix3f R = T_.linear().cast<float>();
  const Eigen::Vector3f center = (T_ * model.center).cast<float>();
  size_t size = 0;
  view->ForEachPixel([&](const ModelView::Pixel& pixel) {
    const Eigen::Vector3f ray = camera.Unproject(pixel.u, pixel.v, 1.0).cast<float>();
    const Eigen::Vector3f normal = VisibleNormal(model.mesh, R, pixel.triangle, ray);
    const Eigen::Vector3f arm = pixel.depth * ray - center;
    const size_t lane = size++ % kLanes;
    if (lane == 0) blocks_.emplace_back();
    Block& block = blocks_.back();
    for (size_t i = 0; i < 3; ++i) {
      block.arm[i][lane] = arm[static_cast<Eigen::Index>(i)];
      block.normal[i][lane] = normal[static_cast<Eigen::Index>(i)];
    }
  });
}

MotionEquations Refiner::Equations(const CameraModel& camera,
                                   double reach,
                                   const RefinementParameters& parameters) const {
  Setup setup{};
  const Eigen::Matrix3f turn = (T_.linear() * R_drawn_.transpose()).cast<float>();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) setup.turn[3 * i + j] = turn(i, j);
    setup.center[i] = static_cast<float>(center_[i]);
  }
  setup.depth = window_depth_.data();
  setup.columns = window_.u1 - window_.u0 + 1;
  setup.last_column = static_cast<float>(window_.u1 - window_.u0);
  setup.last_row = static_cast<float>(window_.v1 - window_.v0);
  setup.focal_u = static_cast<float>(camera.fx);
  setup.focal_v = static_cast<float>(camera.fy);
  setup.middle_u = static_cast<float>(camera.cx - window_.u0);
  setup.middle_v = static_cast<float>(camera.cy - window_.v0);
  const DepthNoise& noise = parameters.noise;
  setup.axial_base = static_cast<float>(noise.axial_base);
  setup.axial_quadratic = static_cast<float>(noise.axial_quadratic);
  setup.axial_offset = static_cast<float>(noise.axial_offset);
  setup.lateral = static_cast<float>(noise.lateral_px / camera.fx);
  setup.model_variance = static_cast<float>(parameters.model_error * parameters.model_error);
  setup.least_squared_cut = static_cast<float>(reach * reach);
  setup.squared_sigmas = static_cast<float>(parameters.tukey_sigmas * parameters.tukey_sigmas);
  MotionSums sums;
  Accumulate(setup, blocks_, &sums);
  return sums.Reduced();
}

bool Refiner::Iterate(const ModelShape& model,
                      const CameraModel& camera,
                      int iterations,
                      double reach,
                      const RefinementParameters& parameters) {
  constexpr double kTightening = 0.2;         // Of the reach, at the last iteration.
  constexpr double kPriorRotation = 0.1;      // rad
  constexpr double kPriorTranslation = 0.02;  // m
  for (int i = 0; i < iterations; ++i) {
    const double loose = reach > 0.0 ? Anneal(reach, kTightening * reach, i, iterations) : 0.0;
    const MotionEquations equations = Equations(camera, loose, parameters);
    if (equations.pairs < kFewestPairs) return false;
    const Vector6 motion = equations.Solve(kPriorRotation, kPriorTranslation);
    if (!motion.allFinite()) return false;
    T_ = Moved(T_, motion, center_);
    center_ = T_ * model.center;
    if (std::max(motion.head<3>().norm(), 10.0 * motion.tail<3>().norm()) < parameters.converged) {
      break;
    }
  }
  return true;
}

Refined Refiner::Refine(const ModelShape& first_model,
                        const ModelShape& model,
                        const Pose& T_camera_object,
                        const SegmentedImage& image,
                        const RefinementParameters& parameters,
                        ModelView* view) {
  constexpr double kAround = 1.2;  // Of the radius, for what it moves.
  const CameraModel& camera = image.camera;
  Refined start{T_camera_object};
  start.covariance = PoseCovariance({}, 1.0, Lever(model), 0.0, parameters);
  T_ = T_camera_object;
  center_ = T_ * model.center;
  const PixelWindow window = BallWindow(camera, center_, kAround * model.radius);
  if (window.empty()) return start;
  Cut(image, window);
  if (parameters.fine_iterations > 0) {
    const double reach = parameters.fine_reach * model.diameter;
    Draw(first_model, camera, parameters.fine_points, view);
    if (!Iterate(first_model, camera, parameters.fine_iterations, reach, parameters)) return start;
  }
  if (parameters.final_iterations > 0 || parameters.fine_iterations == 0) {
    Draw(model, camera, parameters.final_points, view);
    if (!Iterate(model, camera, parameters.final_iterations, 0.0, parameters)) return start;
  }
  const MotionEquations equations = Equations(camera, 0.0, parameters);
  if (equations.pairs < kFewestPairs) return start;
  return {T_,
          equations.pairs,
          equations.rms(),
          PoseCovariance(equations, pixels_per_point_, Lever(model), center_.z(), parameters)};
}

}  // namespace vantage
