#include "perception/estimator/pose_estimator.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "common/format.h"

namespace vantage {
namespace {

constexpr int kFineStep = 2;                  // px
constexpr size_t kManyPixels = 2000;          // Of a cluster of more, every kFineStep-th will do.
constexpr double kSameAngle = 4.0 * kDegree;  // Between poses that count as one.
constexpr double kNearAngle = 1.5 * kDegree;  // Between poses of which one is enough to go on with.
// Of the cost of a cluster of which nothing is explained: what is worse than the best by more is
// given up; what is worse by less may yet become better.
constexpr double kHopeless = 0.2;   // At first.
constexpr double kUnlikely = 0.04;  // After the refinement on points.
constexpr double kRival = 0.002;    // After that on few pixels.

// Keeps a random subset, in its order.
void ThinAtRandom(size_t size, Rng& rng, std::vector<SurfacePoint>* points) {
  if (points->size() <= size) return;
  for (size_t i = 0; i < size; ++i) {
    std::swap((*points)[i], (*points)[i + rng.Below(static_cast<uint32_t>(points->size() - i))]);
  }
  points->resize(size);
}

template <class Values>
void Truncate(int size, Values* values) {
  if (values->size() > static_cast<size_t>(size)) values->resize(static_cast<size_t>(size));
}

// Of sorted hypotheses those whose cost is more than `margin` above the best one's go.
template <class Hypotheses>
void DropWorse(double margin, Hypotheses* hypotheses) {
  while (hypotheses->size() > 1 &&
         hypotheses->back().verification.cost > hypotheses->front().verification.cost + margin) {
    hypotheses->pop_back();
  }
}

// By cost. A stable sort would allocate; these are few.
template <class Hypotheses>
void SortByCost(Hypotheses* hypotheses) {
  for (auto last = hypotheses->begin(); last != hypotheses->end(); ++last) {
    const auto place =
        std::upper_bound(hypotheses->begin(), last, *last, [](const auto& a, const auto& b) {
          return a.verification.cost < b.verification.cost;
        });
    std::rotate(place, last, last + 1);
  }
}

}  // namespace

Result<void> PoseEstimatorParameters::Validate() const {
  for (const Result<void>& valid : {segmentation.Validate(),
                                    normals.Validate(),
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

Result<std::unique_ptr<PoseEstimator>> PoseEstimator::Create(
    std::vector<KnownModel> models,
    std::unique_ptr<PoseProposer> proposer,
    const PoseEstimatorParameters& parameters) {
  if (Result<void> valid = parameters.Validate(); !valid) return valid.error();
  return std::unique_ptr<PoseEstimator>(
      new PoseEstimator(std::move(models), std::move(proposer), parameters));
}

PoseEstimator::PoseEstimator(std::vector<KnownModel> models,
                             std::unique_ptr<PoseProposer> proposer,
                             const PoseEstimatorParameters& parameters)
    : models_(std::move(models)),
      proposer_(std::move(proposer)),
      parameters_(parameters),
      finest_spacing_(std::numeric_limits<double>::infinity()),
      segmenter_(parameters.segmentation),
      sampler_(parameters.normals) {
  for (size_t model = 0; model < models_.size(); ++model) {
    finest_spacing_ = std::min(finest_spacing_, proposer_->Spacing(model));
  }
}

std::unique_ptr<PoseEstimator> PoseEstimator::Clone() const {
  return std::unique_ptr<PoseEstimator>(
      new PoseEstimator(models_, proposer_->Clone(), parameters_));
}

// Those from the `first` on are verified, all are sorted.
void PoseEstimator::Verify(
    size_t cluster, Effort effort, size_t first, StageTimes* times, Hypotheses* hypotheses) {
  const StageTimer timer(times, &StageTimes::verification);
  const int step = Step(effort, cluster);
  double best = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < hypotheses->size(); ++i) {
    Hypothesis& hypothesis = (*hypotheses)[i];
    if (i >= first) {
      const KnownModel& known = models_[hypothesis.model];
      hypothesis.verification =
          vantage::Verify(effort == Effort::kCoarse ? known.CoarseShape() : known.Shape(),
                          hypothesis.T_camera_object,
                          &image_,
                          cluster,
                          step,
                          parameters_.verification,
                          &view_,
                          best + kHopeless * PixelCost(cluster, step));
    }
    best = std::min(best, hypothesis.verification.cost);
  }
  SortByCost(hypotheses);
}

int PoseEstimator::Step(Effort effort, size_t cluster) const {
  if (effort == Effort::kCoarse) return parameters_.verification.coarse_step;
  const size_t size = image_.image().segmentation.clusters[cluster].pixels.size();
  return size > kManyPixels ? kFineStep : 1;
}

// Nats of a cluster of which nothing is explained.
double PoseEstimator::PixelCost(size_t cluster, int step) {
  return parameters_.verification.outlier_cost *
         static_cast<double>(image_.ClusterSize(step, cluster));
}

// The first `count` that differ: by `angle` (rad), or in place by as much as `angle` about the
// center moves the model's ends.
void PoseEstimator::KeepDistinct(size_t count, double angle, Hypotheses* hypotheses) {
  distinct_.clear();
  for (const Hypothesis& hypothesis : *hypotheses) {
    const ObjectModel& model = models_[hypothesis.model].object;
    const Pose& T = hypothesis.T_camera_object;
    const bool is_known = std::ranges::any_of(distinct_, [&](const Hypothesis& other) {
      const Pose& T_other = other.T_camera_object;
      return other.model == hypothesis.model &&
             (T * model.center - T_other * model.center).norm() < 0.5 * angle * model.diameter &&
             SymmetricAngle(model.symmetry,
                            Eigen::Quaterniond(T.linear()),
                            Eigen::Quaterniond(T_other.linear())) < angle;
    });
    if (!is_known) distinct_.push_back(hypothesis);
    if (distinct_.size() == count) break;
  }
  std::swap(distinct_, *hypotheses);
}

// The best hypotheses of one model for one cluster, refined on points, in proposed_.
void PoseEstimator::Propose(size_t cluster,
                            size_t model,
                            std::span<const SurfacePoint> points,
                            Rng& rng,
                            StageTimes* times) {
  const KnownModel& known = models_[model];
  proposed_.clear();
  {
    const StageTimer timer(times, &StageTimes::normals);
    const std::span<const SurfacePoint> thinned = sampler_.Thin(points, proposer_->Spacing(model));
    scene_.assign(thinned.begin(), thinned.end());
    ThinAtRandom(static_cast<size_t>(parameters_.max_scene_points), rng, &scene_);
  }
  constexpr size_t kFewestPoints = 5;
  if (scene_.size() < kFewestPoints) return;
  {
    const StageTimer timer(times, &StageTimes::proposal);
    for (const PoseHypothesis& pose : proposer_->Propose(model, scene_, rng)) {
      proposed_.push_back(Hypothesis{.model = model, .T_camera_object = pose.T_camera_object});
    }
  }
  {
    const StageTimer timer(times, &StageTimes::refinement);
    scene_points_.Assign(scene_, image_.image().camera.fx, parameters_.refinement.noise);
    for (Hypothesis& hypothesis : proposed_) {
      hypothesis.T_camera_object = RefineCoarse(known.grid,
                                                known.CoarseShape(),
                                                hypothesis.T_camera_object,
                                                scene_points_,
                                                parameters_.refinement)
                                       .T_camera_object;
    }
  }
  KeepDistinct(proposed_.size(), kNearAngle, &proposed_);
  Verify(cluster, Effort::kCoarse, 0, times, &proposed_);
  // A pose that explains little has no use for others like it.
  constexpr double kPromising = 0.3;
  if (!proposed_.empty() && proposed_.front().verification.score() > kPromising) {
    const Pose best = proposed_.front().T_camera_object;
    const size_t count = proposed_.size();
    for (const Pose& alternative : known.alternatives) {
      proposed_.push_back(Hypothesis{.model = model, .T_camera_object = best * alternative});
    }
    Verify(cluster, Effort::kCoarse, count, times, &proposed_);
  }
  KeepDistinct(static_cast<size_t>(parameters_.coarse_hypotheses), kSameAngle, &proposed_);
}

void PoseEstimator::Refine(Effort effort, StageTimes* times, Hypotheses* hypotheses) {
  const StageTimer timer(times, &StageTimes::refinement);
  RefinementParameters refinement = parameters_.refinement;
  if (effort == Effort::kFine) refinement.final_iterations = 0;
  if (effort == Effort::kLast) refinement.fine_iterations = 0;
  for (Hypothesis& hypothesis : *hypotheses) {
    const KnownModel& known = models_[hypothesis.model];
    const Refined refined = refiner_.Refine(known.Shape(),
                                            known.Shape(),
                                            hypothesis.T_camera_object,
                                            image_.image(),
                                            refinement,
                                            &view_);
    hypothesis.T_camera_object = refined.T_camera_object;
    hypothesis.covariance = refined.covariance;
  }
}

// Of hypotheses sorted after the coarse verification the best after refinement on pixels: of all
// that may be it on few pixels, then of the best and its rivals on all.
void PoseEstimator::Settle(size_t cluster, StageTimes* times, Hypotheses* hypotheses) {
  const auto count = static_cast<size_t>(parameters_.hypotheses_per_cluster);
  Truncate(parameters_.fine_hypotheses, hypotheses);
  DropWorse(kUnlikely * PixelCost(cluster, Step(Effort::kCoarse, cluster)), hypotheses);
  Refine(Effort::kFine, times, hypotheses);
  if (hypotheses->size() > count) {
    Verify(cluster, Effort::kFine, 0, times, hypotheses);
    KeepDistinct(count + 1, kSameAngle, hypotheses);
    DropWorse(kRival * PixelCost(cluster, Step(Effort::kFine, cluster)), hypotheses);
  }
  Refine(Effort::kLast, times, hypotheses);
  Verify(cluster, Effort::kLast, 0, times, hypotheses);
  // Of what was given up only the cost is known.
  DropWorse(kHopeless * PixelCost(cluster, Step(Effort::kLast, cluster)), hypotheses);
  KeepDistinct(count, kSameAngle, hypotheses);
}

// The accepted hypotheses of all models for one cluster, best first, in explained_.
void PoseEstimator::Explain(size_t cluster, Rng& rng, StageTimes* times) {
  explained_.clear();
  std::span<const SurfacePoint> points;
  {
    const StageTimer timer(times, &StageTimes::normals);
    points = sampler_.Sample(image_.image().depth,
                             image_.image().camera,
                             image_.image().segmentation.labels,
                             image_.image().segmentation.clusters[cluster],
                             finest_spacing_);
  }
  for (size_t model = 0; model < models_.size(); ++model) {
    Propose(cluster, model, points, rng, times);
    explained_.insert(explained_.end(), proposed_.begin(), proposed_.end());
  }
  SortByCost(&explained_);
  Settle(cluster, times, &explained_);
  std::erase_if(explained_, [this](const Hypothesis& hypothesis) {
    const Verification& verification = hypothesis.verification;
    return verification.inliers == 0 || verification.score() < parameters_.verification.min_score ||
           verification.visible_fraction() < parameters_.verification.min_visible;
  });
}

// True when what was found before is seen on most of the cluster.
bool PoseEstimator::IsExplained(const Cluster& cluster) {
  if (unmarked_) {
    MarkExplained(models_[unmarked_->model].Shape(),
                  unmarked_->T_camera_object,
                  &image_,
                  parameters_.verification,
                  &view_,
                  &is_explained_);
    unmarked_.reset();
  }
  constexpr double kShare = 0.5;
  const auto count = std::ranges::count_if(
      cluster.pixels, [&](uint32_t pixel) { return is_explained_[pixel] != 0; });
  return static_cast<double>(count) > kShare * static_cast<double>(cluster.pixels.size());
}

// Adds explained_ to the output.
void PoseEstimator::Report(size_t cluster) {
  for (const Hypothesis& hypothesis : explained_) {
    output_.detections.push_back({models_[hypothesis.model].object.id,
                                  static_cast<int>(cluster),
                                  image_.image().segmentation.clusters[cluster].touches_border,
                                  hypothesis.T_camera_object,
                                  hypothesis.covariance,
                                  hypothesis.verification.mse,
                                  hypothesis.verification.inlier_fraction(),
                                  hypothesis.verification.score()});
  }
  if (!explained_.empty()) unmarked_ = explained_.front();
}

const PoseEstimator::Output& PoseEstimator::Estimate(const DepthImage& depth,
                                                     const CameraModel& camera,
                                                     Rng& rng,
                                                     StageTimes* times) {
  const Segmentation* segmentation = nullptr;
  {
    const StageTimer timer(times, &StageTimes::segmentation);
    segmentation = &segmenter_.Segment(depth, camera, rng);
  }
  image_.Reset({depth, camera, *segmentation}, parameters_.verification.edge_px);
  output_.detections.clear();
  output_.num_clusters = 0;
  // An object that hides part of itself may be in several clusters: one explains them all.
  is_explained_.assign(depth.depth.size(), 0);
  unmarked_.reset();
  int explained_whole = -1;
  for (size_t cluster = 0; cluster < segmentation->clusters.size(); ++cluster) {
    const Cluster& segment = segmentation->clusters[cluster];
    if (segment.parent >= 0 && segment.parent == explained_whole) continue;
    if (IsExplained(segment)) continue;
    ++output_.num_clusters;
    Explain(cluster, rng, times);
    if (!explained_.empty() && segment.parent < 0) explained_whole = static_cast<int>(cluster);
    Report(cluster);
  }
  return output_;
}

}  // namespace vantage
