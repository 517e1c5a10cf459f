#include "perception/segmentation/segmentation_parameters.h"

#include "common/format.h"

namespace vantage {

Result<void> SegmentationParameters::Validate() const {
  if (Result<void> valid = plane.Validate(); !valid) return valid;
  if (!(min_depth > 0.0 && max_depth > min_depth)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("segmentation: depth from %g to %g m, expected 0 < min_depth < max_depth",
                        min_depth,
                        max_depth)};
  }
  if (!(min_height >= 0.0 && max_height > min_height)) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("segmentation: height from %g to %g m, expected 0 <= min_height < max_height",
               min_height,
               max_height)};
  }
  if (!(largest_gap > 0.0) || gap_px < 0 || gap_px > 20 || min_points < 1) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("segmentation: largest_gap = %g m (expected above 0), gap_px = %d (expected "
               "0 to 20), min_points = %d (expected 1 or more)",
               largest_gap,
               gap_px,
               min_points)};
  }
  if (!(concave_angle_deg > 0.0 && concave_angle_deg <= 180.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("segmentation: concave_angle_deg = %g, expected above 0 and up to 180",
                        concave_angle_deg)};
  }
  return {};
}

}  // namespace vantage
