#include "bus/mailbox.h"

#include <gtest/gtest.h>

#include <thread>

#include "bus/channel_pattern.h"
#include "bus/process_status.h"
#include "bus/sequence_tracker.h"

namespace vantage {
namespace {

using Keep = SubscribeOptions::Keep;

std::vector<std::byte> Bytes(size_t size) { return std::vector<std::byte>(size); }

std::optional<Mailbox::Item> Take(Mailbox& mailbox) {
  return mailbox.Take(std::chrono::steady_clock::now());
}

TEST(Mailbox, HandsOutInOrderOfArrivalAcrossSubscriptions) {
  Mailbox mailbox;
  const size_t all = mailbox.AddSubscription({Keep::kAll, 1000});
  const size_t latest = mailbox.AddSubscription({Keep::kLatest, 1000});
  mailbox.Put(latest, "L", 1, Bytes(1));
  mailbox.Put(all, "A", 2, Bytes(1));
  EXPECT_EQ(mailbox.Put(latest, "L", 3, Bytes(1)), std::vector<std::string>{"L"});
  mailbox.Put(all, "A", 4, Bytes(1));
  std::vector<int64_t> utimes;
  while (const auto item = Take(mailbox)) utimes.push_back(item->envelope.receive_utime);
  EXPECT_EQ(utimes, (std::vector<int64_t>{2, 3, 4}));
}

TEST(Mailbox, LatestHasASlotForEachChannel) {
  Mailbox mailbox;
  const size_t latest = mailbox.AddSubscription({Keep::kLatest, 1000});
  EXPECT_TRUE(mailbox.Put(latest, "A", 1, Bytes(1)).empty());
  EXPECT_TRUE(mailbox.Put(latest, "B", 2, Bytes(1)).empty());
  EXPECT_EQ(mailbox.Put(latest, "A", 3, Bytes(1)), std::vector<std::string>{"A"});
  const auto first = Take(mailbox);
  const auto second = Take(mailbox);
  EXPECT_EQ(first->envelope.channel, "B");
  EXPECT_EQ(first->envelope.num_skipped, 0);
  EXPECT_EQ(second->envelope.channel, "A");
  EXPECT_EQ(second->envelope.num_skipped, 1);
  EXPECT_FALSE(Take(mailbox));
}

TEST(Mailbox, BoundsTheChannelsThatStrangersMakeUp) {
  Mailbox mailbox;
  const size_t latest = mailbox.AddSubscription({Keep::kLatest, 1000});
  size_t skipped = 0;
  for (int i = 0; i < 1000; ++i) {
    skipped += mailbox.Put(latest, std::to_string(i), i, Bytes(1)).size();
  }
  EXPECT_EQ(skipped, 1000U - 256U);
}

TEST(Mailbox, AMessageLargerThanTheQueueWaitsAlone) {
  Mailbox mailbox;
  const size_t all = mailbox.AddSubscription({Keep::kAll, 100});
  EXPECT_TRUE(mailbox.Put(all, "A", 1, Bytes(60)).empty());
  EXPECT_TRUE(mailbox.Put(all, "A", 2, Bytes(40)).empty());
  EXPECT_EQ(mailbox.Put(all, "A", 3, Bytes(500)).size(), 2U);
  EXPECT_EQ(mailbox.Put(all, "A", 4, Bytes(1)).size(), 1U);
  const auto item = Take(mailbox);
  EXPECT_EQ(item->envelope.receive_utime, 4);
  EXPECT_EQ(item->envelope.num_skipped, 3);
}

TEST(Mailbox, WakesAWaiter) {
  Mailbox mailbox;
  const size_t all = mailbox.AddSubscription({Keep::kAll, 100});
  std::jthread sender([&] { mailbox.Put(all, "A", 1, Bytes(3)); });
  const auto item = mailbox.Take(std::chrono::steady_clock::now() + std::chrono::seconds(60));
  ASSERT_TRUE(item);
  EXPECT_EQ(item->bytes.size(), 3U);
}

TEST(SequenceTracker, CountsGapsOfEachSender) {
  SequenceTracker tracker;
  EXPECT_EQ(tracker.Add("A", 5, 0), 0);
  EXPECT_EQ(tracker.Add("A", 6, 0), 0);
  EXPECT_EQ(tracker.Add("A", 10, 0), 3);
  EXPECT_EQ(tracker.Add("B", 100, 0), 0);
  EXPECT_EQ(tracker.Add("A", 11, 0), 0);
  EXPECT_EQ(tracker.Add("A", 11, 0), 0);  // Sent again.
  EXPECT_EQ(tracker.Add("A", 15, 2), 1);  // Two of the three arrived and were let go.
  EXPECT_EQ(tracker.Add("A", 17, 5), 0);
}

TEST(SequenceTracker, ARestartLosesNothing) {
  SequenceTracker tracker;
  tracker.Add("A", 1000, 0);
  EXPECT_EQ(tracker.Add("A", 0, 0), 0);
  EXPECT_EQ(tracker.Add("A", 2, 0), 1);
  EXPECT_EQ(tracker.Add("A", INT64_MAX, 0), 0);
  EXPECT_EQ(tracker.Add("A", INT64_MIN, 0), 0);
  EXPECT_EQ(tracker.Add("A", INT64_MAX, 0), 0);
}

TEST(ChannelPattern, MatchesTheWholeName) {
  const auto pattern = ChannelPattern::Create("CAMERA_.*_TO_WORLD");
  ASSERT_TRUE(pattern.ok());
  EXPECT_FALSE(pattern->IsName());
  EXPECT_TRUE(pattern->Matches("CAMERA_A_TO_WORLD"));
  EXPECT_FALSE(pattern->Matches("MY_CAMERA_A_TO_WORLD"));
  EXPECT_FALSE(pattern->Matches("CAMERA_A_TO_WORLD2"));
  const auto name = ChannelPattern::Create("CAMERA_A");
  ASSERT_TRUE(name.ok());
  EXPECT_TRUE(name->IsName());
  EXPECT_TRUE(name->Matches("CAMERA_A"));
  EXPECT_FALSE(name->Matches("CAMERA_AB"));
  EXPECT_FALSE(ChannelPattern::Create("A[").ok());
  EXPECT_FALSE(ChannelPattern::Create("").ok());
}

TEST(ProcessStatus, PercentilesAreOfTheLast256Runs) {
  ProcessStatus status;
  status.RecordStage("match", 1000.0);
  for (int i = 1; i <= 256; ++i) status.RecordStage("match", i);
  process_status_t message{};
  status.Fill(ProcessStatus::Clock::now(), &message);
  ASSERT_EQ(message.num_stages, 1);
  EXPECT_EQ(message.stages[0].num_runs, 257);
  EXPECT_EQ(message.stages[0].latency_p50, 128.0);
  EXPECT_EQ(message.stages[0].latency_p99, 254.0);
  EXPECT_EQ(message.stages[0].latency_max, 1000.0);
}

TEST(ProcessStatus, AgeAndRate) {
  using std::chrono::seconds;
  ProcessStatus status;
  status.AddChannel("A");
  process_status_t message{};
  const auto start = ProcessStatus::Clock::now() + seconds(100);
  status.Fill(start, &message);
  ASSERT_EQ(message.num_channels, 1);
  EXPECT_EQ(message.channels[0].age, -1.0);
  for (int i = 0; i < 10; ++i) status.RecordReceived("A", start + seconds(1));
  status.Fill(start + seconds(2), &message);
  EXPECT_EQ(message.channels[0].age, 1.0);
  EXPECT_EQ(message.channels[0].rate, 5.0);
  EXPECT_EQ(message.channels[0].num_received, 10);
}

TEST(ProcessStatus, ReportsADecodeErrorEveryFiveSeconds) {
  using std::chrono::milliseconds;
  ProcessStatus status;
  const auto start = ProcessStatus::Clock::now();
  EXPECT_TRUE(status.RecordDecodeError("A", start));
  EXPECT_FALSE(status.RecordDecodeError("A", start + milliseconds(4999)));
  EXPECT_TRUE(status.RecordDecodeError("B", start + milliseconds(4999)));
  EXPECT_TRUE(status.RecordDecodeError("A", start + milliseconds(5000)));
  EXPECT_FALSE(status.RecordDecodeError("A", start + milliseconds(9999)));
}

TEST(ProcessStatus, BoundsTheChannelsThatStrangersMakeUp) {
  ProcessStatus status;
  for (int i = 0; i < 1000; ++i) {
    status.RecordReceived(std::to_string(i), ProcessStatus::Clock::now());
  }
  process_status_t message{};
  status.Fill(ProcessStatus::Clock::now(), &message);
  EXPECT_EQ(message.channels.size(), ProcessStatus::kMaxChannels + 1);
  int64_t sum = 0;
  for (const channel_status_t& channel : message.channels) sum += channel.num_received;
  EXPECT_EQ(sum, 1000);
}

}  // namespace
}  // namespace vantage
