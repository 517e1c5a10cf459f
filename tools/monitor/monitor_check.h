#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tools/monitor/expected_setup.h"
#include "tools/monitor/monitor_model.h"

namespace vantage {

/// What is still well.
struct MonitorLimits {
  double max_silence = 3.0;  ///< s without a status, of processes and cameras, which come at 1 Hz
  int64_t max_lost = 0;      ///< messages of one channel
  int64_t max_decode_errors = 0;            ///< of one channel
  double max_missed = 0.1;                  ///< share of a camera's frames that never came
  double max_camera_latency = 1.0;          ///< s, from exposure to publication
  std::map<std::string, double> max_p99{};  ///< s, by stage
};

/// One sentence for each thing that is wrong at `now` or went wrong while it was watched; empty:
/// all is well. What comes from outside is made fit to be shown.
/// @param now us since the epoch, on the clock of the model.
std::vector<std::string> FindProblems(const MonitorModel& model,
                                      const ExpectedSetup& expected,
                                      const MonitorLimits& limits,
                                      int64_t now);

/// "streaming"; "in an unknown state" for numbers that are no state.
std::string CameraStateText(int state);
std::string ArmStateText(int state);
std::string HandEyeStateText(int state);

}  // namespace vantage
