#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "perception/model/file_bytes.h"
#include "tests/tools/made_up_dataset.h"
#include "tests/tools/run_program.h"
#include "tools/evaluate/dataset_report.h"
#include "tools/evaluate/dataset_run.h"
#include "tools/evaluate/dataset_text.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;
using made_up::BoxPose;

ObjectModel BoxModel(const std::string& id) {
  ObjectModel model;
  model.id = id;
  model.mesh = made_up::Box();
  model.center = model.mesh.SurfaceCentroid();
  model.diameter = model.mesh.Diameter();
  return model;
}

Pose Shifted(double x) { return Eigen::Translation3d(x, 0.0, 0.0) * BoxPose(); }

// Two views of a box in one dataset; an other truth, 2 mm off, in the first.
Dataset TwoViews(bool is_segmented) {
  Dataset dataset;
  dataset.name = is_segmented ? "alone" : "clutter";
  dataset.models = {BoxModel("box"), BoxModel("other")};
  for (int i = 0; i < 2; ++i) {
    DatasetView view;
    view.name = "view" + std::to_string(i);
    view.camera = made_up::Camera();
    view.depth = made_up::Draw(made_up::Box(), BoxPose());
    view.is_segmented = is_segmented;
    view.objects.push_back({0, BoxPose(), std::nullopt, {}});
    if (i == 0) view.objects[0].T_camera_object_other = Shifted(0.002);
    if (!is_segmented) {
      for (size_t pixel = 0; pixel < view.depth.depth.size(); ++pixel) {
        if (view.depth.depth[pixel] > 0.0F && pixel % 2 == 0) {
          view.objects[0].pixels.push_back(static_cast<uint32_t>(pixel));
        }
      }
    }
    dataset.views.push_back(std::move(view));
  }
  return dataset;
}

// What an estimator of the test was asked.
struct Asked {
  std::vector<std::pair<size_t, SegmentationParameters::Support>> made;
  std::vector<int64_t> measured;  // pixels of each image
  std::vector<double> random;
};

int64_t CountMeasured(const DepthImage& depth) {
  return std::count_if(depth.depth.begin(), depth.depth.end(), [](float z) { return z > 0.0F; });
}

// Finds a good box and a bad one in the first image of every estimator, then nothing.
EstimatorMaker FakeMaker(Asked* asked) {
  return [asked](const std::string& name,
                 std::vector<ObjectModel> models,
                 SegmentationParameters::Support support) -> Result<DatasetEstimator> {
    if (name != "fake") return Error{ErrorCode::kNotFound, "no " + name};
    asked->made.emplace_back(models.size(), support);
    return DatasetEstimator(
        [asked, calls = 0](const DepthImage& depth, const CameraModel&, Rng& rng) mutable {
          asked->measured.push_back(CountMeasured(depth));
          asked->random.push_back(rng.Uniform());
          DatasetEstimate estimate;
          estimate.seconds = 0.25;
          estimate.num_clusters = 3;
          if (calls++ > 0) return estimate;
          const auto detection = [](const char* id, const Pose& T, double score) {
            Detection made;
            made.model_id = id;
            made.T_camera_object = T;
            made.verification_score = score;
            return made;
          };
          estimate.detections = {detection("box", Shifted(0.1), 0.8),
                                 detection("box", Shifted(0.001), 0.9),
                                 detection("other", BoxPose(), 0.95)};
          return estimate;
        });
  };
}

DatasetResults RunBoth(Asked* asked) {
  DatasetResults results;
  results.seed = 7;
  results.datasets = {TwoViews(true), TwoViews(false)};
  int64_t last = 0;
  const Result<bool> complete = RunDatasets(
      {"fake"},
      FakeMaker(asked),
      {},
      [&last](int64_t done, int64_t total) {
        EXPECT_EQ(done, ++last);
        EXPECT_EQ(total, 6);
      },
      &results);
  EXPECT_TRUE(complete.ok() && *complete);
  EXPECT_EQ(last, 6);
  return results;
}

TEST(RunDatasets, SegmentsAreSearchedForTheirModelAndWholeImagesForAll) {
  using Support = SegmentationParameters::Support;
  Asked asked;
  const DatasetResults results = RunBoth(&asked);
  const std::vector<std::pair<size_t, Support>> made = {{1, Support::kNone},
                                                        {1, Support::kNone},
                                                        {2, Support::kAuto},
                                                        {1, Support::kNone},
                                                        {1, Support::kNone}};
  EXPECT_EQ(asked.made, made);
  const int64_t whole = CountMeasured(results.datasets[0].views[0].depth);
  const auto labeled = static_cast<int64_t>(results.datasets[1].views[0].objects[0].pixels.size());
  EXPECT_LT(labeled, whole);
  EXPECT_EQ(asked.measured, (std::vector<int64_t>{whole, whole, whole, whole, labeled, labeled}));
  // Each image has numbers of its own, the same in every run.
  EXPECT_NE(asked.random[0], asked.random[1]);
  Asked again;
  RunBoth(&again);
  EXPECT_EQ(asked.random, again.random);
}

