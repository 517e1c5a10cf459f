#pragma once

#include "nodes/config_reader.h"
#include "perception/calibration/calibration_target.h"

namespace vantage {

/// Reads what describes a calibration target: kind, columns, rows, size_m, gap_m, marker_m,
/// first_id, family. What does not go together shows at config.Finish() too.
void ReadTarget(ConfigReader::Table& table, CalibrationTarget* target);

}  // namespace vantage
