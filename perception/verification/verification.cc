#include "perception/verification/verification.h"

#include <algorithm>
#include <cmath>

#include "common/format.h"

namespace vantage {
namespace {

// True when a pixel near (u, v) measures `depth` within `tolerance`: the silhouette is uncertain.
bool MeasuredNearby(
    const DepthImage& image, int u, int v, int reach, double depth, double tolerance) {
  for (int dv = -reach; dv <= reach; ++dv) {
    for (int du = -reach; du <= reach; ++du) {
      if (!image.Contains(u + du, v + dv)) continue;
      if (std::abs(static_cast<double>(image.at(u + du, v + dv)) - depth) <= tolerance) return true;
    }
  }
  return false;
}

// Standard deviation along the line of sight at a surface seen under a cosine.
double SigmaAlongRay(const VerificationParameters& parameters,
                     double focal,
                     double depth,
                     double cosine) {
  constexpr double kSteepest = 5.0;  // Tangent; steeper surfaces are silhouettes.
  const double tangent =
      std::min(std::sqrt(std::max(1.0 - cosine * cosine, 0.0)) / std::max(cosine, 1e-3), kSteepest);
  const double axial = parameters.noise.Axial(depth);
  const double lateral = parameters.noise.Lateral(depth, focal) * tangent;
  return std::sqrt(axial * axial + lateral * lateral +
                   parameters.model_error * parameters.model_error);
}

}  // namespace

Result<void> VerificationParameters::Validate() const {
  if (!(inlier_sigmas > 0.0) || !(model_error >= 0.0) || edge_px < 0 || edge_px > 20 ||
      coarse_step < 1 || coarse_step > 32) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("verification: inlier_sigmas = %g (expected above 0), model_error = %g m "
                        "(expected 0 or more), edge_px = %d (expected 0 to 20), coarse_step = %d "
                        "(expected 1 to 32)",
                        inlier_sigmas,
                        model_error,
                        edge_px,
                        coarse_step)};
  }
  if (!(min_score >= 0.0 && min_score <= 1.0) || !(outlier_cost > 0.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("verification: min_score = %g (expected 0 to 1), outlier_cost = %g "
                        "(expected above 0)",
                        min_score,
                        outlier_cost)};
  }
  return {};
}

Verification Verify(const ModelShape& model,
                    const Pose& T_camera_object,
                    const SegmentedImage& image,
                    size_t cluster,
                    int step,
                    const VerificationParameters& parameters,
                    ModelView* view) {
  const CameraModel& camera = image.camera;
  const std::vector<int32_t>& labels = image.segmentation.labels;
  const auto own = static_cast<int32_t>(cluster);
  const Eigen::Matrix3f R = T_camera_object.linear().cast<float>();
  Verification result;
  double squared = 0.0;
  view->Render(
      model.mesh, T_camera_object, camera, ModelWindow(camera, model, T_camera_object), step);
  view->ForEachPixel([&](const ModelView::Pixel& pixel) {
    const size_t index = image.depth.Index(pixel.u, pixel.v);
    const auto measured = static_cast<double>(image.depth.depth[index]);
    if (!(measured > 0.0)) {
      ++result.missing;
      return;
    }
    const auto rendered = static_cast<double>(pixel.depth);
    const Eigen::Vector3f ray = camera.Unproject(pixel.u, pixel.v, 1.0).cast<float>();
    const Eigen::Vector3f normal = VisibleNormal(model.mesh, R, pixel.triangle, ray);
    const auto along = static_cast<double>(-normal.dot(ray));
    const double cosine = along / static_cast<double>(ray.norm());
    const double sigma = SigmaAlongRay(parameters, camera.fx, rendered, cosine);
    const double tolerance = parameters.inlier_sigmas * sigma;
    const double error = measured - rendered;
    if (std::abs(error) <= tolerance) {
      ++result.inliers;
      squared += error * error * along * along;
      result.cost += 0.5 * error * error / (sigma * sigma);
    } else if (error < 0.0 && labels[index] != own && labels[index] >= 0) {
      ++result.occluded;
    } else if (MeasuredNearby(
                   image.depth, pixel.u, pixel.v, parameters.edge_px, rendered, tolerance)) {
      ++result.edge;
      result.cost += 1.0;
    } else {
      ++(error < 0.0 ? result.in_front : result.seen_through);
      result.cost += parameters.outlier_cost;
    }
  });
  for (const uint32_t index : image.segmentation.clusters[cluster].pixels) {
    const int u = static_cast<int>(index) % camera.width;
    const int v = static_cast<int>(index) / camera.width;
    if (u % step != 0 || v % step != 0 || view->Shows(u, v, parameters.edge_px)) continue;
    ++result.unexplained;
    result.cost += parameters.outlier_cost;
  }
  if (result.inliers > 0) result.mse = squared / result.inliers;
  return result;
}

}  // namespace vantage
