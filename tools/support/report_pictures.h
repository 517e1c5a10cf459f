#pragma once

#include <string>

#include "tools/support/png_image.h"
#include "tools/support/recorded_run.h"
#include "tools/support/report_setup.h"

namespace vantage {

/// The scene from outside: table, objects where they were found, the camera's places and way.
RgbImage ScenePicture(const RecordedRun& run, const ReportSetup& setup);

/// A view's depth in false color with the outlines of the estimates after it. The log has its image
/// and the camera's calibration.
RgbImage ViewPicture(const RecordedRun& run, const RunView& view, const ReportSetup& setup);

/// An orientation histogram on the sphere (paper 4.1, figure 3). k in 2..128; cells that are none
/// of the grid's are left out.
RgbImage HistogramPicture(const orientation_histogram_t& histogram);

/// Place of an estimate in the final list, for colors that stay the same in all pictures.
size_t ColorIndex(const RecordedRun& run, int32_t instance);

}  // namespace vantage
