#include "tools/evaluate/dataset_estimator.h"

#include <array>
#include <chrono>
#include <memory>
#include <utility>

#include "common/check.h"
#include "common/format.h"
#include "perception/ppf/ppf_estimator.h"
#include "perception/shot/shot_estimator.h"

namespace vantage {
namespace {

double Now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

constexpr std::array<const char*, 2> kNames = {"ppf", "shot"};

Result<std::unique_ptr<PoseEstimator>> Create(const std::string& name,
                                              std::vector<ObjectModel> models,
                                              SegmentationParameters::Support support) {
  if (name == "shot") {
    ShotEstimatorParameters parameters;
    parameters.estimation.segmentation.support = support;
    return CreateShotEstimator(std::move(models), parameters);
  }
  VANTAGE_CHECK(name == "ppf", name);
  PpfEstimatorParameters parameters;
  parameters.estimation.segmentation.support = support;
  return CreatePpfEstimator(std::move(models), parameters);
}

}  // namespace

Result<std::vector<std::string>> FindEstimators(const std::string& name) {
  std::string known;
  for (const char* one : kNames) {
    if (name == one) return std::vector<std::string>{name};
    known += std::string(one) + " or ";
  }
  if (name == "all") return std::vector<std::string>(kNames.begin(), kNames.end());
  return Error{ErrorCode::kNotFound,
               Format("estimator \"%s\", expected %sall", name.c_str(), known.c_str())};
}

Result<DatasetEstimator> MakeEstimator(const std::string& name,
                                       std::vector<ObjectModel> models,
                                       SegmentationParameters::Support support) {
  Result<std::unique_ptr<PoseEstimator>> made = Create(name, std::move(models), support);
  if (!made) return made.error();
  // A std::function is copied, an estimator is not.
  const std::shared_ptr<PoseEstimator> estimator = std::move(made).value();
  return DatasetEstimator([estimator](
                              const DepthImage& depth, const CameraModel& camera, Rng& rng) {
    StageTimes times;
    times.clock = Now;
    const double start = Now();
    const PoseEstimator::Output& output = estimator->Estimate(depth, camera, rng, &times);
    DatasetEstimate estimate;
    estimate.seconds = Now() - start;
    estimate.detections = output.detections;
    estimate.num_clusters = output.num_clusters;
    estimate.stages = {
        times.segmentation, times.normals, times.proposal, times.verification, times.refinement};
    return estimate;
  });
}

}  // namespace vantage
