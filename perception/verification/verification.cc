#include "perception/verification/verification.h"

#include <algorithm>
#include <cmath>

#include "common/check.h"
#include "common/format.h"
#include "common/simd.h"
#include "perception/verification/compare.h"

namespace vantage {
namespace {

// Of `count` pixels those that are marked and carry one of the labels.
VANTAGE_SIMD int CountMarked(
    const uint8_t* marks, const int32_t* labels, size_t count, int32_t first, int32_t last) {
  int sum = 0;
  for (size_t i = 0; i < count; ++i) {
    sum += static_cast<int>(marks[i]) & static_cast<int>(labels[i] >= first) &
           static_cast<int>(labels[i] <= last);
  }
  return sum;
}

// Where the model was drawn, in pixels of the level.
PixelWindow DrawnWindow(const ModelView& view) {
  const PixelWindow& drawn = view.touched();
  const int i0 = view.u0() / view.step();
  const int j0 = view.v0() / view.step();
  return {drawn.u0 + i0, drawn.v0 + j0, drawn.u1 + i0, drawn.v1 + j0};
}

PixelWindow Widened(const PixelWindow& window, int by) {
  return {window.u0 - by, window.v0 - by, window.u1 + by, window.v1 + by};
}

// Pixels of the cluster that the model reaches, but for the silhouette's uncertainty.
int CountReached(const ObservedImage::Level& level,
                 const Cluster& cluster,
                 int reach,
                 ModelView* view) {
  const ModelView::Reached reached = view->Reach(reach);
  const PixelWindow window = Widened(DrawnWindow(*view), reach);
  const int j0 = window.v0 - reached.window.v0;
  const int first = std::max(window.u0, 0);
  const int last = std::min(window.u1, level.width - 1);
  int count = 0;
  for (int j = std::max(window.v0, 0); j <= std::min(window.v1, level.height - 1); ++j) {
    count += CountMarked(reached.row(j - j0) + (first - window.u0),
                         &level.labels[level.Index(first, j)],
                         static_cast<size_t>(last - first + 1),
                         cluster.first_label,
                         cluster.last_label);
  }
  return count;
}

CompareJob MakeJob(const ObservedImage& image,
                   const ObservedImage::Level& level,
                   const VerificationParameters& parameters,
                   const ModelView& view) {
  const CameraModel& camera = image.image().camera;
  const PixelWindow& drawn = view.touched();
  const PixelWindow window = DrawnWindow(view);
  const size_t drawn_first = view.Index(drawn.u0, drawn.v0);
  const size_t first = level.Index(window.u0, window.v0);
  CompareJob job{};
  job.columns = window.u1 - window.u0 + 1;
  job.rows = window.v1 - window.v0 + 1;
  job.inverse_depth = view.inverse_depth() + drawn_first;
  job.triangles = view.triangles() + drawn_first;
  job.plane_distance = view.plane_distance();
  job.drawn_stride = view.stride();
  job.depth = level.depth.data() + first;
  job.nearest = level.nearest.data() + first;
  job.farthest = level.farthest.data() + first;
  job.labels = level.labels.data() + first;
  job.stride = level.stride;
  job.image = image.image().depth.depth.data();
  job.image_width = camera.width;
  job.image_height = camera.height;
  job.step = view.step();
  job.u0 = window.u0 * job.step;
  job.v0 = window.v0 * job.step;
  job.edge_px = image.edge_px();
  job.ray_x = static_cast<float>((job.u0 - camera.cx) / camera.fx);
  job.ray_y = static_cast<float>((job.v0 - camera.cy) / camera.fy);
  job.ray_dx = static_cast<float>(job.step / camera.fx);
  job.ray_dy = static_cast<float>(job.step / camera.fy);
  const DepthNoise& noise = parameters.noise;
  job.axial_base = static_cast<float>(noise.axial_base);
  job.axial_quadratic = static_cast<float>(noise.axial_quadratic);
  job.axial_offset = static_cast<float>(noise.axial_offset);
  job.lateral = static_cast<float>(noise.Lateral(1.0, camera.fx));
  job.model_variance = static_cast<float>(parameters.model_error * parameters.model_error);
  job.squared_sigmas = static_cast<float>(parameters.inlier_sigmas * parameters.inlier_sigmas);
  job.outlier_cost = parameters.outlier_cost;
  job.missing_cost = static_cast<float>(parameters.missing_cost);
  job.foreign_gain = parameters.foreign_gain;
  job.bound = std::numeric_limits<double>::infinity();
  return job;
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
  if (!(min_score >= 0.0 && min_score <= 1.0) || !(min_visible >= 0.0 && min_visible <= 1.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("verification: min_score = %g and min_visible = %g, expected 0 to 1",
                        min_score,
                        min_visible)};
  }
  if (!(outlier_cost > 0.0) || !(missing_cost >= 0.0) || !(foreign_gain >= 0.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("verification: outlier_cost = %g (expected above 0), missing_cost = %g and "
                        "foreign_gain = %g (expected 0 or more)",
                        outlier_cost,
                        missing_cost,
                        foreign_gain)};
  }
  return {};
}

Verification Verify(const ModelShape& model,
                    const Pose& T_camera_object,
                    ObservedImage* image,
                    size_t cluster,
                    int step,
                    const VerificationParameters& parameters,
                    ModelView* view,
                    double bound) {
  VANTAGE_CHECK(image->edge_px() == parameters.edge_px, "image taken up with the same edge_px");
  const CameraModel& camera = image->image().camera;
  const Cluster& own = image->image().segmentation.clusters[cluster];
  Verification result;
  view->Render(
      model.mesh, T_camera_object, camera, ModelWindow(camera, model, T_camera_object), step);
  result.unexplained = image->ClusterSize(step, cluster);
  if (view->empty()) {
    result.cost = parameters.outlier_cost * result.unexplained;
    return result;
  }
  const int reach = parameters.edge_px / step;
  const ObservedImage::Level& level = image->Prepare(step, Widened(DrawnWindow(*view), reach));
  result.unexplained -= CountReached(level, own, reach, view);
  result.cost = parameters.outlier_cost * result.unexplained;
  if (result.cost > bound) return result;
  CompareJob job = MakeJob(*image, level, parameters, *view);
  job.first_label = own.first_label;
  job.last_label = own.last_label;
  job.bound = bound;
  const Compared compared = Compare(job, result.cost, view->path());
  result.inliers = compared.inliers;
  result.occluded = compared.occluded;
  result.seen_through = compared.seen_through;
  result.in_front = compared.in_front;
  result.missing = compared.missing;
  result.edge = compared.edge;
  result.cost = compared.cost;
  if (result.inliers > 0) result.mse = compared.squared / result.inliers;
  return result;
}

Verification Verify(const ModelShape& model,
                    const Pose& T_camera_object,
                    const SegmentedImage& image,
                    size_t cluster,
                    int step,
                    const VerificationParameters& parameters,
                    ModelView* view) {
  ObservedImage observed;
  observed.Reset(image, parameters.edge_px);
  return Verify(model, T_camera_object, &observed, cluster, step, parameters, view);
}

void MarkExplained(const ModelShape& model,
                   const Pose& T_camera_object,
                   ObservedImage* image,
                   const VerificationParameters& parameters,
                   ModelView* view,
                   std::vector<uint8_t>* explained) {
  const CameraModel& camera = image->image().camera;
  VANTAGE_CHECK(explained->size() == image->image().depth.depth.size(), "a mark for each pixel");
  view->Render(model.mesh, T_camera_object, camera, ModelWindow(camera, model, T_camera_object), 1);
  if (view->empty()) return;
  CompareJob job = MakeJob(*image, image->Prepare(1, DrawnWindow(*view)), parameters, *view);
  job.explained = explained->data();
  Compare(job, 0.0, view->path());
}

void MarkExplained(const ModelShape& model,
                   const Pose& T_camera_object,
                   const SegmentedImage& image,
                   const VerificationParameters& parameters,
                   ModelView* view,
                   std::vector<uint8_t>* explained) {
  ObservedImage observed;
  observed.Reset(image, parameters.edge_px);
  MarkExplained(model, T_camera_object, &observed, parameters, view, explained);
}

}  // namespace vantage
