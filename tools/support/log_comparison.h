#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "common/result.h"
#include "tools/support/message_comparison.h"

namespace vantage {

/// A message of one log that is not, or not within the tolerances, in the other.
struct EventDifference {
  std::string channel;
  int64_t first_event = -1;   ///< number in its log; -1: it has none
  int64_t second_event = -1;  ///< likewise
  int64_t utime = 0;          ///< us, the message's own; 0: it has none
  int64_t seq = 0;
  std::optional<FieldDifference> field;  ///< nothing where only one log has the message

  /// One line for people. @param names of the logs, as "recorded" and "recomputed".
  [[nodiscard]] std::string Describe(const std::array<std::string, 2>& names) const;
};

struct ChannelComparison {
  std::array<int64_t, 2> count{};    ///< messages of the first and the second log
  std::array<int64_t, 2> repeats{};  ///< of these, sent once more unchanged, and not compared
  int64_t late = 0;          ///< messages of the second log that the first one ended too early for
  int64_t matched = 0;       ///< pairs
  int64_t identical = 0;     ///< of these, bit for bit
  int64_t within = 0;        ///< of these, within the tolerances
  double position_mm = 0.0;  ///< largest differences
  double angle_deg = 0.0;
  double number = 0.0;
  std::optional<EventDifference> first;

  [[nodiscard]] bool clean() const;
};

struct LogComparison {
  std::map<std::string, ChannelComparison> channels;
  std::array<std::string, 2> damage;  ///< of the logs, in words; empty: none

  /// Every message has its match within the tolerances, and no log is damaged.
  [[nodiscard]] bool clean() const;
  [[nodiscard]] int64_t num_compared() const;
  /// The earliest by the messages' own time; null: there is none.
  [[nodiscard]] const EventDifference* first() const;
};

/// Compares the messages of two logs, in bounded memory. Those of one channel go together by their
/// utime (where that is 0 or absent by seq) and instance id, the first of equal ones with the
/// first; the order within a channel is taken to be the same. A message with a seq that repeats the
/// last one of its channel byte by byte counts as sent once.
/// @param channels regular expression for the whole name.
/// Errors: the logs, or `channels`.
inline constexpr int64_t kAnswerTime_us = 2'000'000;
Result<LogComparison> CompareLogs(const std::filesystem::path& first,
                                  const std::filesystem::path& second,
                                  const std::string& channels,
                                  const ComparisonTolerance& tolerance);

/// A table of the channels, what was not compared, and the first difference, for people.
std::string ComparisonText(const LogComparison& comparison,
                           const std::array<std::string, 2>& names);

}  // namespace vantage
