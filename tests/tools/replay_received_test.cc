// Reruns of what live consumed. The live run is made up: a rerun on some of the images, whose
// output is put into the log of all of them as if it had been recorded there.

#include <gtest/gtest.h>

#include <set>

#include "bus/conversions.h"
#include "tests/tools/replay_logs.h"
#include "tests/tools/run_program.h"
#include "vantage/arm_status_t.hpp"

namespace vantage {
namespace {

constexpr int64_t kDelay = 7'000;  // us, from the event to what live made of it

class ReplayReceived : public ScratchTest {
 protected:
  void SetUp() override {
    ScratchTest::SetUp();
    all = CameraRun(scratch());
    recorded = Record({1, 3, 4, 8, 10, 15, 20});
  }

  // What live processes make of these images.
  LogEvents Outputs(const std::set<int64_t>& seqs) {
    LogEvents inputs = all;
    std::erase_if(inputs, [&](const LogEvent& event) {
      if (event.channel != "CAMERA_TEST") return false;
      const images_t image = DecodeChecked<images_t>(event.data).value();
      return !seqs.contains(ImageSeq(image.images[0]));
    });
    WriteEvents(inputs, scratch() / "some.lcm");
    ReplayOptions options = RunOptions(scratch() / "some.lcm", scratch() / "live.lcm");
    options.cache = cache;
    EXPECT_TRUE(RunReplay(options).ok());
    LogEvents outputs = ReadEvents(scratch() / "live.lcm");
    outputs.erase(outputs.begin());  // LOG_HEADER
    return outputs;
  }
  LogEvents Record(const std::set<int64_t>& seqs) {
    LogEvents events = Outputs(seqs);
    for (LogEvent& event : events) event.utime += kDelay;
    events.insert(events.end(), all.begin(), all.end());
    SortByTime(&events);
    return events;
  }

  Result<ReplaySummary> Rerun(const LogEvents& events, int threads = 1) {
    WriteEvents(events, scratch() / "in.lcm");
    ReplayOptions options = RunOptions(scratch() / "in.lcm", scratch() / "out.lcm");
    options.as_received = true;
    options.threads = threads;
    options.cache = cache;
    Result<ReplaySummary> summary = RunReplay(options);
    EXPECT_TRUE(summary.ok()) << summary.error().message;
    rerun = ReadEvents(scratch() / "out.lcm");
    return summary;
  }
  void ExpectAsRecorded() const {
    for (const char* channel :
         {"DETECTIONS_PPF", "OBJECTS", "ORIENTATION_HISTOGRAM", "NEXT_VIEW"}) {
      EXPECT_FALSE(MessagesOn(channel, rerun).empty()) << channel;
      EXPECT_TRUE(MessagesOn(channel, rerun) == MessagesOn(channel, recorded)) << channel;
    }
  }
  static void ExpectWarning(const Result<ReplaySummary>& summary, const std::string& part) {
    ASSERT_TRUE(summary.ok());
    std::string all_of_them;
    for (const std::string& warning : summary->warnings) all_of_them += warning + "\n";
    EXPECT_NE(all_of_them.find(part), std::string::npos) << part << " in:\n" << all_of_them;
  }
  // Where the detections stand.
  static std::vector<size_t> DetectionsIn(const LogEvents& events) {
    std::vector<size_t> places;
    for (size_t i = 0; i < events.size(); ++i) {
      if (events[i].channel == "DETECTIONS_PPF") places.push_back(i);
    }
    return places;
  }

