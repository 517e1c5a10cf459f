#pragma once

#include <cstdint>
#include <vector>

#include "common/depth_rasterizer.h"

namespace vantage {

/// Pixels that may be one object: a connected cluster, or a part of one.
struct Cluster {
  std::vector<uint32_t> pixels;  ///< Indices into the image, ascending.
  PixelWindow window;            ///< Smallest that holds them.
  bool touches_border = false;   ///< The object may reach out of the image.
  int parent = -1;               ///< Index of the cluster that this is a part of; -1: it is whole.
  int32_t first_label = 0;       ///< Its pixels carry the labels first_label ... last_label,
  int32_t last_label = 0;        ///< and no others do.

  /// True when a pixel of this label (Segmentation::labels) belongs to the cluster.
  [[nodiscard]] bool Holds(int32_t label) const {
    return label >= first_label && label <= last_label;
  }
};

}  // namespace vantage
