// The datasets that others published, where they are there.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "common/statistics.h"
#include "tools/evaluate/dataset_run.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

const fs::path kData = fs::path(VANTAGE_SOURCE_DIR) / "../shared/data";

// Truths agree with the images to the sensor's accuracy, or the frames are mixed up.
void ExpectTruthOnMeasurements(const DatasetResults& results) {
  for (const DatasetOutcome& outcome : results.outcomes) EXPECT_LT(outcome.truth_offset, 0.002);
}

DatasetResults Evaluate(Dataset dataset, const EstimatorMaker& make = MakeEstimator) {
  DatasetResults results;
  results.seed = 1;
  results.datasets.push_back(std::move(dataset));
  const Result<bool> complete = RunDatasets(
      {"ppf"}, make, {}, [](int64_t, int64_t) {}, &results);
  EXPECT_TRUE(complete.ok() && *complete);
  return results;
}

TEST(RealDataset, BunnyOnATurntable) {
  const fs::path folder = kData / "bunny_turntable_36views";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  Result<Dataset> dataset = LoadDataset(folder, kData / "meshes");
  ASSERT_TRUE(dataset.ok()) << dataset.error().message;
  ASSERT_EQ(dataset->views.size(), 36U);
  ASSERT_TRUE(dataset->bars.has_value());
  EXPECT_EQ(dataset->bars->min_found, 35);
  // Some, for time; all of them are the tool's.
  for (size_t i = 0; i < 3; ++i) dataset->views[i] = dataset->views[12 * i];
  dataset->views.resize(3);
  const DatasetResults results = Evaluate(*std::move(dataset));
  ExpectTruthOnMeasurements(results);
  const DatasetSummary summary = Summarize(results).at(0);
  EXPECT_EQ(summary.num_within, 3);
  EXPECT_LT(summary.median_angle, 1.0 * kDegree);
}

TEST(RealDataset, CutOutOfAScene) {
  const fs::path folder = kData / "pcl_milk";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  Result<Dataset> dataset = LoadDataset(folder, kData / "meshes");
  ASSERT_TRUE(dataset.ok()) << dataset.error().message;
  const DatasetResults results = Evaluate(*std::move(dataset));
  ExpectTruthOnMeasurements(results);
  ASSERT_EQ(results.outcomes.size(), 2U);
  for (const DatasetOutcome& outcome : results.outcomes) {
    EXPECT_TRUE(outcome.is_found) << Name(outcome.search);
    EXPECT_LT(outcome.success.angle, 0.1 * kDegree);
    EXPECT_LT(outcome.success.distance, 0.0005);
  }
}

TEST(RealDataset, YcbvFrames) {
  const fs::path folder = kData / "ycbv_two_frames";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  Result<Dataset> dataset = LoadDataset(folder, kData / "meshes");
  ASSERT_TRUE(dataset.ok()) << dataset.error().message;
  EXPECT_EQ(dataset->models.size(), 4U);
  ASSERT_EQ(dataset->views.size(), 2U);
  EXPECT_EQ(dataset->views[0].objects.size(), 2U);
  EXPECT_EQ(dataset->views[1].objects.size(), 2U);
  // The truths alone: estimates take long here.
  const EstimatorMaker idle = [](const std::string&, auto, auto) -> Result<DatasetEstimator> {
    return DatasetEstimator(
        [](const DepthImage&, const CameraModel&, Rng&) { return DatasetEstimate(); });
  };
  const DatasetResults results = Evaluate(*std::move(dataset), idle);
  EXPECT_EQ(results.outcomes.size(), 8U);
  ExpectTruthOnMeasurements(results);
}

TEST(RealDataset, AShelfIsDeclined) {
  const fs::path folder = kData / "apc_shelf_binE_15views";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const Result<Dataset> dataset = LoadDataset(folder, kData / "meshes");
  ASSERT_FALSE(dataset.ok());
  EXPECT_NE(dataset.error().message.find("no exact ground truth"), std::string::npos);
}

}  // namespace
}  // namespace vantage
