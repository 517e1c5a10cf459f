#include "perception/ppf/ppf_voting.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "common/format.h"

namespace vantage {
namespace {

// One dimension's bins that a feature votes in: its own, and a neighbor when the border is near.
struct BinRange {
  int first;
  int last;
};

BinRange Range(float scaled, int own, float spread) {
  const float within = scaled - static_cast<float>(own);
  return {within < spread ? own - 1 : own, within > 1.0F - spread ? own + 1 : own};
}

struct Peak {
  size_t model_point;
  double turn;  // rad
  double votes;
};

// The best turn of every model point, of which the best points; ties by index.
std::vector<Peak> FindPeaks(const VoteCounts& counts, size_t num_points, int turn_bins, int keep) {
  const auto bins = static_cast<size_t>(turn_bins);
  std::vector<std::pair<uint32_t, uint32_t>> best(num_points);  // votes, bin
  for (size_t point = 0; point < num_points; ++point) {
    const uint32_t* row = counts.data() + point * bins;
    for (size_t bin = 0; bin < bins; ++bin) {
      const uint32_t votes = row[(bin + bins - 1) % bins] + row[bin] + row[(bin + 1) % bins];
      if (votes > best[point].first) best[point] = {votes, static_cast<uint32_t>(bin)};
    }
  }
  std::vector<uint32_t> order(num_points);
  std::iota(order.begin(), order.end(), 0U);
  const size_t count = std::min(static_cast<size_t>(keep), num_points);
  std::partial_sort(order.begin(),
                    order.begin() + static_cast<std::ptrdiff_t>(count),
                    order.end(),
                    [&best](uint32_t a, uint32_t b) {
                      return best[a].first != best[b].first ? best[a].first > best[b].first : a < b;
                    });
  std::vector<Peak> peaks;
  for (size_t i = 0; i < count; ++i) {
    const auto [votes, bin] = best[order[i]];
    if (votes == 0) break;
    const uint32_t* row = counts.data() + order[i] * bins;
    const double before = row[(bin + bins - 1) % bins];
    const double after = row[(bin + 1) % bins];
    const double center = bin + 0.5 + (after - before) / votes;
    peaks.push_back({order[i], 2.0 * std::numbers::pi * center / turn_bins, double{1} * votes});
  }
  return peaks;
}

}  // namespace

Result<void> PpfVotingParameters::Validate() const {
  if (!(reference_share > 0.0 && reference_share <= 1.0) || min_references < 1 ||
      max_references < min_references) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("reference points: share %g (expected above 0, to 1), from %d to %d "
                        "(expected 1 or more, ascending)",
                        reference_share,
                        min_references,
                        max_references)};
  }
  if (turn_bins < 4 || turn_bins > 360 || !(spread >= 0.0 && spread <= 0.5)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("voting: turn_bins = %d (expected 4 to 360), spread = %g (expected 0 to "
                        "0.5)",
                        turn_bins,
                        spread)};
  }
  if (peaks_per_reference < 1 || max_hypotheses < 1 || !(cluster_distance > 0.0) ||
      !(cluster_angle_deg > 0.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("voting: peaks_per_reference = %d, max_hypotheses = %d, cluster_distance = "
                        "%g, cluster_angle_deg = %g, expected all above 0",
                        peaks_per_reference,
                        max_hypotheses,
                        cluster_distance,
                        cluster_angle_deg)};
  }
  return {};
}

void AccumulateVotes(const PpfTable& table,
                     std::span<const SurfacePoint> scene,
                     size_t reference,
                     const PpfVotingParameters& parameters,
                     VoteCounts* counts) {
  const auto turn_bins = static_cast<uint32_t>(parameters.turn_bins);
  const auto spread = static_cast<float>(parameters.spread);
  counts->assign(table.points().size() * turn_bins, 0);
  uint32_t* const votes = counts->data();
  const Eigen::Isometry3f T_aligned = AlignToXAxis(scene[reference]);
  const float farthest = 1.05F * static_cast<float>(table.diameter());
  for (size_t other = 0; other < scene.size(); ++other) {
    if (other == reference) continue;
    const PointPairFeature feature = ComputePointPairFeature(scene[reference], scene[other]);
    if (feature.distance > farthest) continue;
    const uint16_t scene_turn = QuantizeTurn(AngleAboutX(T_aligned, scene[other].position));
    const std::array<float, 4> scaled = table.Scale(feature);
    const PpfTable::Bins own = table.Quantize(feature);
    std::array<BinRange, 4> range{};
    for (size_t i = 0; i < 4; ++i) range[i] = Range(scaled[i], own[i], spread);
    PpfTable::Bins bins{};
    for (bins[0] = range[0].first; bins[0] <= range[0].last; ++bins[0]) {
      for (bins[1] = range[1].first; bins[1] <= range[1].last; ++bins[1]) {
        for (bins[2] = range[2].first; bins[2] <= range[2].last; ++bins[2]) {
          for (bins[3] = range[3].first; bins[3] <= range[3].last; ++bins[3]) {
            for (const PpfTable::Entry& entry : table.Lookup(bins)) {
              const auto turn = static_cast<uint16_t>(entry.angle - scene_turn);
              const uint32_t bin = (turn * turn_bins) >> 16U;
              ++votes[entry.reference * turn_bins + bin];
            }
          }
        }
      }
    }
  }
}

