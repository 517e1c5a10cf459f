#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "bus/event_log_reader.h"
#include "bus/sequence_tracker.h"
#include "tools/log/event_type.h"

namespace vantage {

/// What a log's first event says of the log.
struct LogOrigin {
  std::string version;      ///< of the program that wrote it
  int64_t seed = 0;         ///< of its random numbers
  std::string config_hash;  ///< of its configuration, as in PROCESS_STATUS; empty: none
  std::string newer;        ///< not empty: the header is of a type not known here; which
};

/// What is counted of a channel, or of all.
struct ChannelSummary {
  std::string type;  ///< as EventTypes::Name; "(several)"
  int64_t num_events = 0;
  int64_t num_bytes = 0;      ///< of data
  int64_t largest_bytes = 0;  ///< of one message
  int64_t first_utime = 0;    ///< us, smallest
  int64_t last_utime = 0;     ///< us, largest
  int64_t longest_gap = 0;    ///< us, from an event to the next
  int64_t gap_utime = 0;      ///< us, where it begins
  int64_t num_lost = 0;       ///< by gaps of seq
  bool has_seq = false;

  /// 0 where there is none.
  [[nodiscard]] double RateHz() const;
  void Count(int64_t utime, size_t data_bytes);
};

/// Counts the events of a log, in bounded memory.
class LogSummary {
 public:
  struct Restart {
    std::string sender;
    int64_t utime = 0;
  };
  static constexpr size_t kMaxChannels = 5000;  ///< told apart; the others are "(others)"
  static constexpr size_t kMaxRestarts = 100;   ///< listed

  void Add(const LogEventView& event);

  [[nodiscard]] const std::map<std::string, ChannelSummary, std::less<>>& channels() const {
    return channels_;
  }
  [[nodiscard]] const ChannelSummary& all() const { return all_; }
  /// Events that are earlier than the one before.
  [[nodiscard]] int64_t num_out_of_order() const { return num_out_of_order_; }
  /// Senders whose count went back: they started anew.
  [[nodiscard]] const std::vector<Restart>& restarts() const { return restarts_; }
  /// Nothing when no event is on LOG_HEADER.
  [[nodiscard]] const std::optional<LogOrigin>& origin() const { return origin_; }

 private:
  void CountSeq(const LogEventView& event, ChannelSummary* channel);
  void ReadOrigin(const LogEventView& event);

  EventTypes types_;
  std::map<std::string, ChannelSummary, std::less<>> channels_;
  ChannelSummary all_;
  int64_t previous_utime_ = 0;  // us
  int64_t num_out_of_order_ = 0;
  SequenceTracker sequence_;
  std::unordered_map<std::string, int64_t> last_seq_;  // By sender.
  std::vector<Restart> restarts_;
  std::optional<LogOrigin> origin_;
};

}  // namespace vantage
