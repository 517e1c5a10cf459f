#pragma once

#include <string>

#include "common/result.h"
#include "tools/handeye/handeye_run.h"

namespace vantage {

/// For a terminal: X and Y with their standard deviations, residuals, how well the motions fix X,
/// outliers, refusals, the next pose, and a line for each view.
std::string HandEyeText(const HandEyeRun& run);

/// "x y z" m and "w x y z" of a pose.
std::string PoseNumbers(const Pose& pose);

/// view,rotation_deg,translation_mm,pixels,deviation,outlier,left_out_rotation_deg,
/// left_out_translation_mm
std::string ResidualsCsv(const HandEyeResult& result);

/// SVG: rotation and translation of each view against the calibration from all and from the other
/// views; outliers crossed. Errors: gnuplot is not installed or fails.
Result<std::string> ResidualFigure(const HandEyeResult& result);

/// A page of its own with the above. @param figure SVG.
std::string HandEyePage(const std::string& title, const HandEyeRun& run, const std::string& figure);

}  // namespace vantage
