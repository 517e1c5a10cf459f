#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>

namespace vantage {

/// Finds lost messages by gaps in their sender's count.
class SequenceTracker {
 public:
  /// @param sender who counts: the channel, and the name in the message where several share one.
  /// @param num_skipped messages since the last one that arrived but were let go.
  /// @return messages lost between the last one and this. A count that goes back, or jumps by more
  /// than kLargestGap, is a sender that started anew: nothing lost.
  int64_t Add(const std::string& sender, int64_t seq, int64_t num_skipped) {
    if (last_.size() >= kMaxSenders && !last_.contains(sender)) last_.clear();
    const auto [entry, is_new] = last_.try_emplace(sender, seq);
    const int64_t last = entry->second;
    entry->second = seq;
    if (is_new || seq <= last) return 0;
    const uint64_t gap = static_cast<uint64_t>(seq) - static_cast<uint64_t>(last) - 1;
    if (gap > static_cast<uint64_t>(kLargestGap)) return 0;
    const int64_t lost = static_cast<int64_t>(gap) - num_skipped;
    return lost > 0 ? lost : 0;
  }

  static constexpr int64_t kLargestGap = 100'000;
  static constexpr size_t kMaxSenders = 1'000;  ///< remembered; senders' names come from outside

 private:
  std::unordered_map<std::string, int64_t> last_;
};

}  // namespace vantage
