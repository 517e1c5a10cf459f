#include "perception/ppf/ppf_estimator.h"

#include <algorithm>

#include "common/format.h"

namespace vantage {
namespace {

// Adds the seconds of its life to a stage.
class StageTimer {
 public:
  StageTimer(StageTimes* times, double StageTimes::*stage)
      : times_(times != nullptr && times->clock ? times : nullptr), stage_(stage) {
    if (times_ != nullptr) start_ = times_->clock();
  }
  ~StageTimer() {
    if (times_ != nullptr) times_->*stage_ += times_->clock() - start_;
  }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  StageTimes* times_;
  double StageTimes::*stage_;
  double start_ = 0.0;
};

constexpr double kGridReach = 0.16;  // Of the diameter; beyond the coarse refinement's pairs.
constexpr double kGridCell = 0.02;   // Of the diameter.
constexpr size_t kGridPoints = 4000;
constexpr uint64_t kGridSeed = 1;

NearestGrid MakeGrid(const ObjectModel& model) {
  Rng rng(kGridSeed);
  return NearestGrid(SampleSurface(model.mesh, kGridPoints, rng),
                     kGridReach * model.diameter,
                     kGridCell * model.diameter);
}

double RadiusAboutCenter(const ObjectModel& model) {
  double radius = 0.0;
  for (const Eigen::Vector3f& vertex : model.mesh.vertices) {
    radius = std::max(radius, (vertex.cast<double>() - model.center).norm());
  }
  return radius;
}

// Keeps a random subset, in its order.
void Thin(size_t size, Rng& rng, std::vector<SurfacePoint>* points) {
  if (points->size() <= size) return;
  for (size_t i = 0; i < size; ++i) {
    std::swap((*points)[i], (*points)[i + rng.Below(static_cast<uint32_t>(points->size() - i))]);
  }
  points->resize(size);
}

}  // namespace

Result<void> PpfEstimatorParameters::Validate() const {
  for (const Result<void>& valid : {table.Validate(),
                                    segmentation.Validate(),
                                    normals.Validate(),
                                    voting.Validate(),
                                    verification.Validate(),
                                    refinement.Validate()}) {
    if (!valid) return valid;
  }
  if (coarse_hypotheses < 1 || fine_hypotheses < 1 || max_scene_points < 10 ||
      hypotheses_per_cluster < 1) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("coarse_hypotheses = %d, fine_hypotheses = %d, hypotheses_per_cluster = %d "
                        "(expected 1 or more), max_scene_points = %d (expected 10 or more)",
                        coarse_hypotheses,
                        fine_hypotheses,
                        hypotheses_per_cluster,
                        max_scene_points)};
  }
  return {};
}

Result<std::unique_ptr<PpfEstimator>> PpfEstimator::Create(
    std::vector<ObjectModel> models, const PpfEstimatorParameters& parameters) {
  std::vector<Model> trained;
  for (ObjectModel& model : models) {
    Result<PpfTable> table = PpfTable::Train(model.samples, model.diameter, parameters.table);
    if (!table) {
      return Error{table.error().code, "model \"" + model.id + "\": " + table.error().message};
    }
    trained.push_back({std::move(model), std::move(table).value()});
  }
  return Create(std::move(trained), parameters);
}

Result<std::unique_ptr<PpfEstimator>> PpfEstimator::Create(
    std::vector<Model> models, const PpfEstimatorParameters& parameters) {
  if (Result<void> valid = parameters.Validate(); !valid) return valid.error();
  return std::unique_ptr<PpfEstimator>(new PpfEstimator(std::move(models), parameters));
}

PpfEstimator::PpfEstimator(std::vector<Model> models, const PpfEstimatorParameters& parameters)
    : parameters_(parameters), models_(std::move(models)) {
  for (const Model& model : models_) {
    grids_.push_back(MakeGrid(model.object));
    radii_.push_back(RadiusAboutCenter(model.object));
  }
}

ModelShape PpfEstimator::Shape(size_t model) const {
  const ObjectModel& object = models_[model].object;
  return {object.mesh, object.center, object.diameter, radii_[model]};
}

