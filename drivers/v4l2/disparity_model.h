#pragma once

#include <array>
#include <cstdint>

#include "common/result.h"

namespace vantage {

/// What the raw disparity of a structured-light camera says of the distance. The camera counts d in
/// steps from a reference plane, so that with the disparity (offset - d) / steps_per_px
///   z = baseline * focal length / ((offset - d) / steps_per_px)
/// The values are the nominal ones of the first Kinect (Konolige and Mihelich, "Technical
/// description of Kinect calibration", 2011).
struct DisparityModel {
  double baseline_mm = 75.0;  ///< mm, from the projector to the camera
  double focal_px = 580.0;    ///< px, of the infrared camera at the width of the depth image
  double offset = 1090.0;     ///< steps; d of what is infinitely far
  double steps_per_px = 8.0;  ///< steps

  /// Errors: a value out of its range.
  [[nodiscard]] Result<void> Validate() const;
  /// mm; 0: d is no distance, or one beyond 65535 mm.
  [[nodiscard]] uint16_t DepthMm(int d) const;
};

/// DepthMm() of every value of ten bits; of the highest, with which the camera says that it sees
/// nothing, 0.
std::array<uint16_t, 1024> DisparityTable(const DisparityModel& model);

}  // namespace vantage
