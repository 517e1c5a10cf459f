#include "bus/live_bus.h"

#include <gtest/gtest.h>
#include <lcm/lcm.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <thread>
#include <vector>

#include "tests/bus/live/private_network.h"
#include "vantage/image_metadata_t.hpp"
#include "vantage/next_view_t.hpp"
#include "vantage/rigid_transform_t.hpp"

namespace vantage {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr const char* kUrl = "udpm://239.255.76.67:7667?ttl=0";

std::unique_ptr<LiveBus> MakeBus(const std::string& url, const std::string& name = "test") {
  LiveBus::Options options;
  options.url = url;
  options.name = name;
  Result<std::unique_ptr<LiveBus>> bus = LiveBus::Create(options);
  EXPECT_TRUE(bus.ok()) << bus.error().message;
  return bus ? std::move(bus).value() : nullptr;
}

channel_status_t StatusOf(LiveBus& bus, const std::string& channel) {
  const process_status_t status = bus.Status();
  const auto found = std::ranges::find(status.channels, channel, &channel_status_t::channel);
  return found == status.channels.end() ? channel_status_t{} : *found;
}

// Waits, as long as it takes on a busy machine.
template <class Condition>
bool Eventually(const Condition& condition) {
  const auto deadline = std::chrono::steady_clock::now() + seconds(30);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(milliseconds(2));
  }
  return true;
}

rigid_transform_t Transform(int64_t utime) {
  rigid_transform_t message{};
  message.utime = utime;
  message.quat[0] = 1.0;
  return message;
}

next_view_t NextView(int64_t seq) {
  next_view_t message{};
  message.seq = seq;
  return message;
}

TEST(LiveBus, DeliversBetweenTwoProcessesInOrder) {
  VANTAGE_NEEDS_PRIVATE_NETWORK();
  const auto sender = MakeBus(kUrl, "sender");
  const auto receiver = MakeBus(kUrl, "receiver");
  std::vector<int64_t> utimes;
  const auto handler = [&](const Envelope& envelope, const rigid_transform_t& message) {
    EXPECT_EQ(envelope.channel, "CAMERA_A_TO_WORLD");
    EXPECT_GT(envelope.receive_utime, 0);
    utimes.push_back(message.utime);
  };
  ASSERT_TRUE(receiver->Subscribe<rigid_transform_t>("CAMERA_.*_TO_WORLD", {}, handler).ok());
  for (int64_t i = 0; i < 50; ++i) {
    ASSERT_TRUE(sender->Publish("CAMERA_A_TO_WORLD", Transform(i)).ok());
    ASSERT_TRUE(sender->Publish("OTHER_CAMERA_A_TO_WORLD", Transform(-1)).ok());
  }
  while (utimes.size() < 50 && receiver->Dispatch(seconds(30))) {
  }
  ASSERT_EQ(utimes.size(), 50U);
  for (int64_t i = 0; i < 50; ++i) EXPECT_EQ(utimes[static_cast<size_t>(i)], i);
}

