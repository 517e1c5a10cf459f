#pragma once

#include <string_view>
#include <vector>

#include "common/result.h"

namespace vantage {

/// A dictionary of square markers with one ring of black cells, as OpenCV's aruco module knows it
/// (Garrido-Jurado et al., "Automatic generation and detection of highly reliable fiducial markers
/// under occlusion", Pattern Recognition 2014).
struct ArucoDictionary {
  int opencv_id = 0;  ///< of cv::aruco::PREDEFINED_DICTIONARY_NAME
  int num_markers = 0;
  int cells = 0;  ///< along a side, with the black ring

  /// Errors: an unknown name (the sentence names those that there are).
  static Result<ArucoDictionary> Find(std::string_view name);

  /// Whether cells are black, row by row. marker < num_markers.
  [[nodiscard]] std::vector<bool> BlackCells(int marker) const;
};

}  // namespace vantage
