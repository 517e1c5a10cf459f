#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <stop_token>

#include "tests/perception/calibration/simulated_pose_views.h"
#include "tools/evaluate/handeye_evaluation.h"
#include "tools/evaluate/handeye_methods.h"
#include "tools/evaluate/handeye_report.h"
#include "tools/evaluate/handeye_simulation.h"
#include "tools/evaluate/handeye_text.h"

namespace vantage {
namespace {

constexpr HandEyeSetup kSetups[] = {HandEyeSetup::kEyeInHand, HandEyeSetup::kEyeToHand};

// Conventions of what goes in and comes out of each method: without noise those that don't fail on
// some motions are exact.
TEST(HandEyeMethods, AreExactWithoutNoise) {
  for (const HandEyeSetup setup : kSetups) {
    HandEyeSimulation simulation;
    simulation.setup = setup;
    simulation.noise = {0.0, 0.0, 0.0, 0.0, 0.0};
    Rng rng(3);
    const SimulatedHandEye made = SimulateHandEye(simulation, rng);
    for (const HandEyeMethod& method : HandEyePeers()) {
      const auto T_x = method.calibrate(setup, made.views, HandEyeNoise());
      if (method.id == "tsai" || method.id == "horaud" || method.id == "daniilidis") continue;
      ASSERT_TRUE(T_x) << method.id;
      EXPECT_LT(HandEyeError(*T_x, made.T_x).norm(), 1e-5) << method.id;
    }
  }
}

// The bound with the hands marginalized is that of all unknowns together.
TEST(HandEyeSimulation, BoundIsThatOfAllUnknowns) {
  for (const HandEyeSetup setup : kSetups) {
    HandEyeSimulation simulation;
    simulation.setup = setup;
    simulation.views = 12;
    Rng rng(4);
    const SimulatedHandEye made = SimulateHandEye(simulation, rng);
    SimulatedPoseViews same;
    same.setup = setup;
    same.T_x = made.T_x;
    same.T_y = made.T_y;
    same.T_base_hand = made.T_base_hand;
    const HandEyeCovariance ours = HandEyeCramerRaoBound(made, simulation.noise);
    const HandEyeCovariance all = CramerRaoBound(same, simulation.noise);
    EXPECT_LT((ours - all).norm(), 1e-3 * all.norm());
  }
}

TEST(HandEyeEvaluation, SaysTheSameTwiceAndWritesAReport) {
  const std::stop_token go_on;
  HandEyeResults results;
  ASSERT_TRUE(EvaluateHandEye(
      {5, 2}, go_on, [](int64_t, int64_t) {}, &results));
  EXPECT_EQ(results.cells.size(), 18U * 9U);
  EXPECT_EQ(results.self_tests.size(), 18U);
  EXPECT_EQ(results.degenerate.size(), 16U);
  EXPECT_FALSE(results.bars.empty());
  for (const HandEyeCell& cell : results.cells) {
    if (cell.method != results.methods.front()) continue;
    EXPECT_EQ(cell.failed, 0);
    EXPECT_LT(cell.median_mm.value, 2.0);
    EXPECT_LT(cell.median_deg.value, 0.1);
  }
  HandEyeResults again;
  ASSERT_TRUE(EvaluateHandEye(
      {5, 2}, go_on, [](int64_t, int64_t) {}, &again));
  for (size_t i = 0; i < results.cells.size(); ++i) {
    EXPECT_EQ(results.cells[i].rmse_mm.high, again.cells[i].rmse_mm.high);
  }
  EXPECT_NE(HandEyeText(results).find("OpenCV, Shah"), std::string::npos);

  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / "vantage_handeye_report";
  const Result<void> written = WriteHandEyeReport(results, folder);
  ASSERT_TRUE(written) << written.error().message;
  for (const char* file : {"report.html", "handeye.csv", "figures/errors.svg"}) {
    EXPECT_GT(std::filesystem::file_size(folder / file), 1000U) << file;
  }
  std::filesystem::remove_all(folder);
}

TEST(HandEyeEvaluation, Stops) {
  std::stop_source source;
  HandEyeResults results;
  const bool is_complete = EvaluateHandEye(
      {5, 2}, source.get_token(), [&](int64_t, int64_t) { source.request_stop(); }, &results);
  EXPECT_FALSE(is_complete);
}

TEST(HandEyeBars, MissedOnesAreNamed) {
  HandEyeResults results;
  results.bars = {{"a", 1.0, 0.0, 2.0, "mm", true}, {"b", 3.0, 0.0, 2.0, "mm", false}};
  ASSERT_EQ(MissedBars(results).size(), 1U);
  EXPECT_EQ(MissedBars(results)[0], "b: 3 mm, expected at most 2");
}

}  // namespace
}  // namespace vantage
