#include "perception/shot/shot_proposer.h"

#include <algorithm>
#include <cmath>

#include "common/symmetry_group.h"

namespace vantage {
namespace {

constexpr size_t kGridPoints = 4000;
constexpr uint64_t kGridSeed = 1;
constexpr double kGridCell = 0.02;  // Of the diameter.
// So many times max_hypotheses are ranked.
constexpr int kRankedShare = 4;
// Hypotheses nearer to each other than this are one.
constexpr double kSameAngle = 10.0 * kDegree;
constexpr double kSamePlace = 0.05;  // Of the diameter.

NearestGrid MakeGrid(const ObjectModel& object, double reach) {
  Rng rng(kGridSeed);
  return NearestGrid(
      SampleSurface(object.mesh, kGridPoints, rng), reach, kGridCell * object.diameter);
}

RansacParameters InMeters(const ShotParameters& parameters, double diameter) {
  return {parameters.t_r * diameter,
          parameters.t_d * diameter,
          parameters.t_alpha_deg * kDegree,
          parameters.inlier_distance * diameter,
          parameters.probability,
          parameters.max_iterations,
          kRankedShare * parameters.max_hypotheses};
}

bool IsUsable(const SurfacePoint& point) {
  constexpr float kFarthest = 1e3F;  // m
  return point.position.cwiseAbs().maxCoeff() < kFarthest && point.position.allFinite() &&
         std::abs(point.normal.squaredNorm() - 1.0F) < 0.1F;
}

// Of the scene's points, weighted by their distances, those on the model; in points.
double ScoreOnSurface(const NearestGrid& surface,
                      const Pose& T_camera_object,
                      std::span<const SurfacePoint> scene,
                      double reach) {
  const Eigen::Isometry3f T = T_camera_object.inverse().cast<float>();
  const auto inverse_square = static_cast<float>(1.0 / (reach * reach));
  float sum = 0.0F;
  for (const SurfacePoint& point : scene) {
    const Eigen::Vector3f place = T * point.position;
    const uint32_t nearest = surface.Find(place);
    if (nearest == NearestGrid::kNone) continue;
    const SurfacePoint& found = surface.points()[nearest];
    const float cosine = found.normal.dot(T.linear() * point.normal);
    const float distance = found.normal.dot(place - found.position);
    const float weight = 1.0F - distance * distance * inverse_square;
    if (cosine > 0.5F && weight > 0.0F) sum += weight * cosine;
  }
  return static_cast<double>(sum);
}

// Adds the seconds since the last call to a step.
class Stopwatch {
 public:
  explicit Stopwatch(ShotTimes* times)
      : times_(times != nullptr && times->clock ? times : nullptr) {
    if (times_ != nullptr) last_ = times_->clock();
  }
  void Lap(double ShotTimes::*step) {
    if (times_ == nullptr) return;
    const double now = times_->clock();
    times_->*step += now - last_;
    last_ = now;
  }

 private:
  ShotTimes* times_;
  double last_ = 0.0;
};

}  // namespace

Result<std::unique_ptr<ShotProposer>> ShotProposer::Create(std::span<const ObjectModel> models,
                                                           const ShotParameters& parameters) {
  if (Result<void> valid = parameters.Validate(); !valid) return valid.error();
  std::unique_ptr<ShotProposer> proposer(new ShotProposer(parameters));
  for (const ObjectModel& object : models) {
    Result<ShotModel> shot = ShotModel::Train(object, parameters);
    if (!shot) return shot.error();
    proposer->models_.push_back({std::move(shot).value(),
                                 MakeGrid(object, parameters.inlier_distance * object.diameter),
                                 object.symmetry,
                                 object.center,
                                 InMeters(parameters, object.diameter)});
  }
  return proposer;
}

std::unique_ptr<PoseProposer> ShotProposer::Clone() const {
  std::unique_ptr<ShotProposer> clone(new ShotProposer(parameters_));
  clone->models_ = models_;
  return clone;
}

double ShotProposer::Spacing(size_t model) const {
  return parameters_.spacing * models_[model].shot.diameter();
}

std::span<const PoseHypothesis> ShotProposer::Propose(size_t model,
                                                      std::span<const SurfacePoint> scene,
                                                      Rng& rng) {
  return Propose(model, scene, rng, nullptr);
}

std::span<const PoseHypothesis> ShotProposer::Propose(size_t model,
                                                      std::span<const SurfacePoint> scene,
                                                      Rng& rng,
                                                      ShotTimes* times) {
  Model& known = models_[model];
  const double diameter = known.shot.diameter();
  Stopwatch stopwatch(times);
  scene_.clear();
  for (const SurfacePoint& point : scene) {
    if (IsUsable(point)) scene_.push_back(point);
  }
  SelectKeypoints(scene_, parameters_.keypoint_spacing * diameter, &keypoints_);
  stopwatch.Lap(&ShotTimes::keypoints);
  const std::span<const ShotFeature> features =
      features_.Compute(scene_, keypoints_, parameters_.descriptor_radius * diameter);
  stopwatch.Lap(&ShotTimes::features);
  known.shot.Match(features, &correspondences_);
  stopwatch.Lap(&ShotTimes::matching);
  const std::span<const ConsensusPose> poses = ransac_.Run(correspondences_, known.ransac, rng);
  stopwatch.Lap(&ShotTimes::ransac);
  Rank(known, poses);
  stopwatch.Lap(&ShotTimes::ranking);
  return hypotheses_;
}

// Those that explain most of the scene, and differ modulo symmetry.
void ShotProposer::Rank(const Model& model, std::span<const ConsensusPose> poses) {
  ranked_.clear();
  for (const ConsensusPose& pose : poses) {
    ranked_.push_back(
        {pose.T_query_match,
         ScoreOnSurface(model.surface, pose.T_query_match, scene_, model.ransac.inlier_distance)});
  }
  // By insertion: stable, and without memory of its own.
  const auto has_more = [](const PoseHypothesis& a, const PoseHypothesis& b) {
    return a.votes > b.votes;
  };
  for (auto pose = ranked_.begin(); pose != ranked_.end(); ++pose) {
    std::rotate(std::upper_bound(ranked_.begin(), pose, *pose, has_more), pose, pose + 1);
  }
  hypotheses_.clear();
  const double same_place = kSamePlace * model.shot.diameter();
  for (const PoseHypothesis& pose : ranked_) {
    if (hypotheses_.size() == static_cast<size_t>(parameters_.max_hypotheses)) break;
    const Eigen::Vector3d place = pose.T_camera_object * model.center;
    const Eigen::Quaterniond rotation(pose.T_camera_object.linear());
    const bool is_known =
        std::any_of(hypotheses_.begin(), hypotheses_.end(), [&](const PoseHypothesis& other) {
          return (other.T_camera_object * model.center - place).norm() < same_place &&
                 SymmetricAngle(model.symmetry,
                                Eigen::Quaterniond(other.T_camera_object.linear()),
                                rotation) < kSameAngle;
        });
    if (!is_known) hypotheses_.push_back(pose);
  }
}

}  // namespace vantage
