#include "perception/ppf/ppf_proposer.h"

#include <algorithm>
#include <cmath>

#include "common/simd.h"

namespace vantage {
namespace {

constexpr size_t kFewestPoints = 3;
constexpr size_t kMostPoints = 400;  // Of a scene; more are thinned.
constexpr size_t kProbes = 64;
constexpr size_t kOutline = 96;
constexpr int kPolishRounds = 1;
constexpr float kPolishTurn = 0.1F;    // rad
constexpr double kPolishShift = 0.03;  // Of the diameter.
// A share of the model outside of the silhouette counts like this part of the scene off the model.
constexpr float kOutsideWeight = 0.5F;
constexpr double kReach = 0.06;  // Of the diameter.
constexpr double kCell = 0.03;   // Of the diameter.

SurfaceScore MakeScore(const PpfTable& table) {
  const double diameter = table.diameter();
  return {table.points(),
          table.parameters().sample_distance * diameter,
          kReach * diameter,
          kCell * diameter};
}

// Samples come in random order.
SurfaceLanes Outline(std::span<const SurfacePoint> points) {
  SurfaceLanes outline;
  const size_t count = std::min(points.size(), kOutline);
  for (size_t i = 0; i < count || i % kLanes != 0; ++i) outline.Add(points[i % points.size()]);
  return outline;
}

}  // namespace

PpfProposer::PpfProposer(std::vector<Model> models, const PpfVotingParameters& parameters)
    : parameters_(parameters) {
  for (Model& model : models) {
    SurfaceScore score = MakeScore(model.table);
    std::vector<Eigen::Isometry3f> T_aligned_object;
    for (const SurfacePoint& point : model.table.points()) {
      T_aligned_object.push_back(AlignToXAxis(point));
    }
    SurfaceLanes outline = Outline(model.table.points());
    models_.push_back(
        {std::move(model), std::move(score), std::move(T_aligned_object), std::move(outline)});
  }
}

double PpfProposer::Spacing(size_t model) const {
  const PpfTable& table = models_[model].model.table;
  return table.parameters().sample_distance * table.diameter();
}

// Points come in the order of the image's rows: every so-manieth is spread over the cluster.
void PpfProposer::TakeScene(std::span<const SurfacePoint> scene, double spacing) {
  scene_.Clear();
  const size_t count = std::min(scene.size(), kMostPoints);
  for (size_t i = 0; i < count; ++i) {
    const SurfacePoint& point = scene[i * scene.size() / count];
    if (point.position.allFinite() && point.normal.allFinite()) scene_.Add(point);
  }
  scene_.Pad();
  probes_.Clear();
  const size_t probes = std::min(scene_.size, kProbes);
  for (size_t i = 0; i < probes; ++i)
    probes_.Add(scene_.at((2 * i + 1) * scene_.size / (2 * probes)));
  probes_.Pad();
  silhouette_.Draw(scene_, static_cast<float>(spacing));
}

void PpfProposer::AddCandidates(const Prepared& prepared, size_t reference) {
  voting_.Accumulate(prepared.model.table, scene_, reference, parameters_);
  const Eigen::Isometry3f T_aligned_camera = AlignToXAxis(scene_.at(reference));
  for (const PpfVoting::Peak& peak :
       voting_.FindPeaks(static_cast<size_t>(parameters_.peaks_per_reference))) {
    // Drost et al. 2010, eq. 2, the other way round.
    const Eigen::AngleAxisf turn(-peak.turn, Eigen::Vector3f::UnitX());
    const Eigen::Isometry3f T =
        prepared.T_aligned_object[peak.model_point].inverse() * turn * T_aligned_camera;
    const Eigen::Isometry3f T_camera_object = T.inverse();
    candidates_.push_back({T_camera_object, Rate(prepared, T_camera_object), candidates_.size()});
  }
}

float PpfProposer::Rate(const Prepared& prepared, const Eigen::Isometry3f& T) const {
  const float on_surface =
      prepared.score.Score(T.inverse(), probes_) / static_cast<float>(probes_.size);
  const float outside = static_cast<float>(silhouette_.CountOutside(T, prepared.outline)) /
                        static_cast<float>(prepared.outline.size);
  return on_surface - kOutsideWeight * outside;
}

// Tries turns about the center and shifts, one after the other, and keeps what is better.
void PpfProposer::Polish(const Prepared& prepared, Candidate* candidate) const {
  const Eigen::Vector3f center = prepared.model.center.cast<float>();
  const auto shift = static_cast<float>(kPolishShift * prepared.model.table.diameter());
  for (int step = 0; step < 2 * 6 * kPolishRounds; ++step) {
    const float sign = step % 2 == 0 ? 1.0F : -1.0F;
    const Eigen::Vector3f axis = Eigen::Vector3f::Unit(step / 2 % 3);
    Eigen::Isometry3f T = candidate->T_camera_object;
    if (step / 6 % 2 == 0) {
      const Eigen::Vector3f place = T * center;
      T.linear() = Eigen::AngleAxisf(sign * kPolishTurn, axis) * T.linear();
      T.translation() = place - T.linear() * center;
    } else {
      T.translation() += sign * shift * axis;
    }
    const float score = Rate(prepared, T);
    if (score > candidate->score) *candidate = {T, score, candidate->number};
  }
}

// The best candidates of which none is like another.
void PpfProposer::KeepDistinct(const Prepared& prepared, size_t count) {
  const auto distance =
      static_cast<float>(parameters_.cluster_distance * prepared.model.table.diameter());
  const double angle = parameters_.cluster_angle_deg * kDegree;
  const Eigen::Vector3f center = prepared.model.center.cast<float>();
  std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& b) {
    return a.score != b.score ? a.score > b.score : a.number < b.number;
  });
  distinct_.clear();
  for (const Candidate& candidate : candidates_) {
    const Eigen::Isometry3f& T = candidate.T_camera_object;
    const Eigen::Quaterniond q(Eigen::Matrix3d(T.linear().cast<double>()));
    const bool is_known =
        std::any_of(distinct_.begin(), distinct_.end(), [&](const Candidate& other) {
          const Eigen::Isometry3f& T_other = other.T_camera_object;
          return (T_other * center - T * center).norm() < distance &&
                 SymmetricAngle(
                     prepared.model.symmetry,
                     Eigen::Quaterniond(Eigen::Matrix3d(T_other.linear().cast<double>())),
                     q) < angle;
        });
    if (!is_known) distinct_.push_back(candidate);
    if (distinct_.size() == count) break;
  }
}

std::span<const PoseHypothesis> PpfProposer::Propose(size_t model,
                                                     std::span<const SurfacePoint> scene,
                                                     Rng& rng) {
  const Prepared& prepared = models_[model];
  TakeScene(scene, Spacing(model));
  candidates_.clear();
  hypotheses_.clear();
  if (scene_.size < kFewestPoints) return hypotheses_;
  const size_t references = parameters_.NumReferences(scene_.size);
  const size_t offset = rng.Below(static_cast<uint32_t>(scene_.size));
  for (size_t i = 0; i < references; ++i) {
    AddCandidates(prepared, (offset + i * scene_.size / references) % scene_.size);
  }
  const auto most = static_cast<size_t>(parameters_.max_hypotheses);
  KeepDistinct(prepared, most + most / 2);
  candidates_ = distinct_;
  for (Candidate& candidate : candidates_) Polish(prepared, &candidate);
  KeepDistinct(prepared, most);
  for (const Candidate& candidate : distinct_) {
    Pose T(candidate.T_camera_object.matrix().cast<double>());
    T.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
    hypotheses_.push_back({T, static_cast<double>(candidate.score)});
  }
  return hypotheses_;
}

}  // namespace vantage
