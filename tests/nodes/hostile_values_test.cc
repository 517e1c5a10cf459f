// Messages that decode but whose numbers are as bad as can be, through the nodes over a log:
// nothing ends them (run it under ASan and UBSan too), what they publish is sound, and good
// messages afterwards are worked on as ever.

#include "tests/bus/support/hostile_values.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <span>

#include "bus/conversions.h"
#include "bus/image_conversion.h"
#include "bus/log_bus.h"
#include "nodes/estimator_node.h"
#include "nodes/fusion_node.h"
#include "nodes/ppf_config.h"
#include "perception/model/model_builder.h"
#include "perception/model/model_generator.h"
#include "tests/bus/support/temporary_folder.h"
#include "tests/perception/test_scenes.h"
#include "vantage/arm_status_t.hpp"
#include "vantage/next_view_t.hpp"
#include "vantage/object_estimates_v3_t.hpp"
#include "vantage/orientation_histogram_t.hpp"

namespace vantage {
namespace {

constexpr int64_t kStart = 1'700'000'000'000'000;
constexpr int kWidth = 64;
constexpr int kHeight = 48;
constexpr int kBurst = 20;  // hostile messages between good ones

class HostileValues : public testing::Test {
 protected:
  template <class Message>
  void Write(const std::string& channel, const Message& message) {
    ASSERT_TRUE(writer->Write(utime, channel, Encode(message)).ok());
  }

  void OpenBus() {
    ASSERT_TRUE(writer->Close().ok());
    auto opened = LogBus::Create({}, std::move(EventLogReader::Open(log)).value(), nullptr);
    ASSERT_TRUE(opened.ok());
    bus = std::move(opened).value();
  }

  TemporaryFolder folder;
  const std::filesystem::path log = folder.path() / "in.log";
  std::unique_ptr<EventLogWriter> writer = std::move(EventLogWriter::Create(log)).value();
  std::unique_ptr<LogBus> bus;
  int64_t utime = kStart;
};

class PpfHostileValues : public HostileValues {
 protected:
  [[nodiscard]] camera_info_t Info() const {
    return CameraToMessage(camera, {"CAM", "", "", false, ""}, utime, 0);
  }
  // A table with a block on it.
  [[nodiscard]] images_t Images(int64_t image_seq, DepthCompression compression) const {
    std::vector<uint16_t> depth(kWidth * kHeight, 700);
    for (int v = 15; v < 33; ++v) {
      for (int u = 22; u < 42; ++u) depth[static_cast<size_t>(v * kWidth + u)] = 620;
    }
    return DepthToMessage(kWidth, kHeight, depth, utime, image_seq, "", compression);
  }
  [[nodiscard]] rigid_transform_t CameraPose() const {
    return PoseToMessage(T_world_camera, utime);
  }

  // A second of rest with two images in it: the first may fall to what came before.
  void WriteGood(bool with_info) {
    if (with_info) Write("CAMERA_CAM_INFO", Info());
    for (int i = 0; i <= 20; ++i, utime += 50'000) {
      Write("CAMERA_CAM_TO_WORLD", CameraPose());
      if (i == 6) Write("CAMERA_CAM", Images(seq++, DepthCompression::kZlib));
      if (i == 14) {
        expected.insert(seq);
        Write("CAMERA_CAM", Images(seq++, DepthCompression::kZlib));
      }
    }
  }

  template <class Message>
  void WriteBursts(const std::string& channel, const Message& sound) {
    int count = 0;
    for (const Message& variant : HostileVariants(sound)) {
      Write(channel, variant);
      if (++count % kBurst == 0) WriteGood(true);
    }
    WriteGood(true);
  }