TEST(LiveBus, PublishesItsStatus) {
  VANTAGE_NEEDS_PRIVATE_NETWORK();
  LiveBus::Options options;
  options.url = kUrl;
  options.name = "watched";
  options.version = "1.2.3";
  options.config_hash = "abc";
  auto watched = LiveBus::Create(options);
  ASSERT_TRUE(watched.ok()) << watched.error().message;
  (*watched)->SetState("the device is gone");
  (*watched)->RecordStage("match", 0.25);
  (*watched)->RecordLost("CAMERA_A", 3);
  const auto watcher = MakeBus(kUrl, "watcher");
  std::optional<process_status_t> status;
  const auto handler = [&](const Envelope&, const process_status_t& message) {
    if (message.name == "watched" && message.num_stages > 0) status = message;
  };
  ASSERT_TRUE(watcher->Subscribe<process_status_t>("PROCESS_STATUS", {}, handler).ok());
  // The owner of `watched` dispatches nothing meanwhile: it may be computing.
  ASSERT_TRUE(Eventually([&] { return watcher->Dispatch(milliseconds(10)) && status; }));
  EXPECT_EQ(status->version, "1.2.3");
  EXPECT_EQ(status->config_hash, "abc");
  EXPECT_EQ(status->state, "the device is gone");
  EXPECT_EQ(status->pid, getpid());
  EXPECT_EQ(status->receive_buffer_requested, options.receive_buffer_bytes);
  EXPECT_GE(status->receive_buffer_granted, options.min_receive_buffer_bytes);
  ASSERT_EQ(status->num_stages, 1);
  EXPECT_EQ(status->stages[0].stage, "match");
  EXPECT_EQ(status->stages[0].latency_p50, 0.25);
  ASSERT_EQ(status->num_channels, 1);
  EXPECT_EQ(status->channels[0].num_lost, 3);
}

TEST(LiveBus, ErrorForTooSmallABuffer) {
  VANTAGE_NEEDS_PRIVATE_NETWORK();
  LiveBus::Options options;
  options.url = kUrl;
  options.name = "test";
  options.receive_buffer_bytes = 1 << 30;
  options.min_receive_buffer_bytes = 1 << 30;
  const auto bus = LiveBus::Create(options);
  ASSERT_FALSE(bus.ok());
  EXPECT_NE(bus.error().message.find("sysctl -w net.core.rmem_max="), std::string::npos)
      << bus.error().message;
  options.url = "udpm://239.255.76.67:7667?recv_buf_size=4096";
  const auto asked = LiveBus::Create(options);
  ASSERT_FALSE(asked.ok());
  EXPECT_NE(asked.error().message.find("is 4096, expected at least 1073741824"), std::string::npos)
      << asked.error().message;
}

