#include "tools/monitor/bus_probe.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <memory>
#include <span>

#include "bus/process_name_lock.h"
#include "vantage/rigid_transform_t.hpp"

namespace vantage {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kSent = 20;
constexpr const char* kChannel = "VANTAGE_DOCTOR";
constexpr std::chrono::milliseconds kPatience(200);  // For one message to come back.
constexpr std::chrono::milliseconds kListen(1500);

// Sends one message at a time and waits for it.
void SendToSelf(LiveBus& bus, const int64_t& last_heard, BusProbe* probe) {
  std::vector<double> times;
  for (int i = 1; i <= kSent; ++i) {
    rigid_transform_t message{};
    message.utime = i;
    message.quat[0] = 1.0;
    const auto sent = Clock::now();
    if (!bus.Publish(kChannel, message)) continue;
    ++probe->num_sent;
    while (last_heard != i && Clock::now() - sent < kPatience) {
      bus.Dispatch(std::chrono::milliseconds(20));
    }
    if (last_heard != i) continue;
    ++probe->num_returned;
    times.push_back(std::chrono::duration<double>(Clock::now() - sent).count());
  }
  if (times.empty()) return;
  std::ranges::nth_element(times, times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2));
  probe->round_trip = times[times.size() / 2];
}

// A lock that can be had is let go at once.
std::optional<int> HolderOf(const std::string& name, const std::string& url) {
  const auto lock = ProcessNameLock::Acquire(name, url);
  if (lock || lock.error().code != ErrorCode::kUnavailable) return std::nullopt;
  const std::string& sentence = lock.error().message;
  const size_t begin = sentence.find("(pid ");
  int pid = 0;
  if (begin != std::string::npos) {
    std::from_chars(sentence.data() + begin + 5, sentence.data() + sentence.size(), pid);
  }
  return pid;
}

}  // namespace

BusProbe ProbeBus(LiveBus::Options options, const std::vector<std::string>& names) {
  BusProbe probe;
  options.name = "doctor";
  options.min_receive_buffer_bytes = 0;  // What is granted is told, not refused.
  Result<std::unique_ptr<LiveBus>> bus = LiveBus::Create(options);
  if (!bus) {
    probe.error = bus.error();
    return probe;
  }
  probe.url = (*bus)->url();
  int64_t last_heard = 0;
  const Result<void> tapped =
      (*bus)->Tap(".*", {}, [&](const Envelope& envelope, std::span<const std::byte> bytes) {
        if (envelope.channel != kChannel) {
          probe.model.Add(envelope.channel, envelope.receive_utime, bytes);
        } else if (const auto message = DecodeChecked<rigid_transform_t>(bytes)) {
          last_heard = message->utime;
        }
      });
  if (!tapped) {
    probe.error = tapped.error();
    return probe;
  }
  SendToSelf(**bus, last_heard, &probe);
  const auto deadline = Clock::now() + kListen;
  while (Clock::now() < deadline) (*bus)->Dispatch(std::chrono::milliseconds(20));
  const process_status_t status = (*bus)->Status();
  probe.requested = status.receive_buffer_requested;
  probe.granted = status.receive_buffer_granted;
  probe.utime = (*bus)->NowUtime();
  for (const std::string& name : names) {
    if (const std::optional<int> pid = HolderOf(name, options.url)) probe.holders[name] = *pid;
  }
  return probe;
}

}  // namespace vantage
