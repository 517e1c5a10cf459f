#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tools/monitor/monitor_model.h"

namespace vantage {

/// By what channels are ordered, the most of it first; names alphabetically.
enum class ChannelOrder { kName, kRate, kBandwidth, kLost, kAge, kJitter };

/// What the user has asked to see.
struct ScreenState {
  ChannelOrder order = ChannelOrder::kName;
  bool is_paused = false;
  bool shows_process = false;  ///< the selected one alone, with its channels and stages
  size_t selected = 0;         ///< of the processes by name
  size_t first_line = 0;       ///< of the list that scrolls
  bool wants_to_quit = false;
};

/// Applies what was typed: q, s, p or space, arrows or j and k, Enter, Escape, Page Up and Down.
/// Anything else does nothing.
void ApplyKeys(std::string_view typed, size_t num_processes, ScreenState* state);

struct ScreenSize {
  size_t rows = 24;
  size_t columns = 80;
};

/// A line of printable ASCII, no longer than the screen is wide.
struct ScreenLine {
  enum class Style { kPlain, kHeading, kWrong, kSelected };
  std::string text;
  Style style = Style::kPlain;
};

/// All that the screen shows: at most size.rows lines, of at most size.columns characters.
/// @param where the URL or the log. @param problems of FindProblems().
std::vector<ScreenLine> DrawScreen(const MonitorModel& model,
                                   const std::vector<std::string>& problems,
                                   const std::string& where,
                                   const ScreenState& state,
                                   ScreenSize size,
                                   int64_t now);

/// Everything, for a file or a pipe: every process with its channels and stages, and every channel.
std::vector<ScreenLine> DrawSnapshot(const MonitorModel& model,
                                     const std::vector<std::string>& problems,
                                     const std::string& where,
                                     ChannelOrder order,
                                     int64_t now);

}  // namespace vantage
