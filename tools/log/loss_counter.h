#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>

#include "bus/sequence_tracker.h"

namespace vantage {

/// What a recording is known to have missed, by channel.
class LossCounter {
 public:
  struct Loss {
    int64_t by_seq = 0;   ///< never arrived: gaps in the sender's count
    int64_t overrun = 0;  ///< arrived, and went for later ones while the disk was too slow
    int64_t unfit = 0;    ///< no log takes them: too long
  };

  /// A message that arrived. @param num_skipped of its channel that went since the last one.
  /// @return messages found lost by it.
  int64_t Add(const std::string& channel, std::span<const std::byte> bytes, int64_t num_skipped);
  void AddUnfit(const std::string& channel);

  [[nodiscard]] const std::map<std::string, Loss>& losses() const { return losses_; }
  [[nodiscard]] int64_t total() const { return total_; }
  /// "ok", or what is lost in one sentence.
  [[nodiscard]] std::string Describe() const;

  static constexpr size_t kMaxChannels = 500;  ///< told apart; their names come from outside

 private:
  Loss& Of(const std::string& channel);

  SequenceTracker sequence_;
  std::map<std::string, Loss> losses_;
  int64_t total_ = 0;
};

}  // namespace vantage
