#include "tools/evaluate/dataset_run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/depth_rasterizer.h"
#include "common/rng.h"
#include "common/statistics.h"
#include "common/symmetry_group.h"

namespace vantage {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// One image for an estimator.
struct Search {
  size_t dataset = 0;
  size_t view = 0;
  DatasetSearch kind = DatasetSearch::kSegment;
  std::vector<size_t> objects;  // Of the view, that are looked for.
};

std::vector<Search> SearchesOf(const Dataset& dataset, size_t index, DatasetSearch kind) {
  std::vector<Search> searches;
  for (size_t i = 0; i < dataset.views.size(); ++i) {
    const DatasetView& view = dataset.views[i];
    Search whole{index, i, kind, {}};
    for (size_t j = 0; j < view.objects.size(); ++j) {
      if (kind == DatasetSearch::kWholeImage) {
        whole.objects.push_back(j);
      } else if (view.is_segmented || !view.objects[j].pixels.empty()) {
        searches.push_back({index, i, kind, {j}});
      }
    }
    if (kind == DatasetSearch::kWholeImage && !view.is_segmented && !whole.objects.empty()) {
      searches.push_back(std::move(whole));
    }
  }
  return searches;
}

DepthImage ImageOf(const DatasetView& view, const Search& search) {
  if (search.kind == DatasetSearch::kWholeImage || view.is_segmented) return view.depth;
  DepthImage image(view.depth.width, view.depth.height);
  for (const uint32_t pixel : view.objects[search.objects.front()].pixels) {
    image.depth[pixel] = view.depth.depth[pixel];
  }
  return image;
}

// Median distance along z of what is measured of an object to its true surface, m.
double TruthOffset(const DatasetView& view, const DatasetObject& object, const TriangleMesh& mesh) {
  constexpr double kFarthest = 0.05;  // m; beyond it something else is measured.
  DepthRasterizer rasterizer(view.camera);
  rasterizer.Draw(mesh, object.T_camera_object);
  std::vector<double> offsets;
  const auto add = [&](size_t pixel) {
    const float drawn = rasterizer.depth()[pixel];
    if (drawn == DepthRasterizer::kEmpty) return;
    const auto offset = static_cast<double>(std::abs(view.depth.depth[pixel] - drawn));
    if (offset < kFarthest) offsets.push_back(offset);
  };
  if (object.pixels.empty()) {
    for (size_t i = 0; i < view.depth.depth.size(); ++i) add(i);
  }
  for (const uint32_t pixel : object.pixels) add(pixel);
  return Median(offsets);
}

bool IsRight(const Dataset& dataset,
             const DatasetView& view,
             const Detection& detection,
             const PoseSuccessParameters& bounds) {
  return std::any_of(view.objects.begin(), view.objects.end(), [&](const DatasetObject& object) {
    const ObjectModel& model = dataset.models[object.model];
    return model.id == detection.model_id && JudgePose(model,
                                                       object.T_camera_object,
                                                       detection.T_camera_object,
                                                       view.depth,
                                                       view.camera,
                                                       bounds)
                                                 .succeeded();
  });
}

void Compare(const ObjectModel& model,
             const DatasetView& view,
             const DatasetObject& object,
             const Detection& detection,
             const PoseSuccessParameters& bounds,
             DatasetOutcome* outcome) {
  const Pose& T = detection.T_camera_object;
  outcome->is_found = true;
  outcome->T_camera_object = T;
  outcome->success = JudgePose(model, object.T_camera_object, T, view.depth, view.camera, bounds);
  outcome->score = detection.verification_score;
  if (!object.T_camera_object_other) return;
  const Pose& T_other = *object.T_camera_object_other;
  outcome->angle_other = SymmetricAngle(
      model.symmetry, Eigen::Quaterniond(T_other.linear()), Eigen::Quaterniond(T.linear()));
  outcome->distance_other = (T_other * model.center - T * model.center).norm();
}

// The best detection of a model; of equal ones the first.
const Detection* BestOf(const std::vector<Detection>& detections, const std::string& model_id) {
  const Detection* best = nullptr;
  for (const Detection& detection : detections) {
    if (detection.model_id != model_id) continue;
    if (best == nullptr || detection.verification_score > best->verification_score) {
      best = &detection;
    }
  }
  return best;
}

void Judge(const Search& search,
           const std::string& estimator,
           const DatasetEstimate& estimate,
           DatasetResults* results) {
  const Dataset& dataset = results->datasets[search.dataset];
  const DatasetView& view = dataset.views[search.view];
  const auto num_wrong = std::count_if(
      estimate.detections.begin(), estimate.detections.end(), [&](const Detection& detection) {
        return !IsRight(dataset, view, detection, results->bounds);
      });
  for (const size_t index : search.objects) {
    const DatasetObject& object = view.objects[index];
    const ObjectModel& model = dataset.models[object.model];
    DatasetOutcome outcome;
    outcome.dataset = search.dataset;
    outcome.view = search.view;
    outcome.object = index;
    outcome.estimator = estimator;
    outcome.search = search.kind;
    outcome.success.angle = kNone;
    outcome.success.distance = kNone;
    outcome.angle_other = kNone;
    outcome.distance_other = kNone;
    if (const Detection* best = BestOf(estimate.detections, model.id)) {
      Compare(model, view, object, *best, results->bounds, &outcome);
    }
    outcome.truth_offset = TruthOffset(view, object, model.mesh);
    outcome.num_clusters = estimate.num_clusters;
    outcome.num_wrong = static_cast<int>(num_wrong);
    outcome.seconds = estimate.seconds;
    outcome.stages = estimate.stages;
    results->outcomes.push_back(std::move(outcome));
  }
}

// All searches of one kind in one dataset by one estimator.
struct Batch {
  std::string estimator;
  size_t dataset = 0;
  DatasetSearch kind = DatasetSearch::kSegment;
  std::vector<Search> searches;
};

std::vector<Batch> BatchesOf(const std::vector<Dataset>& datasets,
                             const std::vector<std::string>& estimators) {
  std::vector<Batch> batches;
  for (size_t d = 0; d < datasets.size(); ++d) {
    for (const std::string& estimator : estimators) {
      for (const DatasetSearch kind : {DatasetSearch::kWholeImage, DatasetSearch::kSegment}) {
        std::vector<Search> searches = SearchesOf(datasets[d], d, kind);
        if (!searches.empty()) batches.push_back({estimator, d, kind, std::move(searches)});
      }
    }
  }
  return batches;
}

// One for the whole image; one a model for segments, which are searched for theirs alone.
Result<std::vector<DatasetEstimator>> MakeAll(const Batch& batch,
                                              const EstimatorMaker& make,
                                              const Dataset& dataset) {
  using Support = SegmentationParameters::Support;
  std::vector<std::vector<ObjectModel>> sets;
  Support support = Support::kAuto;
  if (batch.kind == DatasetSearch::kWholeImage) {
    sets.push_back(dataset.models);
  } else {
    support = Support::kNone;
    for (const ObjectModel& model : dataset.models) sets.push_back({model});
  }
  std::vector<DatasetEstimator> made;
  for (std::vector<ObjectModel>& set : sets) {
    Result<DatasetEstimator> one = make(batch.estimator, std::move(set), support);
    if (!one) return one.error();
    made.push_back(std::move(one).value());
  }
  return made;
}

// False after a stop.
Result<bool> RunBatch(const Batch& batch,
                      const EstimatorMaker& make,
                      const std::stop_token& stop,
                      const std::function<void()>& step,
                      DatasetResults* results) {
  const auto made = MakeAll(batch, make, results->datasets[batch.dataset]);
  if (!made) return made.error();
  for (size_t i = 0; i < batch.searches.size(); ++i) {
    if (stop.stop_requested()) return false;
    const Search& search = batch.searches[i];
    const DatasetView& view = results->datasets[batch.dataset].views[search.view];
    const size_t model =
        batch.kind == DatasetSearch::kWholeImage ? 0 : view.objects[search.objects.front()].model;
    Rng rng(results->seed, i);
    Judge(
        search, batch.estimator, (*made)[model](ImageOf(view, search), view.camera, rng), results);
    step();
  }
  return true;
}

}  // namespace

Result<bool> RunDatasets(const std::vector<std::string>& estimators,
                         const EstimatorMaker& make,
                         const std::stop_token& stop,
                         const DatasetProgress& progress,
                         DatasetResults* results) {
  const std::vector<Batch> batches = BatchesOf(results->datasets, estimators);
  int64_t total = 0;
  int64_t done = 0;
  for (const Batch& batch : batches) total += static_cast<int64_t>(batch.searches.size());
  for (const Batch& batch : batches) {
    const Result<bool> is_complete = RunBatch(
        batch, make, stop, [&] { progress(++done, total); }, results);
    if (!is_complete || !*is_complete) return is_complete;
  }
  return true;
}

}  // namespace vantage
