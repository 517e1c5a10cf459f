#pragma once

#include <Eigen/Core>

#include "tools/support/png_image.h"
#include "tools/support/recorded_run.h"
#include "tools/support/report_setup.h"

namespace vantage {

enum class SceneCut {
  kObjects,  ///< Close: the objects fill the picture.
  kCameras,  ///< Wide: the camera's places and its way too.
};

/// The scene from outside: table, and objects where they were found.
RgbImage ScenePicture(const RecordedRun& run, const ReportSetup& setup, SceneCut cut);

/// A view's depth in false color with the outlines of the estimates after it. The log has its image
/// and the camera's calibration.
RgbImage ViewPicture(const RecordedRun& run, const RunView& view, const ReportSetup& setup);

/// An orientation histogram on the sphere (paper 4.1, figure 3), the side of `towards` first. Cells
/// that are none of the grid's are left out.
RgbImage HistogramPicture(const orientation_histogram_t& histogram, const Eigen::Vector3d& towards);

/// A side of the sphere from which the final peak of an object is well seen.
Eigen::Vector3d HistogramSide(const RecordedRun& run, int32_t instance);

/// Place of an estimate in the final list, for colors that stay the same in all pictures.
size_t ColorIndex(const RecordedRun& run, int32_t instance);

}  // namespace vantage
