#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/rng.h"
#include "perception/segmentation/border_marker.h"
#include "perception/segmentation/cluster.h"
#include "perception/segmentation/foreground.h"
#include "perception/segmentation/part_splitter.h"
#include "perception/segmentation/pixel_runs.h"
#include "perception/segmentation/plane_finder.h"
#include "perception/segmentation/segmentation_parameters.h"
#include "perception/segmentation/support_plane.h"

namespace vantage {

/// What an image falls into. Objects that touch make one connected cluster; where its surface is
/// concave it has parts, which share out all of its pixels, as alternatives to it.
struct Segmentation {
  static constexpr int32_t kNoCluster = -1;

  std::vector<SupportPlane> planes;  ///< Most points first; walls too.
  /// Connected clusters, largest first, equal ones by their first pixel; each is followed by its
  /// parts, of which there are none or more than one, in the same order.
  std::vector<Cluster> clusters;
  /// Per pixel: of the smallest segment that holds it, or kNoCluster. Parts of a cluster have
  /// consecutive labels, so that Cluster::Holds tells what belongs to either.
  std::vector<int32_t> labels;
};

/// Finds clusters of points above support planes, or of all points when there is none. Owns its
/// buffers and its result: allocates nothing once warm.
class Segmenter {
 public:
  explicit Segmenter(const SegmentationParameters& parameters);

  /// Valid until the next call. The same for equal input and state of `rng`.
  /// @param depth of the camera's width and height; the camera is valid.
  const Segmentation& Segment(const DepthImage& depth, const CameraModel& camera, Rng& rng);

 private:
  Cluster& AddCluster();
  void SortRuns(int num_clusters);
  void AddWhole(std::span<const PixelRun> runs, int width);
  void AddParts(int count, int width);
  void SetLabels(size_t num_pixels);

  SegmentationParameters parameters_;
  PlaneFinder planes_;
  Foreground foreground_;
  PixelRuns runs_;
  PartSplitter splitter_;
  BorderMarker border_;
  Segmentation result_;
  std::vector<Cluster> spare_;  // With buffers for pixels.
  std::vector<PixelRun> sorted_runs_;
  std::vector<uint32_t> run_begin_;  // Of each cluster in sorted_runs_; one more at the end.
  std::vector<int32_t> part_size_, part_order_;
};

/// The same of one image alone.
Segmentation Segment(const DepthImage& depth,
                     const CameraModel& camera,
                     const SegmentationParameters& parameters,
                     Rng& rng);

}  // namespace vantage
