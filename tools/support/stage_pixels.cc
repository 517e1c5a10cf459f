#include "tools/support/stage_pixels.h"

#include <algorithm>
#include <cmath>

namespace vantage {
namespace {

bool IsMeasured(float depth) { return std::isfinite(depth) && depth > 0.0F; }

// Along the line of sight, m: as Verify's.
double Tolerance(const ModelView::Pixel& pixel,
                 const CameraModel& camera,
                 const VerificationParameters& parameters) {
  constexpr double kSteepest = 5.0;  // Tangent; steeper surfaces are silhouettes.
  const auto depth = static_cast<double>(pixel.depth);
  const double along = static_cast<double>(pixel.plane_distance) / depth;
  const double cosine2 = along * along / camera.Unproject(pixel.u, pixel.v, 1.0).squaredNorm();
  const double tangent2 =
      std::min(std::max(1.0 - cosine2, 0.0) / std::max(cosine2, 1e-6), kSteepest * kSteepest);
  const double axial = parameters.noise.Axial(depth);
  const double lateral = parameters.noise.Lateral(depth, camera.fx);
  const double variance = axial * axial + lateral * lateral * tangent2 +
                          parameters.model_error * parameters.model_error;
  return parameters.inlier_sigmas * std::sqrt(variance);
}

bool IsMeasuredNearby(const DepthImage& image,
                      const ModelView::Pixel& pixel,
                      int reach,
                      double tolerance) {
  for (int v = pixel.v - reach; v <= pixel.v + reach; ++v) {
    for (int u = pixel.u - reach; u <= pixel.u + reach; ++u) {
      if (!image.Contains(u, v) || !IsMeasured(image.at(u, v))) continue;
      if (static_cast<double>(std::abs(image.at(u, v) - pixel.depth)) <= tolerance) return true;
    }
  }
  return false;
}

// Of a pixel that shows the model and is no inlier.
PixelRole RoleOfDrawn(const ModelView::Pixel& pixel,
                      const SegmentedImage& image,
                      const Cluster& cluster,
                      const VerificationParameters& parameters) {
  const size_t at = image.depth.Index(pixel.u, pixel.v);
  const float measured = image.depth.depth[at];
  if (!IsMeasured(measured)) return PixelRole::kMissing;
  const int32_t label = image.segmentation.labels[at];
  const bool is_nearer = measured < pixel.depth;
  if (is_nearer && label >= 0 && !cluster.Holds(label)) return PixelRole::kOccluded;
  const double tolerance = Tolerance(pixel, image.camera, parameters);
  if (IsMeasuredNearby(image.depth, pixel, parameters.edge_px, tolerance)) return PixelRole::kEdge;
  return is_nearer ? PixelRole::kInFront : PixelRole::kSeenThrough;
}

}  // namespace

std::vector<PixelRole> FindPixelRoles(const ModelShape& model,
                                      const Pose& T_camera_object,
                                      const SegmentedImage& image,
                                      size_t cluster,
                                      const VerificationParameters& parameters) {
  std::vector<PixelRole> roles(image.depth.depth.size(), PixelRole::kNone);
  std::vector<uint8_t> inliers(roles.size(), 0);
  ModelView view;
  MarkExplained(model, T_camera_object, image, parameters, &view, &inliers);
  const Cluster& own = image.segmentation.clusters[cluster];
  for (const uint32_t pixel : own.pixels) roles[pixel] = PixelRole::kUnexplained;
  if (view.empty()) return roles;
  const ModelView::Reached reached = view.Reach(parameters.edge_px);
  for (const uint32_t pixel : own.pixels) {
    const int i = static_cast<int>(pixel) % image.depth.width - view.u0();
    const int j = static_cast<int>(pixel) / image.depth.width - view.v0();
    const PixelWindow& window = reached.window;
    if (i < window.u0 || i > window.u1 || j < window.v0 || j > window.v1) continue;
    if (reached.row(j)[i - window.u0] != 0) roles[pixel] = PixelRole::kNone;
  }
  view.ForEachPixel([&](const ModelView::Pixel& pixel) {
    const size_t at = image.depth.Index(pixel.u, pixel.v);
    roles[at] = inliers[at] != 0 ? PixelRole::kInlier : RoleOfDrawn(pixel, image, own, parameters);
  });
  return roles;
}

}  // namespace vantage