  LogEvents all;       // Of sensors.
  LogEvents recorded;  // Also of live processes.
  LogEvents rerun;
  static std::shared_ptr<EstimatorCache> cache;
};
std::shared_ptr<EstimatorCache> ReplayReceived::cache = std::make_shared<EstimatorCache>();

TEST_F(ReplayReceived, GivesWhatLiveGave) {
  const Result<ReplaySummary> summary = Rerun(recorded);
  ExpectAsRecorded();
  EXPECT_EQ(MessagesOn("DETECTIONS_PPF", rerun).size(), 7U);
  EXPECT_TRUE(summary->warnings.empty()) << summary->warnings.front();
  // Each when live was done with it.
  EXPECT_EQ(rerun[1].channel, "DETECTIONS_PPF");
  EXPECT_EQ(rerun[1].utime, recorded[DetectionsIn(recorded)[0]].utime);

  const std::string sequential = FileBytes(scratch() / "out.lcm");
  for (const int threads : {2, 3}) {
    ASSERT_TRUE(Rerun(recorded, threads).ok());
    EXPECT_TRUE(FileBytes(scratch() / "out.lcm") == sequential) << threads;
  }
}

TEST_F(ReplayReceived, ImagesThatLiveTookLateAreHeld) {
  LogEvents events = recorded;
  // Seconds after their images: of all places, in their order.
  for (LogEvent& event : events) {
    if (!event.channel.starts_with("CAMERA_")) event.utime += 5'000'000;
  }
  SortByTime(&events);
  const Result<ReplaySummary> summary = Rerun(events);
  EXPECT_TRUE(MessagesOn("DETECTIONS_PPF", rerun) == MessagesOn("DETECTIONS_PPF", recorded));
  EXPECT_TRUE(summary->warnings.empty());
}

TEST_F(ReplayReceived, ArmStatusIsDelivered) {
  // The arm refuses the first view, on which fusion chooses another.
  const auto asked = std::ranges::find(recorded, "NEXT_VIEW", &LogEvent::channel);
  ASSERT_NE(asked, recorded.end());
  const auto first = DecodeChecked<next_view_t>(asked->data);
  arm_status_t status{};
  status.utime = asked->utime + 1000;
  status.view_seq = first->seq;
  status.state = arm_status_t::REFUSED;
  status.reason = "no way";
  LogEvents events = recorded;
  events.push_back({0, status.utime, "ARM_STATUS", Encode(status)});
  SortByTime(&events);
  ASSERT_TRUE(Rerun(events).ok());
  const auto views = MessagesOn("NEXT_VIEW", rerun);
  ASSERT_GT(views.size(), 1U);
  EXPECT_TRUE(views[0] == asked->data);
  const auto second = DecodeChecked<next_view_t>(views[1]);
  EXPECT_NE(second->seq, first->seq);
  EXPECT_EQ(second->utime, first->utime) << "the same images";
}

TEST_F(ReplayReceived, RecordingThatBeginsInMidRun) {
  Edit<detections_v2_t>(
      "DETECTIONS_PPF", [](detections_v2_t* message) { message->seq += 57; }, &recorded);
  const Result<ReplaySummary> summary = Rerun(recorded);
  EXPECT_TRUE(MessagesOn("DETECTIONS_PPF", rerun) == MessagesOn("DETECTIONS_PPF", recorded));
  ExpectWarning(summary, "DETECTIONS_PPF begins with seq 57");
}

TEST_F(ReplayReceived, FusionThatKnewSomethingAlreadyIsTold) {
  LogEvents events = recorded;
  LogEvent objects = *std::ranges::find(recorded, "OBJECTS", &LogEvent::channel);
  objects.utime = events.front().utime + 1;
  events.push_back(objects);
  SortByTime(&events);
  ExpectWarning(Rerun(events), "OBJECTS stand in the log before any detections");
}

TEST_F(ReplayReceived, EstimatorThatWasStartedAgain) {
  Edit<detections_v2_t>(
      "DETECTIONS_PPF",
      [](detections_v2_t* message) { message->seq -= message->seq >= 4 ? 4 : 0; },
      &recorded);
  const Result<ReplaySummary> summary = Rerun(recorded);
  EXPECT_TRUE(MessagesOn("DETECTIONS_PPF", rerun) == MessagesOn("DETECTIONS_PPF", recorded));
  ExpectWarning(summary, "DETECTIONS_PPF starts anew 1 times");
}

TEST_F(ReplayReceived, MissingMessagesAreTold) {
  LogEvents events = recorded;
  const std::vector<size_t> places = DetectionsIn(events);
  // Of the third detections the image, and the fifth detections themselves.
  const auto third = DecodeChecked<detections_v2_t>(events[places[2]].data).value();
  const LogEvent fifth = events[places[4]];
  std::erase_if(events, [&](const LogEvent& event) {
    if (event.channel == "DETECTIONS_PPF") return event.data == fifth.data;
    return event.channel == "CAMERA_TEST" && event.utime == third.utime;
  });
  const Result<ReplaySummary> summary = Rerun(events);
  ExpectWarning(summary, "DETECTIONS_PPF: 1 messages are of images that the log lacks");
  ExpectWarning(summary, "DETECTIONS_PPF: 1 messages are missing in the log, by gaps in seq");
  auto expected = MessagesOn("DETECTIONS_PPF", recorded);
  expected.erase(expected.begin() + 4);
  expected.erase(expected.begin() + 2);
  EXPECT_TRUE(MessagesOn("DETECTIONS_PPF", rerun) == expected);
}

TEST_F(ReplayReceived, DetectionsOfOthersAreTakenAsRecorded) {
  // Another estimator saw the same, of which nothing is rerun.
  LogEvents events = recorded;
  for (const size_t place : DetectionsIn(recorded)) {
    LogEvent other = recorded[place];
    other.channel = "DETECTIONS_MINE";
    events.push_back(other);
  }
  SortByTime(&events);
  const Result<ReplaySummary> summary = Rerun(events);
  ExpectWarning(summary, "DETECTIONS_MINE: 7 messages are taken as they were recorded");
  EXPECT_TRUE(MessagesOn("DETECTIONS_PPF", rerun) == MessagesOn("DETECTIONS_PPF", recorded));
  EXPECT_FALSE(MessagesOn("OBJECTS", rerun) == MessagesOn("OBJECTS", recorded));
}

TEST_F(ReplayReceived, CorruptDetectionsAreTold) {
  const std::vector<size_t> places = DetectionsIn(recorded);
  recorded[places[1]].data.resize(40);
  const Result<ReplaySummary> summary = Rerun(recorded);
  ExpectWarning(summary, "DETECTIONS_PPF: 1 messages can't be decoded");
  EXPECT_EQ(MessagesOn("DETECTIONS_PPF", rerun).size(), 6U);
}

}  // namespace
}  // namespace vantage
