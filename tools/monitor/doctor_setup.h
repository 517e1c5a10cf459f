#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "nodes/handeye_file.h"
#include "perception/model/object_model.h"
#include "tools/monitor/doctor_devices.h"
#include "tools/monitor/doctor_finding.h"

namespace vantage {

/// Every process of the set-up accepts the file. @param programs folder of our programs.
DoctorFinding CheckConfig(const std::filesystem::path& config,
                          const std::filesystem::path& programs);

/// The cameras of a configuration that CheckConfig() accepts; of any other as far as it can be
/// read.
std::vector<WantedCamera> ReadWantedCameras(const std::filesystem::path& config);

/// Each model of [models]: it loads, its size is plausible, its tables are there and belong to it.
DoctorFindings CheckModels(const std::filesystem::path& config);
/// An object of so many metres may stand before a depth camera.
DoctorFinding CheckModelSize(const ObjectModel& model, const std::filesystem::path& folder);

/// The hand-eye calibration of [extrinsics]; nothing without that table. @param now us since the
/// epoch.
DoctorFindings CheckExtrinsics(const std::filesystem::path& config, int64_t now);
/// Its age and its residuals.
DoctorFindings CheckCalibration(const HandEyeFile& calibration,
                                const std::filesystem::path& config,
                                int64_t now);

}  // namespace vantage
