#include "bus/mailbox.h"

#include <utility>

namespace vantage {
namespace {

// Channels that one subscription remembers: their names come from outside.
constexpr size_t kMaxChannels = 256;

}  // namespace

size_t Mailbox::AddSubscription(const SubscribeOptions& options) {
  const std::lock_guard lock(mutex_);
  subscriptions_.push_back({.options = options, .waiting = {}, .latest = {}, .skipped = {}});
  return subscriptions_.size() - 1;
}

std::vector<std::string> Mailbox::Put(size_t subscription,
                                      const std::string& channel,
                                      int64_t receive_utime,
                                      std::span<const std::byte> bytes) {
  std::vector<std::string> skipped;
  Item item;
  item.subscription = subscription;
  item.envelope.channel = channel;
  item.envelope.receive_utime = receive_utime;
  item.bytes.assign(bytes.begin(), bytes.end());
  {
    const std::lock_guard lock(mutex_);
    Subscription& to = subscriptions_[subscription];
    if (to.options.keep == SubscribeOptions::Keep::kLatest) {
      if (const auto slot = to.latest.find(channel); slot != to.latest.end()) {
        Skip(slot->second, &skipped);
      }
      if (to.waiting.size() >= kMaxChannels) Skip(*to.waiting.begin(), &skipped);
      to.latest[channel] = next_arrival_;
    } else {
      while (!to.waiting.empty() && to.queued_bytes + bytes.size() > to.options.queue_bytes) {
        Skip(*to.waiting.begin(), &skipped);
      }
    }
    to.queued_bytes += bytes.size();
    to.waiting.insert(next_arrival_);
    items_.emplace(next_arrival_++, std::move(item));
  }
  arrived_.notify_one();
  return skipped;
}

std::optional<Mailbox::Item> Mailbox::Take(std::chrono::steady_clock::time_point deadline,
                                           const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  if (!arrived_.wait_until(lock, stop, deadline, [this] { return !items_.empty(); })) return {};
  Item item = Remove(items_.begin()->first);
  std::map<std::string, int64_t>& skipped = subscriptions_[item.subscription].skipped;
  if (const auto count = skipped.find(item.envelope.channel); count != skipped.end()) {
    item.envelope.num_skipped = count->second;
    skipped.erase(count);
  }
  return item;
}

Mailbox::Item Mailbox::Remove(uint64_t arrival) {
  Item item = std::move(items_.extract(arrival).mapped());
  Subscription& of = subscriptions_[item.subscription];
  of.waiting.erase(arrival);
  of.latest.erase(item.envelope.channel);
  of.queued_bytes -= item.bytes.size();
  return item;
}

void Mailbox::Skip(uint64_t arrival, std::vector<std::string>* channels) {
  const Item item = Remove(arrival);
  std::map<std::string, int64_t>& skipped = subscriptions_[item.subscription].skipped;
  if (skipped.size() >= kMaxChannels) skipped.clear();
  ++skipped[item.envelope.channel];
  channels->push_back(item.envelope.channel);
}

}  // namespace vantage
