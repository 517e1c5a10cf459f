#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/result.h"

namespace vantage {

/// Who should speak, by the configuration.
struct ExpectedSetup {
  std::vector<std::string> processes;  ///< names on the bus, of our live processes
  std::vector<std::string> cameras;    ///< the <NAME>s
  std::string config_hash;             ///< of the file; empty: none was given
};

/// Errors: what a process refuses in the file; a program that is not there.
Result<ExpectedSetup> ReadExpectedSetup(const std::filesystem::path& config);

}  // namespace vantage
