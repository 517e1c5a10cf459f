#include "tools/support/stage_trace.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "perception/ppf/ppf_proposer.h"
#include "perception/refinement/refinement.h"
#include "perception/segmentation/surface_sampler.h"

namespace vantage {
namespace {

// One call of a proposer.
struct Proposed {
  size_t model = 0;
  std::vector<SurfacePoint> scene;
  std::vector<Pose> poses;
};

// Writes down what an estimator has its proposer do.
class RecordingProposer : public PoseProposer {
 public:
  RecordingProposer(std::unique_ptr<PoseProposer> proposer, std::vector<Proposed>* calls)
      : proposer_(std::move(proposer)), calls_(calls) {}

  [[nodiscard]] double Spacing(size_t model) const override { return proposer_->Spacing(model); }
  std::span<const PoseHypothesis> Propose(size_t model,
                                          std::span<const SurfacePoint> scene,
                                          Rng& rng) override {
    Proposed& call = calls_->emplace_back();
    call.model = model;
    call.scene.assign(scene.begin(), scene.end());
    const std::span<const PoseHypothesis> found = proposer_->Propose(model, scene, rng);
    for (const PoseHypothesis& pose : found) call.poses.push_back(pose.T_camera_object);
    return found;
  }
  // The copy writes nothing down.
  [[nodiscard]] std::unique_ptr<PoseProposer> Clone() const override { return proposer_->Clone(); }

 private:
  std::unique_ptr<PoseProposer> proposer_;
  std::vector<Proposed>* calls_;
};

// The smallest segment that holds all points, each of which lies on its pixel's line of sight.
std::optional<size_t> ClusterOf(const Segmentation& segmentation,
                                const CameraModel& camera,
                                std::span<const SurfacePoint> points) {
  std::optional<size_t> smallest;
  for (size_t i = 0; i < segmentation.clusters.size(); ++i) {
    const Cluster& cluster = segmentation.clusters[i];
    const bool holds_all = std::ranges::all_of(points, [&](const SurfacePoint& point) {
      const Eigen::Vector2d pixel = camera.Project(point.position.cast<double>());
      const int64_t u = std::clamp<int64_t>(std::lround(pixel.x()), 0, camera.width - 1);
      const int64_t v = std::clamp<int64_t>(std::lround(pixel.y()), 0, camera.height - 1);
      return cluster.Holds(segmentation.labels[static_cast<size_t>(v * camera.width + u)]);
    });
    if (!holds_all) continue;
    if (!smallest || cluster.pixels.size() < segmentation.clusters[*smallest].pixels.size()) {
      smallest = i;
    }
  }
  return smallest;
}

struct Hypothesis {
  Pose T_camera_object = Pose::Identity();
  Verification verification;
};

// Refines and verifies what was proposed, as the estimator's last stages do.
class LastStages {
 public:
  LastStages(const StageTrace& trace,
             const StageImage& image,
             const PoseEstimatorParameters& parameters)
      : trace_(trace),
        image_{image.depth, image.camera, trace.segmentation},
        parameters_(parameters) {
    observed_.Reset(image_, parameters.verification.edge_px);
  }

  // Fills in the rest of a model's trace in a cluster.
  void Follow(size_t cluster, ModelTrace* model) {
    const KnownModel& known = trace_.models[model->model];
    std::vector<Hypothesis> hypotheses = RefineOnPoints(cluster, *model);
    if (!hypotheses.empty()) {
      model->coarse_score = hypotheses.front().verification.score();
      model->outcome = ModelTrace::Outcome::kLowScore;
    }
    const auto detection = std::ranges::find_if(trace_.detections, [&](const Detection& found) {
      return found.cluster == static_cast<int>(cluster) && found.model_id == known.object.id;
    });
    if (detection != trace_.detections.end()) {
      model->outcome = ModelTrace::Outcome::kAccepted;
      model->T_best = detection->T_camera_object;
      model->verification = VerifyAt(cluster, known.Shape(), detection->T_camera_object, 1);
      return;
    }
    if (hypotheses.empty()) return;
    RefineOnPixels(cluster, known, &hypotheses);
    model->T_best = hypotheses.front().T_camera_object;
    model->verification = hypotheses.front().verification;
    if (model->verification.score() < parameters_.verification.min_score) return;
    model->outcome = model->verification.visible_fraction() < parameters_.verification.min_visible
                         ? ModelTrace::Outcome::kHidden
                         : ModelTrace::Outcome::kOtherBetter;
  }

 private:
  Verification VerifyAt(size_t cluster, const ModelShape& shape, const Pose& T, int step) {
    return Verify(shape, T, &observed_, cluster, step, parameters_.verification, &view_);
  }

  static void SortByCost(std::vector<Hypothesis>* hypotheses) {
    std::ranges::stable_sort(
        *hypotheses, {}, [](const Hypothesis& hypothesis) { return hypothesis.verification.cost; });
  }

