#pragma once

#include <filesystem>
#include <string>

#include "common/result.h"
#include "tools/monitor/doctor_finding.h"
#include "tools/monitor/system_view.h"

namespace vantage {

struct DoctorRequest {
  std::filesystem::path config;    ///< empty: the machine alone is looked at
  std::string url;                 ///< LCM's; empty: of the configuration, as LiveBus has it
  std::filesystem::path programs;  ///< folder of our programs
};

/// All checks, in the order of what rests on what. Takes about four seconds.
/// Errors: there is no such config file; the URL is malformed.
Result<DoctorFindings> Diagnose(const SystemView& system, const DoctorRequest& request);

}  // namespace vantage