  void Run() {
    OpenBus();
    const Result<GeneratedObject> object = GenerateObject("bracket");
    std::vector<ObjectModel> models;
    models.push_back(
        BuildObjectModel("bracket", object->mesh, object->symmetry, "generated", {}).value());
    PpfConfig config;
    config.camera = "CAM";
    config.estimator.estimation.segmentation.min_points = 50;
    auto estimator = CreatePpfEstimator(std::move(models), config.estimator);
    ASSERT_TRUE(estimator.ok()) << estimator.error().message;
    auto node = EstimatorNode::Create(
        *bus, config, "ppf", EstimateBy(std::move(estimator).value(), config.seed));
    ASSERT_TRUE(node.ok());
    const auto check = [this](const Envelope&, const detections_v2_t& message) {
      const Result<DetectionSet> set = DetectionsFromMessage(message, "DETECTIONS_PPF");
      EXPECT_TRUE(set.ok()) << set.error().message;
      found.insert(message.image_seq);
      num_clusters += message.num_clusters;
    };
    ASSERT_TRUE(bus->Subscribe<detections_v2_t>("DETECTIONS_PPF", {}, check).ok());
    ASSERT_TRUE(bus->Run().ok());
    for (const int64_t each : expected) EXPECT_TRUE(found.contains(each)) << "image " << each;
    EXPECT_GT(num_clusters, 0);
  }

  CameraModel camera{
      .width = kWidth, .height = kHeight, .fx = 57.0, .fy = 57.0, .cx = 31.5, .cy = 23.5};
  Pose T_world_camera = LookAt({0.0, -0.1, 0.7}, {0.0, 0.0, 0.0});
  int64_t seq = 1000;
  std::set<int64_t> expected;  // seq of images that must be worked on
  std::set<int64_t> found;
  int64_t num_clusters = 0;
};

TEST_F(PpfHostileValues, Poses) {
  WriteGood(true);
  WriteBursts("CAMERA_CAM_TO_WORLD", CameraPose());
  Run();
}

TEST_F(PpfHostileValues, Images) {
  WriteGood(true);
  WriteBursts("CAMERA_CAM", Images(1, DepthCompression::kNone));
  WriteBursts("CAMERA_CAM", Images(1, DepthCompression::kZlib));
  Run();
}

TEST_F(PpfHostileValues, Calibrations) {
  WriteGood(true);
  WriteBursts("CAMERA_CAM_INFO", Info());
  // Those that are taken are used.
  expected.clear();
  for (const camera_info_t& variant : HostileVariants(Info())) {
    if (!CameraFromMessage(variant)) continue;
    Write("CAMERA_CAM_INFO", variant);
    WriteGood(false);
    expected.clear();
  }
  WriteGood(true);
  Run();
}

class FusionHostileValues : public HostileValues {
 protected:
  [[nodiscard]] FusionConfig Config() const {
    FusionConfig config;
    config.k = 16;
    config.models["mug"] = {Eigen::Vector3d(0.01, 0.0, 0.04), 0.12};
    config.shapes["mug"] = {MakeBox({-0.02F, -0.02F, 0.0F}, {0.04F, 0.02F, 0.08F}), 0.06};
    config.setup = "mug";
    config.state_file = folder.path() / "state";
    return config;
  }

  detections_v2_t Detections() {
    const double angle = 0.7 * static_cast<double>(seq);
    const Pose T_world_camera =
        LookAt({0.6 * std::cos(angle), 0.6 * std::sin(angle), 0.5}, {0.0, 0.0, 0.05});
    DetectionSet set;
    set.utime = utime;
    set.seq = seq;
    set.camera = "CAM";
    set.image_seq = seq++;
    set.estimator = "ppf";
    set.T_world_camera = T_world_camera;
    set.num_clusters = 1;
    set.detections.push_back({.model_id = "mug",
                              .cluster = 0,
                              .T_camera_object = T_world_camera.inverse(),
                              .mse = 1e-6,
                              .inlier_fraction = 0.9,
                              .verification_score = 0.8});
    return DetectionsToMessage(set);
  }
  [[nodiscard]] arm_status_t ArmStatus(int8_t state) const {
    arm_status_t status{};
    status.utime = utime;
    status.name = "CAM";
    status.state = state;
    return status;
  }

  void WriteGood() {
    utime += 1'000'000;
    Write("CAMERA_CAM_TO_WORLD", PoseToMessage(Pose::Identity(), utime));
    Write("DETECTIONS_PPF", Detections());
    ++num_good;
  }

  template <class Message>
  void WriteBursts(const std::string& channel, const Message& sound) {
    int count = 0;
    for (Message& variant : HostileVariants(sound)) {
      // Else it would be taken for the same message, sent again.
      if constexpr (requires { variant.seq; }) {
        if (variant.seq == sound.seq) variant.seq = seq++;
      }
      Write(channel, variant);
      if (++count % kBurst == 0) WriteGood();
    }
    WriteGood();
  }

