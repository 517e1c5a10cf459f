#include <gtest/gtest.h>

#include "common/depth_rasterizer.h"
#include "perception/model/model_builder.h"
#include "perception/model/model_generator.h"
#include "perception/ppf/ppf_estimator.h"
#include "tests/tools/run_fixtures.h"
#include "tools/replay/estimate_ahead.h"
#include "tools/support/shaded_scene.h"

namespace vantage {
namespace {

constexpr uint64_t kSeed = 3;
constexpr size_t kManyBytes = size_t{1} << 30U;

bool IsSame(const PoseEstimator::Output& a, const PoseEstimator::Output& b) {
  if (a.num_clusters != b.num_clusters || a.detections.size() != b.detections.size()) return false;
  for (size_t i = 0; i < a.detections.size(); ++i) {
    if (!(a.detections[i].T_camera_object.matrix() == b.detections[i].T_camera_object.matrix())) {
      return false;
    }
  }
  return true;
}

/// Images of a bracket, one an event, and what an estimator finds in them.
class EstimateAheadTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const Result<GeneratedObject> object = GenerateObject("bracket");
    std::vector<ObjectModel> models;
    models.push_back(
        BuildObjectModel("bracket", object->mesh, object->symmetry, "generated", {}).value());
    const TriangleMesh mesh = models[0].mesh;
    prototype = CreatePpfEstimator(std::move(models), PpfEstimatorParameters()).value();
    for (int i = 0; i < 12; ++i) {
      const double azimuth = 0.5 * i;
      const Pose T_camera_world =
          LookAt({0.5 * std::cos(azimuth), 0.5 * std::sin(azimuth), 0.4}, {0.0, 0.0, 0.03})
              .inverse();
      DepthRasterizer rasterizer(camera);
      rasterizer.Clear();
      rasterizer.Draw(TableMesh({0.0, 0.0, 0.0}, 0.8, 0.8, 0.02), T_camera_world);
      rasterizer.Draw(mesh, T_camera_world);
      DepthFrame frame;
      frame.utime = 1'000'000 + i;
      frame.image = DepthImage(camera.width, camera.height);
      const auto depth = rasterizer.depth();
      for (size_t k = 0; k < frame.image.depth.size(); ++k) {
        if (depth[k] < 60.0F) frame.image.depth[k] = depth[k];
      }
      frames.push_back(std::move(frame));
    }
    const EstimateFunction estimate = EstimateBy(prototype->Clone(), kSeed);
    for (const DepthFrame& frame : frames) expected.push_back(estimate(frame, camera, nullptr));
  }
  static void TearDownTestSuite() {
    frames.clear();
    expected.clear();
    prototype.reset();
  }

  void Make(size_t most_bytes = kManyBytes) {
    ahead = std::make_unique<EstimateAhead>([this] { return event; }, most_bytes);
    ends = ahead->Add(prototype, kSeed);
  }
  /// A scout that comes over `frame_of(event)`.
  void Start(int num_threads, const std::function<const DepthFrame*(size_t)>& frame_of) {
    EstimateAhead::Scout scout;
    auto scouted = std::make_shared<int64_t>(0);
    scout.step = [this, scouted, frame_of] {
      if (*scouted == static_cast<int64_t>(frames.size())) return false;
      const DepthFrame* frame = frame_of(static_cast<size_t>((*scouted)++));
      if (frame == nullptr) return true;
      EXPECT_TRUE(ends.ask(*frame, camera, nullptr).detections.empty());
      return true;
    };
    scout.num_events = [scouted] { return *scouted; };
    ahead->Start(std::move(scout), num_threads);
  }
  void Start(int num_threads) {
    Start(num_threads, [](size_t i) { return &frames[i]; });
  }
  const PoseEstimator::Output& Answer(size_t i) {
    event = static_cast<int64_t>(i) + 1;
    return ends.answer(frames[i], camera, nullptr);
  }
  void ExpectAllRight() {
    for (size_t i = 0; i < frames.size(); ++i) {
      EXPECT_TRUE(IsSame(Answer(i), expected[i])) << "image " << i;
    }
    const EstimateAhead::Counters counters = ahead->counters();
    EXPECT_EQ(counters.num_taken + counters.num_own, static_cast<int64_t>(frames.size()));
  }

