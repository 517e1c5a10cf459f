#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bus/live_bus.h"
#include "common/result.h"
#include "tools/monitor/monitor_model.h"

namespace vantage {

/// What an own visit to the bus told.
struct BusProbe {
  std::optional<Error> error;  ///< why it could not be visited; then the rest says nothing
  std::string url;
  int num_sent = 0;
  int num_returned = 0;     ///< of these, heard again
  double round_trip = 0.0;  ///< s, median
  int requested = 0;        ///< bytes of receive buffer
  int granted = 0;          ///< bytes, as they were asked for
  MonitorModel model;       ///< what was heard for 1.5 s
  int64_t utime = 0;        ///< us since the epoch, at the end
  /// By process name: the holder's process id; 0: held, but by whom is not known.
  std::map<std::string, int> holders;
};

/// Opens the bus, sends messages to itself, listens, and looks which of the `names` are held by a
/// running process.
BusProbe ProbeBus(LiveBus::Options options, const std::vector<std::string>& names);

}  // namespace vantage