  // Also poses in which the model looks like in the best one. By cost.
  std::vector<Hypothesis> RefineOnPoints(size_t cluster, const ModelTrace& model) {
    const KnownModel& known = trace_.models[model.model];
    const int step = parameters_.verification.coarse_step;
    ScenePoints points;
    points.Assign(model.points, image_.camera.fx, parameters_.refinement.noise);
    std::vector<Hypothesis> hypotheses;
    const auto add = [&](const Pose& T) {
      hypotheses.push_back({T, VerifyAt(cluster, known.CoarseShape(), T, step)});
    };
    for (const Pose& T : model.proposals) {
      add(RefineCoarse(known.grid, known.CoarseShape(), T, points, parameters_.refinement)
              .T_camera_object);
    }
    SortByCost(&hypotheses);
    if (hypotheses.empty()) return hypotheses;
    const Pose T_best = hypotheses.front().T_camera_object;
    for (const Pose& alternative : known.alternatives) add(T_best * alternative);
    SortByCost(&hypotheses);
    return hypotheses;
  }

  // The first few. By cost.
  void RefineOnPixels(size_t cluster,
                      const KnownModel& known,
                      std::vector<Hypothesis>* hypotheses) {
    const auto count = static_cast<size_t>(parameters_.coarse_hypotheses);
    if (hypotheses->size() > count) hypotheses->resize(count);
    for (Hypothesis& hypothesis : *hypotheses) {
      hypothesis.T_camera_object = refiner_
                                       .Refine(known.CoarseShape(),
                                               known.Shape(),
                                               hypothesis.T_camera_object,
                                               image_,
                                               parameters_.refinement,
                                               &view_)
                                       .T_camera_object;
      hypothesis.verification = VerifyAt(cluster, known.Shape(), hypothesis.T_camera_object, 1);
    }
    SortByCost(hypotheses);
  }

  const StageTrace& trace_;
  SegmentedImage image_;
  PoseEstimatorParameters parameters_;
  ObservedImage observed_;
  ModelView view_;
  Refiner refiner_;
};

}  // namespace

Result<StageTrace> TraceStages(std::vector<PpfModel> models,
                               const PpfEstimatorParameters& parameters,
                               const StageImage& image,
                               uint64_t seed) {
  if (Result<void> valid = parameters.Validate(); !valid) return valid.error();
  StageTrace trace;
  std::vector<PpfProposer::Model> voted;
  for (PpfModel& model : models) {
    Result<KnownModel> known = MakeKnownModel(std::move(model.object), model.table);
    if (!known) return known.error();
    voted.push_back({std::move(model.table), known->object.center, known->object.symmetry});
    trace.models.push_back(std::move(known).value());
  }
  std::vector<Proposed> calls;
  auto proposer = std::make_unique<RecordingProposer>(
      std::make_unique<PpfProposer>(std::move(voted), parameters.voting), &calls);
  double spacing = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < trace.models.size(); ++i) {
    spacing = std::min(spacing, proposer->Spacing(i));
  }
  Result<std::unique_ptr<PoseEstimator>> estimator =
      PoseEstimator::Create(trace.models, std::move(proposer), parameters.estimation);
  if (!estimator) return estimator.error();
  // Of the image alone, as in vantage-ppf; segmentation is what draws from it first.
  const auto stream = static_cast<uint64_t>(image.utime);
  Rng rng(seed, stream);
  trace.detections = (*estimator)->Estimate(image.depth, image.camera, rng).detections;
  Rng rng_segmentation(seed, stream);
  trace.segmentation =
      Segment(image.depth, image.camera, parameters.estimation.segmentation, rng_segmentation);

  SurfaceSampler sampler(parameters.estimation.normals);
  for (const Cluster& cluster : trace.segmentation.clusters) {
    trace.clusters.emplace_back().num_points =
        sampler.Sample(image.depth, image.camera, trace.segmentation.labels, cluster, spacing)
            .size();
  }
  LastStages last(trace, image, parameters.estimation);
  for (Proposed& call : calls) {
    const std::optional<size_t> cluster = ClusterOf(trace.segmentation, image.camera, call.scene);
    if (!cluster) continue;
    ModelTrace model;
    model.model = call.model;
    model.points = std::move(call.scene);
    model.proposals = std::move(call.poses);
    last.Follow(*cluster, &model);
    trace.clusters[*cluster].models.push_back(std::move(model));
  }
  return trace;
}

const ModelTrace* BestModel(const ClusterTrace& cluster) {
  const ModelTrace* best = nullptr;
  const auto rank = [](const ModelTrace& model) {
    return (model.outcome == ModelTrace::Outcome::kAccepted ? 1.0 : 0.0) +
           model.verification.score();
  };
  for (const ModelTrace& model : cluster.models) {
    if (model.outcome == ModelTrace::Outcome::kNoProposals) continue;
    if (best == nullptr || rank(model) > rank(*best)) best = &model;
  }
  return best;
}

}  // namespace vantage
