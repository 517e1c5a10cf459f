#pragma once

#include <span>
#include <vector>

#include "common/depth_image.h"
#include "perception/segmentation/cluster.h"

namespace vantage {

/// Tells which clusters may reach out of the image: those with a pixel less than kNear px from the
/// border, or less than kFar px with nothing measured between (sensors lose a strip there).
class BorderMarker {
 public:
  static constexpr int kNear = 3;  ///< px
  static constexpr int kFar = 16;  ///< px

  /// Sets Cluster::touches_border of each.
  void Mark(const DepthImage& depth, std::span<Cluster> clusters);

 private:
  void FindFirst(const DepthImage& depth);
  [[nodiscard]] bool IsAtBorder(const DepthImage& depth, int u, int v) const;

  // Pixels without measurement before the first with one, from each border, at most kFar.
  std::vector<int> left_, right_, top_, bottom_;
};

}  // namespace vantage
