#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "bus/bus.h"

namespace vantage {

/// Messages between the thread that receives them and the one that handles them, in the order of
/// arrival. Every subscription has its own bound, so that one which falls behind costs no other
/// anything. Any thread may call anything.
class Mailbox {
 public:
  struct Item {
    size_t subscription = 0;
    Envelope envelope;
    std::vector<std::byte> bytes;
  };

  /// @return the subscription's number, from 0.
  size_t AddSubscription(const SubscribeOptions& options);

  /// Copies a message in.
  /// @return the channel of every older message that went for it; mostly none. With kAll a message
  /// larger than the queue waits alone.
  std::vector<std::string> Put(size_t subscription,
                               const std::string& channel,
                               int64_t receive_utime,
                               std::span<const std::byte> bytes);

  /// The message that arrived first, waiting for one until `deadline` or a stop.
  std::optional<Item> Take(std::chrono::steady_clock::time_point deadline,
                           const std::stop_token& stop = {});

 private:
  struct Subscription {
    SubscribeOptions options;
    size_t queued_bytes = 0;
    std::set<uint64_t> waiting;              // Arrival numbers.
    std::map<std::string, uint64_t> latest;  // Arrival number by channel, kLatest.
    std::map<std::string, int64_t> skipped;  // By channel, since the last one taken.
  };

  Item Remove(uint64_t arrival);
  void Skip(uint64_t arrival, std::vector<std::string>* channels);

  std::mutex mutex_;
  std::condition_variable_any arrived_;
  uint64_t next_arrival_ = 0;
  std::map<uint64_t, Item> items_;  // By arrival.
  std::vector<Subscription> subscriptions_;
};

}  // namespace vantage
