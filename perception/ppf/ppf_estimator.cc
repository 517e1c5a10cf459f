#include "perception/ppf/ppf_estimator.h"

#include <algorithm>

#include "common/format.h"
#include "perception/ppf/self_alignment.h"
#include "perception/verification/mesh_simplification.h"

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
constexpr uint64_t kSelfSeed = 2;
constexpr size_t kManyTriangles = 8000;
constexpr double kQuickCell = 0.02;  // Of the diameter.

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

template <class T>
void Truncate(int size, std::vector<T>* values) {
  if (values->size() > static_cast<size_t>(size)) values->resize(static_cast<size_t>(size));
}

template <class Hypothesis>
bool ByCost(const Hypothesis& a, const Hypothesis& b) {
  return a.verification.cost < b.verification.cost;
}

// Of sorted hypotheses of one model the first `count` that differ.
template <class Hypothesis>
void KeepDistinct(const ObjectModel& model, int count, std::vector<Hypothesis>* hypotheses) {
  constexpr double kSameAngle = 4.0 * kDegree;
  constexpr double kSamePlace = 0.03;  // Of the diameter.
  std::vector<Hypothesis> kept;
  for (const Hypothesis& hypothesis : *hypotheses) {
    const Pose& T = hypothesis.T_camera_object;
    const bool is_known = std::any_of(kept.begin(), kept.end(), [&](const Hypothesis& other) {
      const Pose& T_other = other.T_camera_object;
      return (T * model.center - T_other * model.center).norm() < kSamePlace * model.diameter &&
             SymmetricAngle(model.symmetry,
                            Eigen::Quaterniond(T.linear()),
                            Eigen::Quaterniond(T_other.linear())) < kSameAngle;
    });
    if (!is_known) kept.push_back(hypothesis);
    if (kept.size() == static_cast<size_t>(count)) break;
  }
  *hypotheses = std::move(kept);
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
    : parameters_(parameters) {
  for (Model& model : models) models_.push_back(Prepare(std::move(model)));
}

PpfEstimator::Prepared PpfEstimator::Prepare(Model model) {
  const ObjectModel& object = model.object;
  TriangleMesh quick = object.mesh;
  if (quick.triangles.size() > kManyTriangles) {
    quick = SimplifyMesh(object.mesh, kQuickCell * object.diameter);
  }
  DrawableMesh mesh(object.mesh);
  const double radius = RadiusAboutCenter(object);
  NearestGrid grid = MakeGrid(object);
  Rng rng(kSelfSeed);
  std::vector<Pose> alternatives =
      FindSelfAlignments(model.table,
                         grid,
                         ModelShape{mesh, object.center, object.diameter, radius},
                         object.symmetry,
                         rng);
  return {std::move(model),
          std::move(grid),
          std::move(mesh),
          DrawableMesh(std::move(quick)),
          radius,
          std::move(alternatives)};
}

ModelShape PpfEstimator::Shape(const Prepared& prepared, const DrawableMesh& mesh) {
  const ObjectModel& object = prepared.model.object;
  return {mesh, object.center, object.diameter, prepared.radius};
}

void PpfEstimator::VerifyAndSort(const SegmentedImage& image,
                                 size_t cluster,
                                 int step,
                                 StageTimes* times,
                                 std::vector<Hypothesis>* hypotheses) {
  const StageTimer timer(times, &StageTimes::verification);
  for (Hypothesis& hypothesis : *hypotheses) {
    const Prepared& known = models_[hypothesis.model];
    const DrawableMesh& mesh = hypothesis.is_final ? known.mesh : known.quick_mesh;
    hypothesis.verification = Verify(Shape(known, mesh),
                                     hypothesis.T_camera_object,
                                     image,
                                     cluster,
                                     step,
                                     parameters_.verification,
                                     &view_);
  }
  std::stable_sort(hypotheses->begin(), hypotheses->end(), ByCost<Hypothesis>);
}

// The best hypotheses of one model for one cluster, refined on samples.
std::vector<PpfEstimator::Hypothesis> PpfEstimator::Propose(
    const SegmentedImage& image, size_t cluster, size_t model, Rng& rng, StageTimes* times) {
  const Prepared& known = models_[model];
  const ModelShape shape = Shape(known, known.quick_mesh);
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
    voted = VotePoses(known.model.table, scene, shape.center, parameters_.voting, rng);
  }
  std::vector<Hypothesis> hypotheses;
  for (const PoseHypothesis& pose : voted) {
    hypotheses.push_back({model, false, pose.T_camera_object, {}});
  }
  const auto refine = [&](Hypothesis& hypothesis) {
    const StageTimer timer(times, &StageTimes::refinement);
    hypothesis.T_camera_object = RefineCoarse(known.grid,
                                              shape,
                                              hypothesis.T_camera_object,
                                              scene,
                                              image.camera.fx,
                                              parameters_.refinement)
                                     .T_camera_object;
  };
  for (Hypothesis& hypothesis : hypotheses) refine(hypothesis);
  VerifyAndSort(image, cluster, parameters_.verification.coarse_step, times, &hypotheses);
  // A pose that explains little has no use for others like it.
  constexpr double kPromising = 0.3;
  if (!hypotheses.empty() && hypotheses.front().verification.score() > kPromising) {
    std::vector<Hypothesis> others;
    for (const Pose& alternative : known.alternatives) {
      others.push_back({model, false, hypotheses.front().T_camera_object * alternative, {}});
    }
    VerifyAndSort(image, cluster, parameters_.verification.coarse_step, times, &others);
    hypotheses.insert(hypotheses.end(), others.begin(), others.end());
    std::stable_sort(hypotheses.begin(), hypotheses.end(), ByCost<Hypothesis>);
  }
  KeepDistinct(known.model.object, parameters_.coarse_hypotheses, &hypotheses);
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
  std::stable_sort(all.begin(), all.end(), ByCost<Hypothesis>);
  Truncate(parameters_.fine_hypotheses, &all);
  const RefinementParameters& refinement = parameters_.refinement;
  constexpr int kFineStep = 2;
  for (Hypothesis& hypothesis : all) {
    const StageTimer timer(times, &StageTimes::refinement);
    const Prepared& known = models_[hypothesis.model];
    hypothesis.T_camera_object = RefineFine(Shape(known, known.quick_mesh),
                                            hypothesis.T_camera_object,
                                            image,
                                            kFineStep,
                                            refinement.fine_iterations,
                                            refinement.fine_reach * known.model.object.diameter,
                                            refinement,
                                            &view_)
                                     .T_camera_object;
  }
  VerifyAndSort(image, cluster, kFineStep, times, &all);
  Truncate(parameters_.hypotheses_per_cluster + 1, &all);
  for (Hypothesis& hypothesis : all) {
    const StageTimer timer(times, &StageTimes::refinement);
    const Prepared& known = models_[hypothesis.model];
    hypothesis.is_final = true;
    hypothesis.T_camera_object = RefineFine(Shape(known, known.mesh),
                                            hypothesis.T_camera_object,
                                            image,
                                            1,
                                            refinement.final_iterations,
                                            0.0,
                                            refinement,
                                            &view_)
                                     .T_camera_object;
  }
  VerifyAndSort(image, cluster, 1, times, &all);
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
  // An object that hides part of itself may be in several clusters: one explains them all.
  std::vector<uint8_t> explained(depth.depth.size(), 0);
  constexpr double kExplainedShare = 0.5;
  for (size_t cluster = 0; cluster < segmentation.clusters.size(); ++cluster) {
    const std::vector<uint32_t>& pixels = segmentation.clusters[cluster].pixels;
    const auto count = std::count_if(
        pixels.begin(), pixels.end(), [&](uint32_t pixel) { return explained[pixel] != 0; });
    if (static_cast<double>(count) > kExplainedShare * static_cast<double>(pixels.size())) continue;
    std::vector<Hypothesis> hypotheses = Explain(image, cluster, rng, times);
    Truncate(parameters_.hypotheses_per_cluster, &hypotheses);
    for (const Hypothesis& hypothesis : hypotheses) {
      output.detections.push_back({models_[hypothesis.model].model.object.id,
                                   static_cast<int>(cluster),
                                   segmentation.clusters[cluster].touches_border,
                                   hypothesis.T_camera_object,
                                   {},
                                   hypothesis.verification.mse,
                                   hypothesis.verification.inlier_fraction(),
                                   hypothesis.verification.score()});
    }
    if (hypotheses.empty()) continue;
    const Prepared& best = models_[hypotheses.front().model];
    MarkExplained(Shape(best, best.mesh),
                  hypotheses.front().T_camera_object,
                  image,
                  parameters_.verification,
                  &view_,
                  &explained);
  }
  return output;
}

}  // namespace vantage
