// ReadRun on logs that tests write event by event.

#include "tools/support/recorded_run.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <memory>

#include "bus/conversions.h"
#include "bus/event_log.h"
#include "bus/image_conversion.h"
#include "bus/message_check.h"
#include "common/rng.h"
#include "perception/model/file_bytes.h"
#include "tests/tools/run_fixtures.h"
#include "tests/tools/run_program.h"
#include "vantage/next_view_t.hpp"

namespace vantage {
namespace {

constexpr int kWidth = 8;
constexpr int kHeight = 6;

Pose PoseOf(uint64_t seed) {
  Rng rng(seed);
  Pose pose = Pose::Identity();
  pose.linear() = rng.Rotation().toRotationMatrix();
  pose.translation() = rng.UnitVector();
  return pose;
}

int64_t Second(double second) { return kRunStart + std::llround(1e6 * second); }

class RecordedRunTest : public ScratchTest {
 protected:
  void SetUp() override {
    ScratchTest::SetUp();
    Result<std::unique_ptr<EventLogWriter>> writer = EventLogWriter::Create(log());
    ASSERT_TRUE(writer.ok());
    writer_ = std::move(writer).value();
  }

  [[nodiscard]] std::filesystem::path log() const { return scratch() / "run.lcm"; }

  template <class Message>
  void Write(int64_t utime, const std::string& channel, const Message& message) {
    ASSERT_TRUE(writer_->Write(utime, channel, Encode(message)).ok());
  }

  // An image whose every pixel tells its time, mm.
  void WriteDepth(int64_t utime, uint16_t millimetres, const std::string& camera = "A") {
    const std::vector<uint16_t> depth(size_t{kWidth} * kHeight, millimetres);
    Write(utime,
          "CAMERA_" + camera,
          DepthToMessage(kWidth, kHeight, depth, utime, 0, "", DepthCompression::kZlib));
  }

