#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "bus/channel_pattern.h"
#include "bus/event_log.h"
#include "common/result.h"

namespace vantage {

/// The events of a log that somebody wants, in the order of their time as far as a bounded window
/// reaches. Events that are in order, and those of equal times, stay as they stand.
class EventStream {
 public:
  struct Options {
    std::string channels;               ///< regular expression for the whole name; empty: all
    std::optional<int64_t> from_utime;  ///< us; events before it are left out
    std::optional<int64_t>
        to_utime;  ///< us; events after it are left out; many of them in a row: the end
    /// us; events that stand at most this long after later ones are put in order. 0: none.
    int64_t window_us = 0;
    size_t window_bytes = 64U << 20U;  ///< of events that wait; with more the window is shorter
  };

  struct Counters {
    int64_t num_sorted = 0;  ///< put in order
    /// Times that the log went back by more than the window: a clock was set, or another recording
    /// begins. What follows is taken as it stands.
    int64_t num_late = 0;
    double largest_step_back = 0.0;     ///< s
    std::optional<int64_t> late_event;  ///< number of the first event that was late
  };

  static constexpr size_t kMostChannels = 200;  ///< remembered
  static constexpr int kMostBeyond = 100;       ///< events after `to_utime` in a row

  /// Errors: `channels` is no regular expression.
  static Result<std::unique_ptr<EventStream>> Create(const Options& options,
                                                     std::unique_ptr<EventLogReader> reader);

  /// The next event that is wanted; nothing at the end.
  std::optional<LogEvent> Next();

  [[nodiscard]] const Counters& counters() const { return counters_; }
  /// Channels that were met, some of them not wanted.
  [[nodiscard]] const std::set<std::string>& channels() const { return channels_; }
  [[nodiscard]] const EventLogReader& reader() const { return *reader_; }

 private:
  EventStream(const Options& options, std::unique_ptr<EventLogReader> reader)
      : options_(options), reader_(std::move(reader)) {}

  std::optional<LogEvent> Read();
  void Take(LogEvent event);
  std::optional<LogEvent> Release();

  Options options_;
  std::unique_ptr<EventLogReader> reader_;
  std::optional<ChannelPattern> wanted_;
  std::set<std::string> channels_;
  bool at_end_ = false;
  int num_beyond_ = 0;
  // Events that wait, by utime and arrival.
  std::map<std::pair<int64_t, int64_t>, LogEvent> waiting_;
  size_t waiting_bytes_ = 0;
  int64_t arrivals_ = 0;
  int64_t newest_utime_ = 0;           // Of this pass.
  std::optional<LogEvent> next_pass_;  // Its first event, while those before still wait.
  Counters counters_;
};

}  // namespace vantage