TEST(RunDatasets, TheBestDetectionIsJudgedAndWrongOnesAreCounted) {
  Asked asked;
  const DatasetResults results = RunBoth(&asked);
  ASSERT_EQ(results.outcomes.size(), 6U);
  const DatasetOutcome& first = results.outcomes[0];
  EXPECT_TRUE(first.is_found);
  EXPECT_TRUE(first.success.is_within);
  EXPECT_NEAR(first.success.distance, 0.001, 1e-12);
  EXPECT_LT(first.success.angle, 1e-7);
  EXPECT_NEAR(first.distance_other, 0.001, 1e-12);
  EXPECT_EQ(first.score, 0.9);
  EXPECT_EQ(first.num_wrong, 2);  // The bad box, and a model that is not there.
  EXPECT_EQ(first.num_clusters, 3);
  EXPECT_LT(first.truth_offset, 1e-6);
  const DatasetOutcome& second = results.outcomes[1];
  EXPECT_FALSE(second.is_found);
  EXPECT_FALSE(second.success.succeeded());
  EXPECT_TRUE(std::isnan(second.success.angle));
  EXPECT_TRUE(std::isnan(second.distance_other));

  const std::vector<DatasetSummary> summaries = Summarize(results);
  ASSERT_EQ(summaries.size(), 3U);
  EXPECT_EQ(summaries[1].search, DatasetSearch::kWholeImage);
  for (const DatasetSummary& summary : summaries) {
    EXPECT_EQ(summary.num_objects, 2);
    EXPECT_EQ(summary.num_found, 1);
    EXPECT_EQ(summary.num_within, 1);
    EXPECT_EQ(summary.num_succeeded, 1);
    EXPECT_EQ(summary.num_wrong, 2);
    EXPECT_NEAR(summary.median_distance, 0.001, 1e-12);
    EXPECT_EQ(summary.median_seconds, 0.25);
  }
}

TEST(RunDatasets, BarsThatAreMissedAreNamed) {
  Asked asked;
  DatasetResults results = RunBoth(&asked);
  EXPECT_TRUE(MissedBars(results).empty());
  results.datasets[0].bars = DatasetBars{1, 1.0 * kDegree};
  EXPECT_TRUE(MissedBars(results).empty());
  results.datasets[0].bars = DatasetBars{2, 1.0 * kDegree};
  ASSERT_EQ(MissedBars(results).size(), 1U);
  EXPECT_NE(MissedBars(results)[0].find("alone, fake: 1 of 2 objects found"), std::string::npos);
  // Nothing found has no median error, which is not a small one.
  results.outcomes[0].is_found = false;
  EXPECT_EQ(MissedBars(results).size(), 2U);
}

TEST(RunDatasets, StopsAndErrorsEndIt) {
  Asked asked;
  DatasetResults results;
  results.datasets = {TwoViews(true)};
  const auto none = [](int64_t, int64_t) {};
  const Result<bool> unknown = RunDatasets({"real"}, FakeMaker(&asked), {}, none, &results);
  ASSERT_FALSE(unknown.ok());
  EXPECT_EQ(unknown.error().message, "no real");
  std::stop_source stop;
  stop.request_stop();
  const Result<bool> stopped =
      RunDatasets({"fake"}, FakeMaker(&asked), stop.get_token(), none, &results);
  ASSERT_TRUE(stopped.ok());
  EXPECT_FALSE(*stopped);
}

TEST(FindEstimators, ByNameOrAll) {
  EXPECT_EQ(FindEstimators("ppf")->size(), 1U);
  EXPECT_GE(FindEstimators("all")->size(), 1U);
  ASSERT_FALSE(FindEstimators("sift").ok());
  EXPECT_NE(FindEstimators("sift").error().message.find("ppf"), std::string::npos);
}

class DatasetReport : public ScratchTest {};

TEST_F(DatasetReport, PageCsvAndJsonHoldEveryOutcome) {
  Asked asked;
  DatasetResults results = RunBoth(&asked);
  results.datasets[0].notes = {"One <note>."};
  ASSERT_TRUE(WriteDatasetReport(results, scratch() / "out").ok());
  const std::string csv = *ReadFileBytes(scratch() / "out" / "views.csv", 1U << 20U);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 7);
  EXPECT_NE(csv.find("\nalone,fake,segment,view0,box,1,1,"), std::string::npos) << csv;
  EXPECT_NE(csv.find("\nclutter,fake,whole image,view1,box,0,0,0,,,,,,,,"), std::string::npos)
      << csv;
  const auto json =
      nlohmann::json::parse(*ReadFileBytes(scratch() / "out" / "results.json", 1U << 20U));
  ASSERT_EQ(json["outcomes"].size(), 6U);
  EXPECT_EQ(json["summaries"].size(), 3U);
  EXPECT_NEAR(json["outcomes"][0]["distance_mm"], 1.0, 1e-9);
  EXPECT_TRUE(json["outcomes"][1]["T_camera_object"].is_null());
  EXPECT_TRUE(json["outcomes"][1]["angle_deg"].is_null());
  const std::string page = *ReadFileBytes(scratch() / "out" / "report.html", 1U << 24U);
  size_t pictures = 0;
  for (size_t at = page.find("<img "); at != std::string::npos; at = page.find("<img ", at + 1)) {
    ++pictures;
  }
  EXPECT_EQ(pictures, 6U);
  EXPECT_NE(page.find("One &lt;note&gt;."), std::string::npos);
  EXPECT_NE(page.find("view1, box, fake, segment: not found"), std::string::npos);
  const std::string text = DatasetText(results);
  EXPECT_NE(text.find("not found"), std::string::npos) << text;
  EXPECT_EQ(text.find("nan"), std::string::npos) << text;
}

TEST_F(DatasetReport, AFolderThatCantBeMadeIsNamed) {
  made_up::WriteText(scratch() / "file", "");
  const Result<void> written = WriteDatasetReport({}, scratch() / "file" / "out");
  ASSERT_FALSE(written.ok());
  EXPECT_NE(written.error().message.find("file/out"), std::string::npos);
}

}  // namespace
}  // namespace vantage