  // One detection a pose, seen from PoseOf(camera_seed).
  void WriteDetections(int64_t utime,
                       int64_t seq,
                       const std::vector<Pose>& T_camera_objects,
                       uint64_t camera_seed,
                       const std::string& channel = "DETECTIONS_PPF") {
    DetectionSet set;
    set.utime = utime;
    set.seq = seq;
    set.camera = "A";
    set.estimator = "ppf";
    set.T_world_camera = PoseOf(camera_seed);
    for (const Pose& pose : T_camera_objects) {
      Detection detection;
      detection.model_id = "part";
      detection.T_camera_object = pose;
      set.detections.push_back(detection);
    }
    Write(utime + 50'000, channel, DetectionsToMessage(set));
  }

  void WriteObjects(int64_t utime,
                    std::vector<object_estimate_v3_t> objects,
                    int32_t num_viewpoints) {
    Write(utime + 60'000, "OBJECTS", ObjectsOf(std::move(objects), num_viewpoints, utime));
  }

  // An object of one source.
  static object_estimate_v3_t Object(int32_t instance,
                                     int64_t seq,
                                     int32_t index,
                                     int32_t viewpoint,
                                     const std::string& channel = "DETECTIONS_PPF") {
    object_estimate_v3_t object = EstimateAt(instance, "part", PoseOf(1000));
    AddSource(channel, seq, index, viewpoint, &object);
    return object;
  }

  Result<RecordedRun> Read(const std::string& camera = "A") {
    if (writer_) {
      EXPECT_TRUE(writer_->Close().ok());
    }
    writer_.reset();
    return ReadRun(log(), camera);
  }

 private:
  std::unique_ptr<EventLogWriter> writer_;
};

void ExpectSame(const Pose& found, const Pose& expected) {
  EXPECT_LE((found.matrix() - expected.matrix()).norm(), 1e-9);
}

TEST_F(RecordedRunTest, ViewpointsWithWhatWasSeenAndBelieved) {
  const CameraModel camera{kWidth, kHeight, 10.0, 11.0, 3.5, 2.5};
  CameraIdentity identity{};
  identity.name = "A";
  Write(Second(-1), "CAMERA_A_INFO", CameraToMessage(camera, identity, Second(-1), 0));
  for (int view = 0; view < 3; ++view) {
    const auto v = static_cast<uint64_t>(view);
    WriteDepth(Second(view), static_cast<uint16_t>(500 + view));
    WriteDepth(Second(view), 99, "B");
    WriteDetections(Second(view), view, {PoseOf(10 + v), PoseOf(20 + v)}, v);
    WriteDepth(Second(view + 0.1), 77);  // Nobody used it.
    // The second of the set is instance 4; sources of earlier views stay in the list.
    object_estimate_v3_t object = EstimateAt(4, "part", PoseOf(1000 + v));
    for (int i = 0; i <= view; ++i) AddSource("DETECTIONS_PPF", i, 1, i, &object);
    object.num_views = view + 1;
    WriteObjects(Second(view), {object}, view + 1);
    orientation_histogram_t histogram{};
    histogram.instance_id = 4;
    histogram.k = 8 + view;
    Write(Second(view + 0.2), "ORIENTATION_HISTOGRAM", histogram);
    next_view_t next{};
    next.seq = view;
    next.reason = "reason " + std::to_string(view);
    Write(Second(view + 0.2), "NEXT_VIEW", next);
  }
  const Result<RecordedRun> run = Read();
  ASSERT_TRUE(run.ok()) << run.error().message;
  EXPECT_EQ(run->camera, camera);
  EXPECT_FALSE(run->finished);
  EXPECT_EQ(run->damage, "");
  ASSERT_EQ(run->views.size(), 3U);
  for (uint64_t v = 0; v < 3; ++v) {
    const RunView& view = run->views[v];
    EXPECT_EQ(view.utime, Second(static_cast<double>(v)));
    ExpectSame(view.T_world_camera, PoseOf(v));
    ASSERT_EQ(view.depth.width, kWidth);
    EXPECT_FLOAT_EQ(view.depth.at(3, 2), 0.5F + 0.001F * static_cast<float>(v));
    ASSERT_EQ(view.detections.size(), 1U);
    ExpectSame(view.detections.at(4), PoseOf(v) * PoseOf(20 + v));
    ASSERT_EQ(view.objects.objects.size(), 1U);
    ExpectSame(EstimatedPose(view.objects.objects[0]).value(), PoseOf(1000 + v));
    EXPECT_EQ(view.histograms.at(4).k, 8 + static_cast<int>(v));
    EXPECT_EQ(view.next_view.reason, "reason " + std::to_string(v));
  }
}

TEST_F(RecordedRunTest, LaterDetectionOfAViewpointReplacesTheFirst) {
  WriteDepth(Second(0), 500);
  WriteDetections(Second(0), 0, {PoseOf(10)}, 1);
  WriteObjects(Second(0), {Object(2, 0, 0, 0)}, 1);
  WriteDepth(Second(1), 600);
  WriteDetections(Second(1), 1, {PoseOf(11)}, 1);
  WriteObjects(Second(1), {Object(2, 1, 0, 0)}, 1);
  const Result<RecordedRun> run = Read();
  ASSERT_TRUE(run.ok());
  ASSERT_EQ(run->views.size(), 1U);
  EXPECT_EQ(run->views[0].utime, Second(1));
  ASSERT_EQ(run->views[0].depth.width, kWidth);
  EXPECT_FLOAT_EQ(run->views[0].depth.at(0, 0), 0.6F);
  ExpectSame(run->views[0].detections.at(2), PoseOf(1) * PoseOf(11));
}

TEST_F(RecordedRunTest, EstimatorThatStartedAgainCountsAnew) {
  WriteDetections(Second(0), 0, {PoseOf(10)}, 0);
  WriteObjects(Second(0), {Object(2, 0, 0, 0)}, 1);
  WriteDetections(Second(1), 1, {PoseOf(11)}, 1);
  WriteObjects(Second(1), {Object(2, 1, 0, 1)}, 2);
  // Killed and up again: seq 0 is another image now. So is seq 0 of another estimator.
  WriteDetections(Second(2), 0, {PoseOf(12)}, 2);
  WriteDetections(Second(2), 0, {PoseOf(13)}, 3, "DETECTIONS_SHOT");
  WriteObjects(Second(2), {Object(2, 0, 0, 2), Object(3, 0, 0, 2, "DETECTIONS_SHOT")}, 3);
  const Result<RecordedRun> run = Read();
  ASSERT_TRUE(run.ok());
  ASSERT_EQ(run->views.size(), 3U);
  ExpectSame(run->views[0].detections.at(2), PoseOf(0) * PoseOf(10));
  ExpectSame(run->views[1].detections.at(2), PoseOf(1) * PoseOf(11));
  ExpectSame(run->views[2].detections.at(2), PoseOf(2) * PoseOf(12));
  ExpectSame(run->views[2].detections.at(3), PoseOf(3) * PoseOf(13));
}

TEST_F(RecordedRunTest, ViewWithoutADetectionHasItsPlaceAndImage) {
  WriteDepth(Second(0), 500);
  WriteDetections(Second(0), 0, {}, 5);
  WriteObjects(Second(0), {}, 1);
  WriteDepth(Second(1), 600);
  WriteDetections(Second(1), 1, {PoseOf(11)}, 6);
  WriteObjects(Second(1), {Object(2, 1, 0, 1)}, 2);
  const Result<RecordedRun> run = Read();
  ASSERT_TRUE(run.ok());
  ASSERT_EQ(run->views.size(), 2U);
  EXPECT_EQ(run->views[0].utime, Second(0));
  ExpectSame(run->views[0].T_world_camera, PoseOf(5));
  ASSERT_EQ(run->views[0].depth.width, kWidth);
  EXPECT_FLOAT_EQ(run->views[0].depth.at(0, 0), 0.5F);
  EXPECT_TRUE(run->views[0].detections.empty());
}

TEST_F(RecordedRunTest, MissedObjectsLeaveAViewEmpty) {
  WriteDetections(Second(0), 0, {PoseOf(10)}, 0);
  WriteObjects(Second(0), {Object(2, 0, 0, 0)}, 1);
  WriteDetections(Second(2), 2, {PoseOf(12)}, 2);
  WriteObjects(Second(2), {Object(2, 2, 0, 2)}, 3);
  const Result<RecordedRun> run = Read();
  ASSERT_TRUE(run.ok());
  ASSERT_EQ(run->views.size(), 3U);
  EXPECT_EQ(run->views[1].utime, 0);
  EXPECT_TRUE(run->views[1].objects.objects.empty());
  EXPECT_EQ(run->views[2].utime, Second(2));
}

TEST_F(RecordedRunTest, FusionThatStartedAnewBeginsANewRun) {
  for (int view = 0; view < 3; ++view) {
    WriteDetections(Second(view), view, {PoseOf(10)}, 0);
    WriteObjects(Second(view), {Object(2, view, 0, view)}, view + 1);
  }
  WriteDetections(Second(9), 9, {PoseOf(19)}, 9);
  object_estimates_v3_t last = ObjectsOf({Object(0, 9, 0, 0)}, 1, Second(9));
  last.finished = 1;
  Write(Second(9.1), "OBJECTS", last);
  const Result<RecordedRun> run = Read();
  ASSERT_TRUE(run.ok());
  ASSERT_EQ(run->views.size(), 1U);
  EXPECT_EQ(run->views[0].utime, Second(9));
  EXPECT_FALSE(run->views[0].detections.contains(2)) << "of the run before";
  ExpectSame(run->views[0].T_world_camera, PoseOf(9));
  EXPECT_TRUE(run->finished);
}

TEST_F(RecordedRunTest, SourcesThatPointNowhereAreNoDetections) {
  WriteDetections(Second(0), 0, {PoseOf(10)}, 0);
  WriteObjects(Second(0),
               {Object(1, 0, 1, 0),
                Object(2, 0, -1, 0),
                Object(3, 5, 0, 0),
                Object(4, 0, 0, 0, "DETECTIONS_NONE"),
                Object(5, 0, 0, 1),
                Object(6, 0, 0, 0)},
               1);
  const Result<RecordedRun> run = Read();
  ASSERT_TRUE(run.ok());
  ASSERT_EQ(run->views.size(), 1U);
  EXPECT_EQ(run->views[0].detections.size(), 1U);
  EXPECT_TRUE(run->views[0].detections.contains(6));
}

TEST_F(RecordedRunTest, MessagesThatFailTheirChecksAreLeftOut) {
  WriteDetections(Second(0), 0, {PoseOf(10)}, 0);
  object_estimate_v3_t bad = EstimateAt(3, "a\xff<b>", PoseOf(1));
  WriteObjects(Second(0), {bad, Object(2, 0, 0, 0)}, 1);
  next_view_t other{};
  for (const char* channel :
       {"OBJECTS", "DETECTIONS_PPF", "ORIENTATION_HISTOGRAM", "CAMERA_A_INFO", "CAMERA_A"}) {
    Write(Second(1), channel, other);
  }
  Write(Second(1), "NEXT_VIEW", bad);
  const Result<RecordedRun> run = Read();
  ASSERT_TRUE(run.ok());
  ASSERT_EQ(run->views.size(), 1U);
  ASSERT_EQ(run->views[0].objects.objects.size(), 1U);
  EXPECT_EQ(run->views[0].objects.objects[0].instance_id, 2);
  EXPECT_EQ(run->views[0].next_view.reason, "");
  EXPECT_FALSE(run->camera.has_value());
}

TEST_F(RecordedRunTest, LogWithoutObjectsIsAnError) {
  WriteDetections(Second(0), 0, {PoseOf(10)}, 0);
  WriteObjects(Second(0), {}, 0);  // Up, but nothing was used yet.
  const Result<RecordedRun> run = Read();
  ASSERT_FALSE(run.ok());
  EXPECT_NE(run.error().message.find("run.lcm has no OBJECTS"), std::string::npos)
      << run.error().message;
}

TEST_F(RecordedRunTest, WhatIsNoLogIsAnError) {
  EXPECT_FALSE(ReadRun(scratch() / "none.lcm", "A").ok());
  std::ofstream(scratch() / "text.lcm") << "this is no log, however long it may be; not at all";
  EXPECT_FALSE(ReadRun(scratch() / "text.lcm", "A").ok());
}

TEST_F(RecordedRunTest, DamageIsToldAndTheRestRead) {
  for (int view = 0; view < 3; ++view) {
    WriteDetections(Second(view), view, {PoseOf(10)}, 0);
    WriteObjects(Second(view), {Object(2, view, 0, view)}, view + 1);
  }
  ASSERT_TRUE(Read().ok());
  std::string bytes = *ReadFileBytes(log(), 1U << 20U);
  // The third OBJECTS loses its end.
  ASSERT_TRUE(WriteFileBytes(log(), bytes.substr(0, bytes.size() - 10)).ok());
  const Result<RecordedRun> run = ReadRun(log(), "A");
  ASSERT_TRUE(run.ok());
  EXPECT_EQ(run->views.size(), 2U);
  EXPECT_NE(run->damage, "");
}

}  // namespace
}  // namespace vantage
