#include <gtest/gtest.h>

#include <cmath>
#include <stop_token>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "fusion/orientation_histogram.h"
#include "fusion/peaks.h"
#include "tests/tools/placed_orientation.h"
#include "tools/evaluate/clustering_sweep.h"

namespace vantage {
namespace {

// A sequence and the orientations in the world that its views detected.
struct MadeUp {
  DetectionSequence sequence;
  Eigen::Quaterniond truth;
  std::vector<OrientationView> views;
};

MadeUp MakeUp(const SymmetryGroup& symmetry, int num_views, Rng& rng) {
  MadeUp made_up;
  made_up.truth = rng.Rotation();
  made_up.sequence.T_world_object = PlacedOrientation(made_up.truth, rng);
  const auto order = static_cast<uint32_t>(symmetry.elements.size());
  for (int i = 0; i < num_views; ++i) {
    DetectedView view;
    view.T_world_camera = PlacedOrientation(rng.Rotation(), rng);
    const Eigen::Vector3d error(rng.Normal(), rng.Normal(), rng.Normal());
    const Eigen::Quaterniond q = i % 3 == 1 ? rng.Rotation()
                                            : made_up.truth * symmetry.elements[rng.Below(order)] *
                                                  ExpSo3(2.0 * kDegree * error);
    const double mse = rng.Uniform(0.0, 1e-5);
    Detection best;
    best.T_camera_object = view.T_world_camera.inverse() * PlacedOrientation(q, rng);
    best.mse = mse;
    Detection second;  // Never looked at.
    second.T_camera_object = PlacedOrientation(rng.Rotation(), rng);
    view.detections = {best, second};
    made_up.sequence.views.push_back(view);
    made_up.views.push_back({q, mse});
    if (i % 4 == 0) made_up.sequence.views.emplace_back();  // Nothing was found there.
  }
  return made_up;
}

TEST(ClusteringSweep, EqualsFindingThePeaksOfEveryPair) {
  const So3Grid grid(16);
  Rng rng(1);
  const SymmetryGroup symmetry = SymmetryGroup::Cyclic(2, Eigen::Vector3d::UnitX());
  std::vector<MadeUp> made_up;
  for (int i = 0; i < 6; ++i) made_up.push_back(MakeUp(symmetry, 4 + i, rng));
  made_up.push_back(MakeUp(symmetry, 0, rng));  // Never seen: not in the mean.
  std::vector<EvaluatedSequence> sequences;
  for (const MadeUp& each : made_up) sequences.push_back({&each.sequence, &symmetry});
  constexpr double kWrongModeDeg = 1.5;
  const ClusteringSweep sweep = SweepClustering(grid, {}, sequences, kWrongModeDeg, 1, {});
  const ClusteringSweep threaded = SweepClustering(grid, {}, sequences, kWrongModeDeg, 3, {});

  ASSERT_GE(sweep.w_min.size(), 10U);
  ASSERT_EQ(sweep.mean_error_deg.size(), sweep.w_min.size());
  bool any_wrong = false;
  for (size_t i = 0; i < sweep.w_min.size(); ++i) {
    ASSERT_EQ(sweep.mean_error_deg[i].size(), sweep.w_max.size());
    for (size_t j = 0; j < sweep.w_max.size(); ++j) {
      if (sweep.w_min[i] > sweep.w_max[j]) {
        EXPECT_TRUE(std::isnan(sweep.mean_error_deg[i][j]));
        EXPECT_TRUE(std::isnan(sweep.wrong_mode_rate[i][j]));
        EXPECT_TRUE(std::isnan(threaded.mean_error_deg[i][j]));
        continue;
      }
      double sum = 0.0;
      double num_wrong = 0.0;
      for (const MadeUp& each : made_up) {
        if (each.views.empty()) continue;
        OrientationHistogram histogram(grid);
        for (const OrientationView& view : each.views) {
          const double w_v = std::exp(-0.5 * std::pow(view.mse / 6.25e-6, 2));
          histogram.Add(view.q_world_object, 4.0 * kDegree, w_v);
        }
        const auto peaks = FindPeaks(histogram, {.w_min = sweep.w_min[i], .w_max = sweep.w_max[j]});
        double error = M_PI;
        for (const Eigen::Quaterniond& element : symmetry.elements) {
          error = std::min(error, GeodesicAngle(peaks.front().q * element, each.truth));
        }
        sum += error / kDegree;
        num_wrong += error > kWrongModeDeg * kDegree ? 1.0 : 0.0;
      }
      any_wrong = any_wrong || num_wrong > 0.0;
      // The order of rounding apart; cells may not change clusters by it.
      EXPECT_NEAR(sweep.mean_error_deg[i][j], sum / 6.0, 1e-6) << i << ' ' << j;
      // The seventh sequence has no detection and counts as wrong.
      EXPECT_EQ(sweep.wrong_mode_rate[i][j], (num_wrong + 1.0) / 7.0);
      EXPECT_EQ(threaded.mean_error_deg[i][j], sweep.mean_error_deg[i][j]);
      EXPECT_EQ(threaded.wrong_mode_rate[i][j], sweep.wrong_mode_rate[i][j]);
    }
  }
  EXPECT_TRUE(any_wrong);  // Otherwise the rates were compared in vain.
}

TEST(ClusteringSweep, WithoutDetectionsThereIsNoError) {
  const So3Grid grid(8);
  Rng rng(2);
  const SymmetryGroup symmetry = SymmetryGroup::None();
  const MadeUp nothing = MakeUp(symmetry, 0, rng);
  const std::vector<EvaluatedSequence> unseen = {{&nothing.sequence, &symmetry}};
  for (const auto& sequences : {std::vector<EvaluatedSequence>{}, unseen}) {
    const ClusteringSweep sweep = SweepClustering(grid, {}, sequences, 10.0, 2, {});
    for (size_t i = 0; i < sweep.w_min.size(); ++i) {
      EXPECT_TRUE(std::isnan(sweep.mean_error_deg[i].back()));
      EXPECT_EQ(std::isnan(sweep.wrong_mode_rate[i].back()), sequences.empty());
      if (!sequences.empty()) {
        EXPECT_EQ(sweep.wrong_mode_rate[i].back(), 1.0);
      }
    }
  }
}

TEST(ClusteringSweep, StopsWhenAsked) {
  const So3Grid grid(8);
  Rng rng(3);
  const SymmetryGroup symmetry = SymmetryGroup::None();
  const MadeUp made_up = MakeUp(symmetry, 5, rng);
  const std::vector<EvaluatedSequence> sequences(20, {&made_up.sequence, &symmetry});
  std::stop_source stop;
  stop.request_stop();
  const ClusteringSweep sweep = SweepClustering(grid, {}, sequences, 10.0, 2, stop.get_token());
  EXPECT_TRUE(std::isnan(sweep.mean_error_deg.front().back()));
}

}  // namespace
}  // namespace vantage