TEST(LiveBus, ErrorWithoutRoute) {
  VANTAGE_NEEDS_PRIVATE_NETWORK();
  const pid_t child = fork();
  if (child == 0) {
    if (!EnterPrivateNetwork(false)) _exit(3);
    LiveBus::Options options;
    options.url = kUrl;
    options.name = "test";
    const auto bus = LiveBus::Create(options);
    const bool named = !bus.ok() && bus.error().message.find("ip route add 224.0.0.0/4 dev lo") !=
                                        std::string::npos;
    _exit(named ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(LiveBus, ErrorsForBadOptions) {
  for (const char* url : {"udp://239.255.76.67:7667",
                          "udpm://10.0.0.1:7667",
                          "udpm://239.255.76.67:0",
                          "udpm://239.255.76.67:99999",
                          "udpm://239.255.76.67:7667?ttl",
                          "udpm://239.255.76.67:7667?ttl=x",
                          "file:///tmp/some.log"}) {
    LiveBus::Options options;
    options.url = url;
    options.name = "test";
    const auto bus = LiveBus::Create(options);
    ASSERT_FALSE(bus.ok()) << url;
    EXPECT_NE(bus.error().message.find(url), std::string::npos) << bus.error().message;
  }
  EXPECT_FALSE(LiveBus::Create({.url = "memq://", .name = ""}).ok());
}

TEST(LiveBus, AddsTimeToLiveAndBufferToTheUrl) {
  VANTAGE_NEEDS_PRIVATE_NETWORK();
  const auto bus = MakeBus("udpm://239.255.76.67:7700");
  EXPECT_EQ(bus->url(), "udpm://239.255.76.67:7700?ttl=0&recv_buf_size=4194304");
}

// From here on inside one process; the receiving thread and the mailboxes are the same.

TEST(LiveBus, KeepLatestReplacesAndCounts) {
  const auto bus = MakeBus("memq://");
  std::vector<int64_t> seqs;
  const auto handler = [&](const Envelope&, const next_view_t& message) {
    seqs.push_back(message.seq);
  };
  ASSERT_TRUE(
      bus->Subscribe<next_view_t>("NEXT_VIEW", {SubscribeOptions::Keep::kLatest}, handler).ok());
  for (int64_t i = 0; i < 10; ++i) ASSERT_TRUE(bus->Publish("NEXT_VIEW", NextView(i)).ok());
  ASSERT_TRUE(Eventually([&] { return StatusOf(*bus, "NEXT_VIEW").num_overwritten == 9; }));
  ASSERT_TRUE(bus->Dispatch(seconds(30)));
  EXPECT_FALSE(bus->Dispatch(milliseconds(0)));
  EXPECT_EQ(seqs, std::vector<int64_t>{9});
  ASSERT_TRUE(bus->Publish("NEXT_VIEW", NextView(15)).ok());
  ASSERT_TRUE(bus->Dispatch(seconds(30)));
  const channel_status_t status = StatusOf(*bus, "NEXT_VIEW");
  EXPECT_EQ(status.num_received, 11);
  EXPECT_EQ(status.num_overwritten, 9);
  EXPECT_EQ(status.num_lost, 5);  // 10 to 14; what was overwritten did arrive.
  EXPECT_EQ(status.num_decode_errors, 0);
}

TEST(LiveBus, QueueIsBoundedInBytes) {
  const auto bus = MakeBus("memq://");
  std::vector<int64_t> seqs;
  const auto handler = [&](const Envelope&, const next_view_t& message) {
    seqs.push_back(message.seq);
  };
  const auto size = static_cast<size_t>(NextView(0).getEncodedSize());
  const SubscribeOptions options{.keep = SubscribeOptions::Keep::kAll, .queue_bytes = 4 * size};
  ASSERT_TRUE(bus->Subscribe<next_view_t>("NEXT_VIEW", options, handler).ok());
  for (int64_t i = 0; i < 10; ++i) ASSERT_TRUE(bus->Publish("NEXT_VIEW", NextView(i)).ok());
  ASSERT_TRUE(Eventually([&] { return StatusOf(*bus, "NEXT_VIEW").num_overwritten == 6; }));
  while (bus->Dispatch(milliseconds(0))) {
  }
  EXPECT_EQ(seqs, (std::vector<int64_t>{6, 7, 8, 9}));
  EXPECT_EQ(StatusOf(*bus, "NEXT_VIEW").num_lost, 0);
}

TEST(LiveBus, DropsAndCountsBadBytes) {
  VANTAGE_NEEDS_PRIVATE_NETWORK();
  const auto bus = MakeBus(kUrl);
  int num_handled = 0;
  const auto handler = [&](const Envelope&, const image_metadata_t& message) {
    EXPECT_EQ(message.key, "good");
    ++num_handled;
  };
  ASSERT_TRUE(bus->Subscribe<image_metadata_t>("META", {}, handler).ok());
  image_metadata_t good{};
  good.key = "good";
  std::vector<std::vector<std::byte>> bad(4, Encode(good));
  bad[0].resize(5);               // shorter than a fingerprint
  bad[1][0] ^= std::byte{1};      // another type
  bad[2][8] = std::byte{0x40};    // length of the key
  bad[3].push_back(std::byte{});  // left over
  lcm_t* raw = lcm_create(kUrl);
  ASSERT_NE(raw, nullptr);
  for (const auto& bytes : bad) {
    lcm_publish(raw, "META", bytes.data(), static_cast<unsigned>(bytes.size()));
  }
  lcm_destroy(raw);
  ASSERT_TRUE(bus->Publish("META", good).ok());
  while (num_handled == 0 && bus->Dispatch(seconds(30))) {
  }
  EXPECT_EQ(num_handled, 1);
  const channel_status_t status = StatusOf(*bus, "META");
  EXPECT_EQ(status.num_received, 5);
  EXPECT_EQ(status.num_decode_errors, 4);
}

TEST(LiveBus, ATapGetsAnyBytesOfItsChannels) {
  VANTAGE_NEEDS_PRIVATE_NETWORK();
  const auto bus = MakeBus(kUrl);
  std::vector<std::string> got;
  const auto handler = [&](const Envelope& envelope, std::span<const std::byte> bytes) {
    got.push_back(envelope.channel + " " + std::to_string(bytes.size()));
  };
  ASSERT_TRUE(bus->Tap("[AB].*", {}, handler).ok());
  lcm_t* raw = lcm_create(kUrl);
  ASSERT_NE(raw, nullptr);
  lcm_publish(raw, "A1", "xyz", 3);
  lcm_publish(raw, "C1", "xyz", 3);
  lcm_publish(raw, "B1", "", 0);
  lcm_destroy(raw);
  ASSERT_TRUE(bus->Publish("A2", Transform(1)).ok());
  while (got.size() < 3 && bus->Dispatch(seconds(30))) {
  }
  EXPECT_EQ(got, (std::vector<std::string>{"A1 3", "B1 0", "A2 72"}));
  EXPECT_EQ(StatusOf(*bus, "A1").num_decode_errors, 0);
}

// A message of another type must not push a good one out of its slot.
TEST(LiveBus, AnotherTypeDoesNotReplaceTheLatest) {
  const auto bus = MakeBus("memq://");
  int num_handled = 0;
  const auto handler = [&](const Envelope&, const next_view_t&) { ++num_handled; };
  ASSERT_TRUE(bus->Subscribe<next_view_t>("VIEW", {SubscribeOptions::Keep::kLatest}, handler).ok());
  ASSERT_TRUE(bus->Publish("VIEW", NextView(1)).ok());
  ASSERT_TRUE(bus->Publish("VIEW", Transform(1)).ok());
  ASSERT_TRUE(Eventually([&] { return StatusOf(*bus, "VIEW").num_decode_errors == 1; }));
  ASSERT_TRUE(bus->Dispatch(seconds(30)));
  EXPECT_EQ(num_handled, 1);
}

TEST(LiveBus, RunPollsAndStops) {
  const auto bus = MakeBus("memq://");
  std::stop_source stop;
  int num_handled = 0;
  const auto handler = [&](const Envelope&, const next_view_t&) { ++num_handled; };
  ASSERT_TRUE(bus->Subscribe<next_view_t>("NEXT_VIEW", {}, handler).ok());
  ASSERT_TRUE(bus->Publish("NEXT_VIEW", NextView(0)).ok());
  int num_polls = 0;
  bus->Run(
      stop.get_token(),
      [&] {
        ++num_polls;
        if (num_handled == 1 && num_polls >= 3) stop.request_stop();
      },
      milliseconds(1));
  EXPECT_EQ(num_handled, 1);
  EXPECT_GE(num_polls, 3);
}

TEST(LiveBus, StopEndsAWaitForMessages) {
  const auto bus = MakeBus("memq://");
  std::stop_source stop;
  std::jthread stopper([&stop] { stop.request_stop(); });
  bus->Run(stop.get_token(), {}, std::chrono::hours(1));
  SUCCEED();
}

TEST(LiveBus, RefusesBadChannels) {
  const auto bus = MakeBus("memq://");
  const auto handler = [](const Envelope&, const next_view_t&) {};
  EXPECT_FALSE(bus->Subscribe<next_view_t>("", {}, handler).ok());
  EXPECT_FALSE(bus->Subscribe<next_view_t>("VIEW_(", {}, handler).ok());
  EXPECT_FALSE(bus->Publish("", NextView(0)).ok());
  EXPECT_FALSE(bus->Publish(std::string(64, 'A'), NextView(0)).ok());
  EXPECT_TRUE(bus->Publish(std::string(63, 'A'), NextView(0)).ok());
}

}  // namespace
}  // namespace vantage
