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

// What is measured where the model would be seen.
struct Comparison {
  size_t index;     // Of the pixel.
  double measured;  // m; not above 0, or NaN, where nothing is
  double rendered;  // m
  double along;     // Of a step of 1 m along z, the part along the surface's normal.
  double sigma;     // m, along z
};

Comparison Compare(const ModelShape& model,
                   const Eigen::Matrix3f& R_camera_object,
                   const ModelView::Pixel& pixel,
                   const SegmentedImage& image,
                   const VerificationParameters& parameters) {
  Comparison result{};
  result.index = image.depth.Index(pixel.u, pixel.v);
  result.measured = static_cast<double>(image.depth.depth[result.index]);
  result.rendered = static_cast<double>(pixel.depth);
  const Eigen::Vector3f ray = image.camera.Unproject(pixel.u, pixel.v, 1.0).cast<float>();
  const Eigen::Vector3f normal = VisibleNormal(model.mesh, R_camera_object, pixel.triangle, ray);
  result.along = static_cast<double>(-normal.dot(ray));
  const double cosine = result.along / static_cast<double>(ray.norm());
  result.sigma = SigmaAlongRay(parameters, image.camera.fx, result.rendered, cosine);
  return result;
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
  const Cluster& own = image.segmentation.clusters[cluster];
  const Eigen::Matrix3f R = T_camera_object.linear().cast<float>();
  Verification result;
  double squared = 0.0;
  view->Render(
      model.mesh, T_camera_object, camera, ModelWindow(camera, model, T_camera_object), step);
  view->ForEachPixel([&](const ModelView::Pixel& pixel) {
    const Comparison at = Compare(model, R, pixel, image, parameters);
    if (!(at.measured > 0.0)) {
      ++result.missing;
      return;
    }
    const double error = at.measured - at.rendered;
    const double tolerance = parameters.inlier_sigmas * at.sigma;
    if (std::abs(error) <= tolerance) {
      ++result.inliers;
      squared += error * error * at.along * at.along;
      result.cost += 0.5 * error * error / (at.sigma * at.sigma);
    } else if (error < 0.0 && !own.Holds(labels[at.index]) && labels[at.index] >= 0) {
      ++result.occluded;
    } else if (MeasuredNearby(
                   image.depth, pixel.u, pixel.v, parameters.edge_px, at.rendered, tolerance)) {
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

void MarkExplained(const ModelShape& model,
                   const Pose& T_camera_object,
                   const SegmentedImage& image,
                   const VerificationParameters& parameters,
                   ModelView* view,
                   std::vector<uint8_t>* explained) {
  const Eigen::Matrix3f R = T_camera_object.linear().cast<float>();
  view->Render(model.mesh,
               T_camera_object,
               image.camera,
               ModelWindow(image.camera, model, T_camera_object),
               1);
  view->ForEachPixel([&](const ModelView::Pixel& pixel) {
    const Comparison at = Compare(model, R, pixel, image, parameters);
    if (std::abs(at.measured - at.rendered) <= parameters.inlier_sigmas * at.sigma) {
      (*explained)[at.index] = 1;
    }
  });
}

}  // namespace vantage
