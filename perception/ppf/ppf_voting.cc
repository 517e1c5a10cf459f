#include "perception/ppf/ppf_voting.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>
#include <numeric>

#include "common/format.h"
#include "common/simd.h"

namespace vantage {
namespace {

constexpr int kMaxVotes = 30000;  // Of a reference: sums of three counts fit into 16 bits.

[[gnu::always_inline]] inline void Load(const float* from, F8* to) {
  std::memcpy(to, from, sizeof(F8));
}

[[gnu::always_inline]] inline void Store(const I8& from, int32_t* to) {
  std::memcpy(to, &from, sizeof(I8));
}

// One dimension: the lowest bin in which a feature votes, and whether the next one is another.
[[gnu::always_inline]] inline void Spread(
    const F8& scaled, float spread, int32_t last_bin, I8* lowest, I8* is_double) {
  I8 own = __builtin_convertvector(scaled, I8);
  own = own > last_bin ? own * 0 + last_bin : own;
  own = own < 0 ? own * 0 : own;
  const F8 within = scaled - __builtin_convertvector(own, F8);
  const I8 below = (within < spread) & (own > 0);
  const I8 above = (within > 1.0F - spread) & (own < last_bin);
  *lowest = own + below;  // Comparisons give -1.
  *is_double = below | above;
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
  if (votes_per_reference < 1 || votes_per_reference > kMaxVotes) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format(
            "voting: votes_per_reference = %d, expected 1 to %d", votes_per_reference, kMaxVotes)};
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

size_t PpfVotingParameters::NumReferences(size_t scene_points) const {
  const auto share =
      static_cast<int>(std::ceil(reference_share * static_cast<double>(scene_points)));
  return std::min(scene_points,
                  static_cast<size_t>(std::clamp(share, min_references, max_references)));
}

VANTAGE_SIMD
void PpfVoting::FindCells(const PpfTable& table, const PpfVotingParameters& parameters) {
  const size_t padded = features_.distance.size();
  cells_.base.resize(padded);
  cells_.up.resize(padded);
  const auto spread = static_cast<float>(parameters.spread);
  const int32_t angles = table.angle_bins();
  const int32_t distances = table.distance_bins();
  const float farthest = static_cast<float>(distances) + spread;
  for (size_t i = 0; i < padded; i += kLanes) {
    F8 scaled;
    Load(&features_.distance[i], &scaled);
    scaled *= table.distance_scale();
    const I8 is_near = (scaled > 0.0F) & (scaled < farthest);
    scaled = is_near ? scaled : scaled * 0.0F;
    I8 base;
    I8 lowest;
    I8 is_double;
    Spread(scaled, spread, distances - 1, &base, &is_double);
    I8 up = is_double & 1;
    const std::array<const std::vector<float>*, 3> rows = {
        &features_.angle_normal1, &features_.angle_normal2, &features_.angle_normals};
    for (int k = 0; k < 3; ++k) {
      Load(rows[static_cast<size_t>(k)]->data() + i, &scaled);
      scaled *= table.angle_scale();
      Spread(scaled, spread, angles - 1, &lowest, &is_double);
      base = base * angles + lowest;
      up |= is_double & (2 << k);
    }
    Store(is_near ? base : base * 0 - 1, &cells_.base[i]);
    Store(up, &cells_.up[i]);
  }
}

namespace {

// Calls `visit(first, end)` with each run of a pair's cells.
template <class Visit>
[[gnu::always_inline]] inline void ForEachRun(int32_t base,
                                              int32_t up,
                                              int32_t angles,
                                              Visit visit) {
  const int32_t run = (up & 8) != 0 ? 2 : 1;
  for (int32_t d = 0; d <= (up & 1); ++d) {
    for (int32_t first = 0; first <= (up >> 1 & 1); ++first) {
      for (int32_t second = 0; second <= (up >> 2 & 1); ++second) {
        const int32_t cell = base + ((d * angles + first) * angles + second) * angles;
        visit(static_cast<size_t>(cell), static_cast<size_t>(cell + run));
      }
    }
  }
}

}  // namespace

// A counting sort by the pairs' number of entries, where a factor of 2^(1/2) makes a class.
void PpfVoting::SortByRarity(const PpfTable& table, size_t reference) {
  const std::span<const uint32_t> starts = table.starts();
  const size_t padded = cells_.base.size();
  sizes_.resize(padded);
  order_.clear();
  constexpr size_t kClasses = 64;
  const auto rarity = [](uint32_t size) -> size_t {
    const int top = std::bit_width(size);
    return static_cast<size_t>(2 * top) + (top > 1 ? (size >> (top - 2) & 1U) : 0U);
  };
  std::array<uint32_t, kClasses + 1> next{};
  for (size_t i = 0; i < padded; ++i) {
    uint32_t size = 0;
    if (cells_.base[i] >= 0 && i != reference) {
      ForEachRun(cells_.base[i], cells_.up[i], table.angle_bins(), [&](size_t first, size_t end) {
        size += starts[end] - starts[first];
      });
    }
    sizes_[i] = std::min(size, 0x3fffffffU);
    if (size > 0) ++next[rarity(sizes_[i]) + 1];
  }
  std::partial_sum(next.begin(), next.end(), next.begin());
  order_.resize(next.back());
  for (size_t i = 0; i < padded; ++i) {
    if (sizes_[i] > 0) order_[next[rarity(sizes_[i])]++] = static_cast<uint32_t>(i);
  }
}

size_t PpfVoting::Vote(const PpfTable& table, uint32_t pair, size_t budget) {
  const std::span<const uint32_t> starts = table.starts();
  const PpfTable::Entry* const entries = table.entries().data();
  const uint16_t scene_turn = QuantizeTurn(features_.turn[pair]);
  const auto bins = static_cast<uint32_t>(turn_bins_);
  const size_t stride = stride_;
  int16_t* const counts = counts_.data();
  size_t left = budget;
  ForEachRun(cells_.base[pair], cells_.up[pair], table.angle_bins(), [&](size_t first, size_t end) {
    const size_t begin = starts[first];
    const size_t count = std::min<size_t>(starts[end] - begin, left);
    left -= count;
    for (size_t i = begin; i < begin + count; ++i) {
      const PpfTable::Entry entry = entries[i];
      const auto turn = static_cast<uint16_t>(entry.angle - scene_turn);
      ++counts[entry.reference * stride + ((turn * bins) >> 16U)];
    }
  });
  return budget - left;
}

void PpfVoting::Accumulate(const PpfTable& table,
                           const SurfaceLanes& scene,
                           size_t reference,
                           const PpfVotingParameters& parameters) {
  num_points_ = table.points().size();
  turn_bins_ = static_cast<size_t>(parameters.turn_bins);
  stride_ = (turn_bins_ + 2 + 7) / 8 * 8;
  counts_.assign(num_points_ * stride_, 0);
  ComputePairFeatures(scene.at(reference), scene, &features_);
  FindCells(table, parameters);
  SortByRarity(table, reference);
  auto left = static_cast<size_t>(parameters.votes_per_reference);
  for (const uint32_t pair : order_) {
    if (left == 0) break;
    left -= Vote(table, pair, left);
  }
}

// Turns wrap around: each row ends with its first two counts again.
void PpfVoting::CloseRows() {
  for (size_t point = 0; point < num_points_; ++point) {
    int16_t* const row = counts_.data() + point * stride_;
    row[turn_bins_] = row[0];
    row[turn_bins_ + 1] = row[1];
  }
}

VANTAGE_SIMD
void PpfVoting::MaximizeRows() {
  best_.resize(num_points_);
  for (size_t point = 0; point < num_points_; ++point) {
    const int16_t* const row = counts_.data() + point * stride_;
    int16_t best = 0;
    for (size_t bin = 0; bin < turn_bins_; ++bin) {
      const auto votes = static_cast<int16_t>(row[bin] + row[bin + 1] + row[bin + 2]);
      best = best > votes ? best : votes;
    }
    best_[point] = best;
  }
}

std::span<const PpfVoting::Peak> PpfVoting::FindPeaks(size_t keep) {
  CloseRows();
  MaximizeRows();
  // The count that `keep` points reach.
  int16_t threshold = 0;
  for (const int16_t best : best_) threshold = std::max(threshold, best);
  histogram_.assign(static_cast<size_t>(threshold) + 1, 0);
  for (const int16_t best : best_) ++histogram_[static_cast<size_t>(best)];
  size_t above = 0;
  while (threshold > 1 && above + histogram_[static_cast<size_t>(threshold)] < keep) {
    above += histogram_[static_cast<size_t>(threshold--)];
  }
  // Of those that just reach it the first.
  size_t ties = keep > above ? keep - above : 0;
  peaks_.clear();
  for (size_t point = 0; point < num_points_; ++point) {
    const int16_t best = best_[point];
    if (best == 0 || best < threshold) continue;
    if (best == threshold && ties-- == 0) {
      ++ties;
      continue;
    }
    const int16_t* row = counts_.data() + point * stride_;
    size_t bin = 0;
    while (row[bin] + row[bin + 1] + row[bin + 2] != best) ++bin;
    const auto votes = static_cast<float>(best);
    const float center =
        static_cast<float>(bin) + 1.5F + static_cast<float>(row[bin + 2] - row[bin]) / votes;
    const float turn = 2.0F * std::numbers::pi_v<float> * center / static_cast<float>(turn_bins_);
    peaks_.push_back({static_cast<uint32_t>(point), turn, votes});
  }
  return peaks_;
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
  const size_t references = parameters.NumReferences(scene.size());
  SurfaceLanes lanes;
  lanes.Assign(scene);
  PpfVoting voting;
  std::vector<PoseHypothesis> hypotheses;
  for (size_t i = 0; i < references; ++i) {
    // A random subset, drawn one by one (Fisher-Yates).
    std::swap(order[i], order[i + rng.Below(static_cast<uint32_t>(order.size() - i))]);
    const size_t reference = order[i];
    voting.Accumulate(table, lanes, reference, parameters);
    for (const PpfVoting::Peak& peak :
         voting.FindPeaks(static_cast<size_t>(parameters.peaks_per_reference))) {
      hypotheses.push_back(
          {PoseFromAlignment(
               scene[reference], table.points()[peak.model_point], static_cast<double>(peak.turn)),
           static_cast<double>(peak.votes)});
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