  static void ExpectAllFinite(std::span<const double> values, const char* what) {
    for (const double value : values) EXPECT_TRUE(std::isfinite(value)) << what;
  }

  void Check(const object_estimates_v3_t& message) {
    EXPECT_TRUE(IsPlausibleUtime(message.utime));
    for (const object_estimate_v3_t& object : message.objects) {
      ExpectAllFinite(object.trans, "trans");
      ExpectAllFinite(object.trans_covariance, "trans_covariance");
      ExpectAllFinite(std::array{object.entropy, object.last_change}, "entropy, last_change");
      EXPECT_GT(object.num_peaks, 0);
      for (const orientation_peak_v2_t& peak : object.peaks) {
        EXPECT_TRUE(QuaternionFromWire(peak.quat).ok());
        EXPECT_TRUE(peak.weight >= 0.0 && peak.weight <= 1.0 + 1e-9) << peak.weight;
        EXPECT_TRUE(std::isfinite(peak.spread));
        const double* c = peak.covariance;
        ExpectAllFinite(peak.covariance, "covariance");
        EXPECT_NEAR(c[0] + c[4] + c[8], peak.spread * peak.spread, 1e-12);
      }
    }
    last = message;
    ++num_objects_messages;
  }

  void Check(const next_view_t& message) {
    EXPECT_TRUE(IsPlausibleUtime(message.utime));
    EXPECT_GE(message.selected, -1);
    EXPECT_LT(message.selected, message.num_candidates);
    for (const view_candidate_t& candidate : message.candidates) {
      EXPECT_TRUE(PoseFromWire(candidate.trans, candidate.quat).ok());
      ExpectAllFinite(std::array{candidate.gain, candidate.cost}, "gain, cost");
    }
    ++num_next_views;
  }

  void Check(const orientation_histogram_t& message) {
    for (const float weight : message.weight) EXPECT_TRUE(weight >= 0.0F && std::isfinite(weight));
  }

  template <class Message>
  void CheckAll(const std::string& channel) {
    ASSERT_TRUE(bus->Subscribe<Message>(
                       channel, {}, [this](const Envelope&, const Message& m) { Check(m); })
                    .ok());
  }

  void Run() {
    OpenBus();
    auto node = MakeFusionNode(*bus, Config(), true);
    ASSERT_TRUE(node.ok()) << node.error().message;
    CheckAll<object_estimates_v3_t>("OBJECTS");
    CheckAll<next_view_t>("NEXT_VIEW");
    CheckAll<orientation_histogram_t>("ORIENTATION_HISTOGRAM");
    ASSERT_TRUE(bus->Run().ok());
    EXPECT_GE(num_objects_messages, num_good);
    EXPECT_GT(num_next_views, 0);
    ASSERT_FALSE(last.objects.empty());
    ExpectStateLoads();
  }

  // What was saved along the way is what the next process takes up.
  void ExpectStateLoads() {
    writer = std::move(EventLogWriter::Create(log)).value();
    WriteGood();
    OpenBus();
    const auto node = MakeFusionNode(*bus, Config(), false);
    ASSERT_TRUE(node.ok()) << node.error().message;
    const size_t objects = last.objects.size();
    CheckAll<object_estimates_v3_t>("OBJECTS");
    ASSERT_TRUE(bus->Run().ok());
    EXPECT_GE(last.objects.size(), objects);
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "state.bad"));
  }

  int64_t seq = 1;
  int num_good = 0;
  int num_objects_messages = 0;
  int num_next_views = 0;
  object_estimates_v3_t last{};
};

TEST_F(FusionHostileValues, Detections) {
  WriteGood();
  WriteBursts("DETECTIONS_PPF", Detections());
  Run();
}

TEST_F(FusionHostileValues, ArmStatusAndPoses) {
  WriteGood();
  for (const int8_t state : {arm_status_t::RESTING, arm_status_t::MOVING, arm_status_t::REFUSED}) {
    WriteBursts("ARM_STATUS", ArmStatus(state));
  }
  WriteBursts("CAMERA_CAM_TO_WORLD", PoseToMessage(Pose::Identity(), utime));
  Run();
}

}  // namespace
}  // namespace vantage
