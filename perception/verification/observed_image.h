#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/depth_rasterizer.h"
#include "perception/segmentation/segmentation.h"

namespace vantage {

/// An image with its segments.
struct SegmentedImage {
  const DepthImage& depth;
  const CameraModel& camera;
  const Segmentation& segmentation;
};

/// A segmented image made ready for many hypotheses to be held against it: what they all need of
/// it is computed once, and only for the windows and steps in which it is asked for. Allocates
/// nothing once warm.
class ObservedImage {
 public:
  /// Every `step`-th pixel of rows and columns; pixel (i, j) is the image's (i step, j step).
  struct Level {
    int step = 1;
    int width = 0;                  ///< px; 0: of an earlier image
    int height = 0;                 ///< px
    size_t stride = 0;              ///< of rows; eight values from any pixel on may be read
    std::vector<float> depth;       ///< m; 0 where nothing finite was measured
    std::vector<float> nearest;     ///< m, least depth around; infinite where nothing was measured
    std::vector<float> farthest;    ///< m, greatest depth around; minus infinity
    std::vector<int32_t> labels;    ///< Segmentation::labels
    PixelWindow prepared;           ///< Pixels in which the values hold
    std::vector<int> cluster_size;  ///< px, of each cluster; -1: not counted yet

    [[nodiscard]] size_t Index(int i, int j) const {
      return static_cast<size_t>(j) * stride + static_cast<size_t>(i);
    }
  };

  /// Takes up an image; what it refers to must stay as it is until the next call.
  /// @param edge_px how far around a pixel `nearest` and `farthest` look, in the image's pixels.
  void Reset(const SegmentedImage& image, int edge_px);

  /// The level of a step, with at least `window` (its pixels; cut to the level) prepared. Valid
  /// until the next call.
  const Level& Prepare(int step, const PixelWindow& window);
  /// Pixels of a level that belong to a cluster.
  int ClusterSize(int step, size_t cluster);

  [[nodiscard]] const SegmentedImage& image() const { return *image_; }
  [[nodiscard]] int edge_px() const { return edge_px_; }

 private:
  Level& Find(int step);
  void Fill(const PixelWindow& window, Level* level);
  void FillRange(int first, int last, int row, Level* level);

  std::optional<SegmentedImage> image_;
  int edge_px_ = 0;
  std::vector<Level> levels_;
  std::vector<float> low_;       // Scratch: a row's least depths over the rows around it.
  std::vector<float> high_;      // Scratch: greatest depths.
  std::vector<float> least_;     // Scratch: of these, the least over the columns around.
  std::vector<float> greatest_;  // Scratch.
};

}  // namespace vantage
