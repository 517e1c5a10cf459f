#include "tools/evaluate/pose_success.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "common/check.h"
#include "common/depth_rasterizer.h"
#include "common/symmetry_group.h"

namespace vantage {
namespace {

/// A model drawn in a pose, with what the sensor's noise would do to each pixel.
class NoisyView {
 public:
  NoisyView(const TriangleMesh& mesh,
            const Pose& T_camera_mesh,
            const CameraModel& camera,
            const PoseSuccessParameters& parameters)
      : camera_(camera), rasterizer_(camera) {
    rasterizer_.Draw(mesh, T_camera_mesh);
    const Eigen::Matrix3f R = T_camera_mesh.linear().cast<float>();
    sigma_.assign(rasterizer_.depth().size(), 0.0F);
    for (size_t i = 0; i < sigma_.size(); ++i) {
      if (!IsDrawn(i)) continue;
      const Eigen::Vector3f normal = R * mesh.ScaledNormal(rasterizer_.triangle_ids()[i]);
      sigma_[i] = static_cast<float>(Sigma(i, normal, parameters));
    }
  }

  [[nodiscard]] size_t size() const { return sigma_.size(); }
  [[nodiscard]] bool IsDrawn(size_t pixel) const {
    return rasterizer_.depth()[pixel] != DepthRasterizer::kEmpty;
  }
  [[nodiscard]] double depth(size_t pixel) const {
    return static_cast<double>(rasterizer_.depth()[pixel]);
  }
  /// Standard deviation of a measurement along z, m.
  [[nodiscard]] double sigma(size_t pixel) const { return static_cast<double>(sigma_[pixel]); }

  /// True when a pixel within `reach` px shows a depth within `tolerance` m of `depth`.
  [[nodiscard]] bool HasNearby(size_t pixel, int reach, double depth_m, double tolerance) const {
    const int u = static_cast<int>(pixel) % camera_.width;
    const int v = static_cast<int>(pixel) / camera_.width;
    for (int y = std::max(v - reach, 0); y <= std::min(v + reach, camera_.height - 1); ++y) {
      for (int x = std::max(u - reach, 0); x <= std::min(u + reach, camera_.width - 1); ++x) {
        const auto other = static_cast<size_t>(y * camera_.width + x);
        if (IsDrawn(other) && std::abs(depth(other) - depth_m) <= tolerance) return true;
      }
    }
    return false;
  }

 private:
  double Sigma(size_t pixel,
               const Eigen::Vector3f& normal,
               const PoseSuccessParameters& parameters) const {
    constexpr double kSteepest = 5.0;  // Tangent; steeper surfaces are silhouettes.
    const int u = static_cast<int>(pixel) % camera_.width;
    const int v = static_cast<int>(pixel) / camera_.width;
    const Eigen::Vector3d ray = camera_.Unproject(u, v, 1.0).normalized();
    const double length = static_cast<double>(normal.norm());
    const double cosine =
        length > 0.0 ? std::min(std::abs(normal.cast<double>().dot(ray)) / length, 1.0) : 0.0;
    const double tangent =
        std::min(std::sqrt(1.0 - cosine * cosine) / std::max(cosine, 1e-3), kSteepest);
    const double lateral = parameters.noise.Lateral(depth(pixel), camera_.fx) * tangent;
    return std::hypot(parameters.noise.Axial(depth(pixel)), lateral, parameters.model_error);
  }

  CameraModel camera_;
  DepthRasterizer rasterizer_;
  std::vector<float> sigma_;  // m
};

// Not measured counts as visible, as in BOP since 2019.
bool IsVisible(const NoisyView& view, size_t pixel, const DepthImage& measured, double gap) {
  if (!view.IsDrawn(pixel)) return false;
  const auto depth = static_cast<double>(measured.depth[pixel]);
  return !(depth > 0.0) || view.depth(pixel) <= depth + gap;
}

void CompareViews(const NoisyView& truth,
                  const NoisyView& estimate,
                  const DepthImage& measured,
                  const PoseSuccessParameters& parameters,
                  PoseSuccess* success) {
  const auto explained = [&](const NoisyView& one, const NoisyView& other, size_t pixel) {
    return other.HasNearby(
        pixel, parameters.edge_px, one.depth(pixel), parameters.noise_sigmas * one.sigma(pixel));
  };
  int64_t visible = 0;
  int64_t seen_of_truth = 0;
  int64_t telling = 0;
  int64_t shared = 0;
  double squares = 0.0;
  for (size_t i = 0; i < truth.size(); ++i) {
    const bool in_truth = IsVisible(truth, i, measured, parameters.occluder_gap);
    const bool in_estimate = IsVisible(estimate, i, measured, parameters.occluder_gap) ||
                             (in_truth && estimate.IsDrawn(i));
    if (!in_truth && !in_estimate) continue;
    ++visible;
    if (in_truth) ++seen_of_truth;
    if ((in_truth && !explained(truth, estimate, i)) ||
        (in_estimate && !explained(estimate, truth, i))) {
      ++telling;
      continue;
    }
    if (!in_truth || !in_estimate) continue;
    const double difference = (estimate.depth(i) - truth.depth(i)) / truth.sigma(i);
    if (std::abs(difference) > parameters.noise_sigmas) continue;  // Across a step.
    ++shared;
    squares += difference * difference;
  }
  if (seen_of_truth == 0) return;
  success->discrepancy = static_cast<double>(telling) / static_cast<double>(visible);
  if (shared > 0) success->deviation = std::sqrt(squares / static_cast<double>(shared));
  success->is_indistinguishable =
      shared > 0 && success->discrepancy <= parameters.max_share && success->deviation <= 1.0;
}

}  // namespace

PoseSuccess JudgePose(const ObjectModel& model,
                      const Pose& T_camera_true,
                      const Pose& T_camera_estimated,
                      const DepthImage& measured,
                      const CameraModel& camera,
                      const PoseSuccessParameters& parameters) {
  VANTAGE_CHECK(measured.width == camera.width && measured.height == camera.height,
                "the image is not of the camera's size");
  PoseSuccess success;
  if (!T_camera_true.matrix().allFinite() || !T_camera_estimated.matrix().allFinite()) {
    success.angle = std::numeric_limits<double>::quiet_NaN();
    success.distance = std::numeric_limits<double>::quiet_NaN();
    return success;
  }
  success.angle = SymmetricAngle(model.symmetry,
                                 Eigen::Quaterniond(T_camera_true.linear()),
                                 Eigen::Quaterniond(T_camera_estimated.linear()));
  // Every symmetry leaves the center in its place.
  success.distance = (T_camera_true * model.center - T_camera_estimated * model.center).norm();
  success.is_within = success.angle <= parameters.max_angle &&
                      success.distance <= parameters.max_distance * model.diameter;
  // What lies this far off can't be drawn, nor mistaken.
  constexpr double kFarthest = 1e3;  // m
  if (success.distance > kFarthest) return success;
  CompareViews(NoisyView(model.mesh, T_camera_true, camera, parameters),
               NoisyView(model.mesh, T_camera_estimated, camera, parameters),
               measured,
               parameters,
               &success);
  return success;
}

}  // namespace vantage
