// An object with four alike sides and a feature that 40 % of the directions show, as the filter of
// the paper's figure 16. Here the sum of normalized accuracy weights (eq. 10) does not leave one
// peak of four, as the paper found: each view's share of the alternatives stays in the sum. The
// belief, which multiplies, leaves one.
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "fusion/confusion/confusion_model.h"
#include "fusion/object_tracker.h"
#include "fusion/orientation_filter.h"
#include "tests/fusion/confusion/synthetic_object.h"

namespace vantage {
namespace {

const ContingencyTable& Table() {
  static const ContingencyTable table = SyntheticObject().Measure(391, 250, 41);
  return table;
}

std::shared_ptr<const ConfusionModel> Model() {
  static const auto model = std::make_shared<const ConfusionModel>(
      ConfusionModel::Make(Table(), SymmetryGroup::None()).value());
  return model;
}

// Looks from all around.
std::vector<OrientationView> Looks(const Eigen::Quaterniond& truth, int count, Rng& rng) {
  const SyntheticObject object;
  std::vector<OrientationView> views;
  for (int i = 0; i < count; ++i) {
    const Eigen::Quaterniond camera = rng.Rotation();
    views.push_back({camera * *object.Detect(camera.conjugate() * truth, rng), 0.0, camera});
  }
  return views;
}

OrientationFilter Fused(const So3Grid& grid,
                        const std::vector<OrientationView>& views,
                        const ConfusionModel* confusion,
                        FinalOrientation final_orientation = FinalOrientation::kDensityMode) {
  OrientationFilterParameters parameters;
  parameters.final_orientation = final_orientation;
  OrientationKnowledge knowledge;
  knowledge.confusion = confusion;
  OrientationFilter filter(grid, parameters, knowledge);
  filter.Fuse(views);
  return filter;
}

// Twelve views of which the sides without the feature are taken for each other evenly: four right
// by sight, eight of which each turn gets its share.
std::vector<OrientationView> TwelveViews(const Eigen::Quaterniond& truth) {
  const SyntheticObject object;
  Rng rng(42);
  std::vector<OrientationView> views;
  int num_seen = 0, num_guessed = 0;
  while (views.size() < 12) {
    const Eigen::Quaterniond camera = rng.Rotation();
    const bool seen = object.IsVisible(ViewingDirection(camera.conjugate() * truth));
    if ((seen ? num_seen : num_guessed) == (seen ? 4 : 8)) continue;
    const Eigen::Vector3d noise(rng.Normal(), rng.Normal(), rng.Normal());
    const Eigen::Quaterniond turn = object.Turn(seen ? 0 : ++num_guessed % 4);
    num_seen += seen ? 1 : 0;
    views.push_back({truth * turn * ExpSo3(object.error * noise), 0.0, camera});
  }
  return views;
}

TEST(AmbiguousObject, BeliefLeavesOneOfTheFourPeaks) {
  const So3Grid grid(32);
  const Eigen::Quaterniond truth = ExpSo3({0.3, -1.2, 0.4});
  const std::vector<OrientationView> views = TwelveViews(truth);
  for (const FinalOrientation way :
       {FinalOrientation::kDensityMode, FinalOrientation::kCwVwClustering}) {
    const OrientationFilter confidence = Fused(grid, views, nullptr, way);
    EXPECT_EQ(confidence.peaks().size(), 4U);
    EXPECT_TRUE(confidence.belief().empty());
    const OrientationFilter accuracy = Fused(grid, views, Model().get(), way);
    ASSERT_FALSE(accuracy.peaks().empty());
    EXPECT_LT(GeodesicAngle(accuracy.peaks().front().q, truth), 1.0 * kDegree);
    ASSERT_FALSE(accuracy.belief().empty());
    EXPECT_GT(accuracy.belief().front().probability, 0.99);
  }
}

TEST(AmbiguousObject, TheBestPeakIsThatOfTheBeliefAndMoreOftenRight) {
  const So3Grid grid(16);
  Rng rng(43);
  int right_by_confidence = 0;
  int right_by_accuracy = 0;
  constexpr int kRuns = 60;
  for (int run = 0; run < kRuns; ++run) {
    const Eigen::Quaterniond truth = rng.Rotation();
    const std::vector<OrientationView> views = Looks(truth, 5, rng);
    const OrientationFilter confidence = Fused(grid, views, nullptr);
    const OrientationFilter accuracy = Fused(grid, views, Model().get());
    const Eigen::Quaterniond best = accuracy.belief().front().q_world_object;
    EXPECT_LT(GeodesicAngle(best, accuracy.peaks().front().q), 3.0 * kDegree) << run;
    const auto is_right = [&](const OrientationFilter& filter) {
      return GeodesicAngle(filter.peaks().front().q, truth) < 5.0 * kDegree;
    };
    right_by_confidence += is_right(confidence) ? 1 : 0;
    right_by_accuracy += is_right(accuracy) ? 1 : 0;
  }
  EXPECT_GT(right_by_accuracy, right_by_confidence);
  EXPECT_GT(right_by_accuracy, kRuns * 9 / 10);
}

TEST(AmbiguousObject, ViewsWithoutACameraCountAsDetected) {
  const So3Grid grid(16);
  Rng rng(44);
  std::vector<OrientationView> views = Looks(rng.Rotation(), 5, rng);
  for (OrientationView& view : views) view.q_world_camera.reset();
  const OrientationFilter with = Fused(grid, views, Model().get());
  const OrientationFilter without = Fused(grid, views, nullptr);
  EXPECT_TRUE(with.belief().empty());
  ASSERT_EQ(with.peaks().size(), without.peaks().size());
  for (size_t i = 0; i < with.peaks().size(); ++i) {
    EXPECT_EQ(with.peaks()[i].q.coeffs(), without.peaks()[i].q.coeffs());
  }
}

TEST(AmbiguousObject, ViewsRefuseACameraThatIsNoOrientation) {
  OrientationView view;
  view.q_world_camera = Eigen::Quaterniond(0.5, 0.0, 0.0, 0.0);
  EXPECT_FALSE(view.Validate().ok());
  view.q_world_camera = Eigen::Quaterniond::Identity();
  EXPECT_TRUE(view.Validate().ok());
}

TEST(AmbiguousObject, ChangedViewsAreFusedAgain) {
  const So3Grid grid(16);
  Rng rng(45);
  const std::vector<OrientationView> views = Looks(rng.Rotation(), 5, rng);
  OrientationFilter filter = Fused(grid, views, Model().get());
  std::vector<OrientationView> other = views;
  other[2].q_world_camera = rng.Rotation();
  filter.Fuse(other);
  const OrientationFilter fresh = Fused(grid, other, Model().get());
  ASSERT_EQ(filter.belief().size(), fresh.belief().size());
  EXPECT_EQ(filter.belief().front().probability, fresh.belief().front().probability);
  EXPECT_EQ(filter.peaks().front().q.coeffs(), fresh.peaks().front().q.coeffs());
  filter.Fuse({});
  EXPECT_TRUE(filter.belief().empty());
}

TEST(AmbiguousObject, TrackerTellsItsBeliefAndRestoresIt) {
  const So3Grid grid(16);
  const auto models = [] {
    std::map<std::string, TrackedModel> all;
    all["synthetic"].confusion = Model();
    return all;
  };
  ObjectTracker tracker(grid, {}, models());
  Rng rng(46);
  const SyntheticObject object;
  const Eigen::Quaterniond truth = rng.Rotation();
  for (int i = 0; i < 6; ++i) {
    DetectionSet set;
    set.channel = "TEST";
    set.seq = i;
    set.T_world_camera = LookAt(rng.UnitVector(), Eigen::Vector3d::Zero());
    const Eigen::Quaterniond camera(set.T_world_camera.linear());
    Detection detection;
    detection.model_id = "synthetic";
    detection.verification_score = 0.9;
    Pose T_world_object = Pose::Identity();
    T_world_object.linear() =
        (camera * *object.Detect(camera.conjugate() * truth, rng)).toRotationMatrix();
    detection.T_camera_object = set.T_world_camera.inverse() * T_world_object;
    set.detections.push_back(detection);
    ASSERT_TRUE(tracker.Add(set).changed);
  }
  const std::vector<ObjectEstimate> estimates = tracker.Estimates();
  ASSERT_EQ(estimates.size(), 1U);
  ASSERT_FALSE(estimates.front().belief.empty());
  EXPECT_LT(GeodesicAngle(estimates.front().belief.front().q_world_object,
                          Eigen::Quaterniond(estimates.front().T_world_object.linear())),
            3.0 * kDegree);
  ObjectTracker other(grid, {}, models());
  ASSERT_TRUE(other.Restore(ParseTrackerState(FormatTrackerState(tracker.state())).value()).ok());
  const ObjectEstimate restored = other.Estimates().front();
  EXPECT_EQ(restored.T_world_object.matrix(), estimates.front().T_world_object.matrix());
  ASSERT_EQ(restored.belief.size(), estimates.front().belief.size());
  for (size_t i = 0; i < restored.belief.size(); ++i) {
    EXPECT_EQ(restored.belief[i].probability, estimates.front().belief[i].probability);
  }
}

}  // namespace
}  // namespace vantage