// The best hypotheses of one model for one cluster, refined on samples.
std::vector<PpfEstimator::Hypothesis> PpfEstimator::Propose(
    const SegmentedImage& image, size_t cluster, size_t model, Rng& rng, StageTimes* times) {
  const Model& known = models_[model];
  const ModelShape shape = Shape(model);
  std::vector<SurfacePoint> scene;
  {
    const StageTimer timer(times, &StageTimes::normals);
    scene = SampleSurfaces(image.depth,
                           image.camera,
                           image.segmentation.labels,
                           image.segmentation.clusters[cluster].pixels,
                           parameters_.table.sample_distance * shape.diameter,
                           parameters_.normals);
    Thin(static_cast<size_t>(parameters_.max_scene_points), rng, &scene);
  }
  constexpr size_t kFewestPoints = 5;
  if (scene.size() < kFewestPoints) return {};
  std::vector<PoseHypothesis> voted;
  {
    const StageTimer timer(times, &StageTimes::voting);
    voted = VotePoses(known.table, scene, shape.center, parameters_.voting, rng);
  }
  std::vector<Hypothesis> hypotheses;
  for (const PoseHypothesis& pose : voted) hypotheses.push_back({model, pose.T_camera_object, {}});
  const auto verify_and_keep = [&](int keep) {
    const StageTimer timer(times, &StageTimes::verification);
    for (Hypothesis& hypothesis : hypotheses) {
      hypothesis.verification = Verify(shape,
                                       hypothesis.T_camera_object,
                                       image,
                                       cluster,
                                       parameters_.verification.coarse_step,
                                       parameters_.verification,
                                       &view_);
    }
    std::stable_sort(hypotheses.begin(), hypotheses.end(), [](const auto& a, const auto& b) {
      return a.verification.cost < b.verification.cost;
    });
    if (hypotheses.size() > static_cast<size_t>(keep)) {
      hypotheses.resize(static_cast<size_t>(keep));
    }
  };
  {
    const StageTimer timer(times, &StageTimes::refinement);
    for (Hypothesis& hypothesis : hypotheses) {
      hypothesis.T_camera_object = RefineCoarse(grids_[model],
                                                shape,
                                                hypothesis.T_camera_object,
                                                scene,
                                                image.camera.fx,
                                                parameters_.refinement)
                                       .T_camera_object;
    }
  }
  verify_and_keep(parameters_.coarse_hypotheses);
  return hypotheses;
}

// The accepted hypotheses of all models for one cluster, best first.
std::vector<PpfEstimator::Hypothesis> PpfEstimator::Explain(const SegmentedImage& image,
                                                            size_t cluster,
                                                            Rng& rng,
                                                            StageTimes* times) {
  std::vector<Hypothesis> all;
  for (size_t model = 0; model < models_.size(); ++model) {
    const std::vector<Hypothesis> proposed = Propose(image, cluster, model, rng, times);
    all.insert(all.end(), proposed.begin(), proposed.end());
  }
  const auto by_cost = [](const Hypothesis& a, const Hypothesis& b) {
    return a.verification.cost < b.verification.cost;
  };
  std::stable_sort(all.begin(), all.end(), by_cost);
  if (all.size() > static_cast<size_t>(parameters_.fine_hypotheses)) {
    all.resize(static_cast<size_t>(parameters_.fine_hypotheses));
  }
  for (Hypothesis& hypothesis : all) {
    const ModelShape shape = Shape(hypothesis.model);
    {
      const StageTimer timer(times, &StageTimes::refinement);
      hypothesis.T_camera_object =
          RefineFine(shape, hypothesis.T_camera_object, image, parameters_.refinement, &view_)
              .T_camera_object;
    }
    const StageTimer timer(times, &StageTimes::verification);
    hypothesis.verification = Verify(
        shape, hypothesis.T_camera_object, image, cluster, 1, parameters_.verification, &view_);
  }
  std::stable_sort(all.begin(), all.end(), by_cost);
  std::erase_if(all, [this](const Hypothesis& hypothesis) {
    return hypothesis.verification.inliers == 0 ||
           hypothesis.verification.score() < parameters_.verification.min_score;
  });
  return all;
}

PpfEstimator::Output PpfEstimator::Estimate(const DepthImage& depth,
                                            const CameraModel& camera,
                                            Rng& rng,
                                            StageTimes* times) {
  Segmentation segmentation;
  {
    const StageTimer timer(times, &StageTimes::segmentation);
    segmentation = Segment(depth, camera, parameters_.segmentation, rng);
  }
  const SegmentedImage image{depth, camera, segmentation};
  Output output;
  output.num_clusters = static_cast<int>(segmentation.clusters.size());
  for (size_t cluster = 0; cluster < segmentation.clusters.size(); ++cluster) {
    const std::vector<Hypothesis> explained = Explain(image, cluster, rng, times);
    for (size_t i = 0; i < explained.size(); ++i) {
      if (i == static_cast<size_t>(parameters_.hypotheses_per_cluster)) break;
      const Hypothesis& hypothesis = explained[i];
      output.detections.push_back({models_[hypothesis.model].object.id,
                                   static_cast<int>(cluster),
                                   hypothesis.T_camera_object,
                                   hypothesis.verification.mse,
                                   hypothesis.verification.inlier_fraction(),
                                   hypothesis.verification.score()});
    }
  }
  return output;
}

}  // namespace vantage