  int64_t event = 0;
  std::unique_ptr<EstimateAhead> ahead;
  EstimateAhead::Ends ends;
  static inline const CameraModel camera;
  static inline std::vector<DepthFrame> frames;
  static inline std::vector<PoseEstimator::Output> expected;
  static inline std::shared_ptr<const PoseEstimator> prototype;
};

TEST_F(EstimateAheadTest, ImagesDiffer) {
  for (size_t i = 1; i < expected.size(); ++i) EXPECT_FALSE(IsSame(expected[i], expected[0])) << i;
}

TEST_F(EstimateAheadTest, AnswersAreThoseOfTheEstimator) {
  for (const int num_threads : {0, 1, 3}) {
    Make();
    Start(num_threads);
    ExpectAllRight();
    EXPECT_EQ(ahead->counters().num_unasked, 0);
  }
}

TEST_F(EstimateAheadTest, OneImageMayBeLargerThanWhatMayWait) {
  Make(1);
  Start(2);
  ExpectAllRight();
  EXPECT_EQ(ahead->counters().num_unasked, 0);
}

TEST_F(EstimateAheadTest, OtherImagesThanThoseAskedForAreEstimatedAnew) {
  // The scout saw one pixel another way, or another time.
  std::vector<DepthFrame> others = frames;
  for (size_t i = 0; i < others.size(); ++i) {
    if (i % 2 == 0) {
      others[i].image.depth[100] = std::isnan(others[i].image.depth[100]) ? 1.0F : NAN;
    } else {
      others[i].utime += 1;
    }
  }
  Make();
  Start(2, [&](size_t i) { return &others[i]; });
  ExpectAllRight();
  EXPECT_EQ(ahead->counters().num_unasked, static_cast<int64_t>(frames.size()));
}

TEST_F(EstimateAheadTest, AnotherCameraIsAnotherImage) {
  Make();
  Start(1);
  event = 1;
  CameraModel other = camera;
  other.fx *= 1.1;
  const EstimateFunction estimate = EstimateBy(prototype->Clone(), kSeed);
  EXPECT_TRUE(IsSame(ends.answer(frames[0], other, nullptr), estimate(frames[0], other, nullptr)));
  EXPECT_EQ(ahead->counters().num_unasked, 1);
}

TEST_F(EstimateAheadTest, ScoutThatSeesLessOrMoreCostsNothingButTime) {
  Make();
  Start(2, [](size_t i) { return i % 3 == 0 ? &frames[i] : nullptr; });
  ExpectAllRight();
  EXPECT_EQ(ahead->counters().num_unasked, 8);
  Make();
  Start(2);
  for (const size_t i : {2, 3, 7, 11}) EXPECT_TRUE(IsSame(Answer(i), expected[i]));
  EXPECT_EQ(ahead->counters().num_unasked, 0);
}

TEST_F(EstimateAheadTest, EndsEarlyAtAnyTime) {
  for (size_t count = 0; count < 4; ++count) {
    Make();
    Start(3);
    for (size_t i = 0; i < count; ++i) EXPECT_TRUE(IsSame(Answer(i), expected[i]));
    ahead.reset();
  }
  Make();
  ahead.reset();  // Never started.
}

TEST_F(EstimateAheadTest, ScoutThatFailsAtOnce) {
  Make();
  ahead->Start({[] { return false; }, [] { return int64_t{0}; }}, 2);
  ExpectAllRight();
  EXPECT_EQ(ahead->counters().num_own, static_cast<int64_t>(frames.size()));
}

}  // namespace
}  // namespace vantage