Pose PoseFromAlignment(const SurfacePoint& scene_point,
                       const SurfacePoint& model_point,
                       double turn) {
  // Drost et al. 2010, eq. 2: s_i = T_s^-1 R_x(alpha) T_m m_i.
  const Pose T_x_scene = Pose(AlignToXAxis(scene_point).matrix().cast<double>());
  const Pose T_x_model = Pose(AlignToXAxis(model_point).matrix().cast<double>());
  Pose pose = T_x_scene.inverse() * Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitX()) * T_x_model;
  pose.linear() = Eigen::Quaterniond(pose.linear()).normalized().toRotationMatrix();
  return pose;
}

std::vector<PoseHypothesis> VotePoses(const PpfTable& table,
                                      std::span<const SurfacePoint> scene,
                                      const Eigen::Vector3d& center,
                                      const PpfVotingParameters& parameters,
                                      Rng& rng) {
  std::vector<uint32_t> order(scene.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto share =
      static_cast<int>(std::ceil(parameters.reference_share * static_cast<double>(scene.size())));
  const size_t references = std::min(
      scene.size(),
      static_cast<size_t>(std::clamp(share, parameters.min_references, parameters.max_references)));
  VoteCounts counts;
  std::vector<PoseHypothesis> hypotheses;
  for (size_t i = 0; i < references; ++i) {
    // A random subset, drawn one by one (Fisher-Yates).
    std::swap(order[i], order[i + rng.Below(static_cast<uint32_t>(order.size() - i))]);
    const size_t reference = order[i];
    AccumulateVotes(table, scene, reference, parameters, &counts);
    for (const Peak& peak : FindPeaks(
             counts, table.points().size(), parameters.turn_bins, parameters.peaks_per_reference)) {
      hypotheses.push_back(
          {PoseFromAlignment(scene[reference], table.points()[peak.model_point], peak.turn),
           peak.votes});
    }
  }
  return ClusterPoses(std::move(hypotheses),
                      center,
                      parameters.cluster_distance * table.diameter(),
                      parameters.cluster_angle_deg * kDegree,
                      static_cast<size_t>(parameters.max_hypotheses));
}

std::vector<PoseHypothesis> ClusterPoses(std::vector<PoseHypothesis> hypotheses,
                                         const Eigen::Vector3d& center,
                                         double distance,
                                         double angle,
                                         size_t max_clusters) {
  std::stable_sort(
      hypotheses.begin(), hypotheses.end(), [](const PoseHypothesis& a, const PoseHypothesis& b) {
        return a.votes > b.votes;
      });
  struct Accumulated {
    Eigen::Vector3d seed_center;
    Eigen::Quaterniond seed_rotation;
    Eigen::Vector3d center_sum = Eigen::Vector3d::Zero();
    Eigen::Vector4d rotation_sum = Eigen::Vector4d::Zero();
    double votes = 0.0;
  };
  std::vector<Accumulated> clusters;
  for (const PoseHypothesis& hypothesis : hypotheses) {
    const Eigen::Vector3d place = hypothesis.T_camera_object * center;
    const Eigen::Quaterniond rotation(hypothesis.T_camera_object.linear());
    auto found = std::find_if(clusters.begin(), clusters.end(), [&](const Accumulated& cluster) {
      return (cluster.seed_center - place).norm() <= distance &&
             GeodesicAngle(cluster.seed_rotation, rotation) <= angle;
    });
    if (found == clusters.end()) {
      clusters.push_back({place, rotation});
      found = clusters.end() - 1;
    }
    const double sign = found->seed_rotation.dot(rotation) < 0.0 ? -1.0 : 1.0;
    found->center_sum += hypothesis.votes * place;
    found->rotation_sum += hypothesis.votes * sign * rotation.coeffs();
    found->votes += hypothesis.votes;
  }
  std::stable_sort(clusters.begin(),
                   clusters.end(),
                   [](const Accumulated& a, const Accumulated& b) { return a.votes > b.votes; });
  std::vector<PoseHypothesis> means;
  for (size_t i = 0; i < std::min(clusters.size(), max_clusters); ++i) {
    PoseHypothesis mean;
    mean.T_camera_object.linear() =
        Eigen::Quaterniond(clusters[i].rotation_sum.normalized()).toRotationMatrix();
    mean.T_camera_object.translation() =
        clusters[i].center_sum / clusters[i].votes - mean.T_camera_object.linear() * center;
    mean.votes = clusters[i].votes;
    means.push_back(mean);
  }
  return means;
}

}  // namespace vantage
