#pragma once

#include <optional>
#include <string>

namespace vantage {

/// What `vantage-handeye live` is asked.
struct LiveArguments {
  std::string config;  ///< TOML file of the set-up, with a table [extrinsics]
  std::string url;     ///< LCM URL; empty: [bus] url, then LCM_DEFAULT_URL
  /// Where the set-up is simulated: fail when the result is farther from the truth than this.
  std::optional<double> max_error_mm;
  std::optional<double> max_error_deg;
};

/// Calibrates with the robot that is on the bus, and writes the file that [extrinsics] names.
/// @return the exit code: 0; 1 when the motions did not fix the calibration or the error is too
/// large; 2 after an error, which is printed as one sentence.
int RunLive(const LiveArguments& arguments);

}  // namespace vantage
