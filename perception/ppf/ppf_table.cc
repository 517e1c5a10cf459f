#include "perception/ppf/ppf_table.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <unordered_map>

#include "common/format.h"
#include "perception/ppf/pair_features.h"

namespace vantage {

Result<void> PpfTableParameters::Validate() const {
  if (!(sample_distance >= 0.01 && sample_distance <= 0.5)) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("sample_distance = %g of the diameter, expected 0.01 to 0.5", sample_distance)};
  }
  if (!(distance_step >= 0.01 && distance_step <= 0.5)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("distance_step = %g of the diameter, expected 0.01 to 0.5", distance_step)};
  }
  if (!(angle_step_deg >= 4.0 && angle_step_deg <= 60.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("angle_step_deg = %g, expected 4 to 60", angle_step_deg)};
  }
  if (max_points < 3 || max_points > 8000) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("max_points = %d, expected 3 to 8000", max_points)};
  }
  return {};
}

uint16_t QuantizeTurn(float angle) {
  // Shifted by a whole turn, so that cutting off rounds.
  const float units = angle * (65536.0F / (2.0F * std::numbers::pi_v<float>)) + 65536.5F;
  return static_cast<uint16_t>(static_cast<int32_t>(units) & 0xffff);
}

std::vector<SurfacePoint> ThinSamples(std::span<const SurfacePoint> samples,
                                      double distance,
                                      double angle,
                                      size_t max_points) {
  const auto limit = static_cast<float>(distance * distance);
  const auto cosine = static_cast<float>(std::cos(angle));
  const double inverse = 1.0 / distance;
  const auto key = [](int64_t x, int64_t y, int64_t z) {
    constexpr int64_t kHalf = 1 << 20;
    return (static_cast<uint64_t>(x + kHalf) & 0x1fffffU) << 42U |
           (static_cast<uint64_t>(y + kHalf) & 0x1fffffU) << 21U |
           (static_cast<uint64_t>(z + kHalf) & 0x1fffffU);
  };
  std::unordered_map<uint64_t, std::vector<uint32_t>> cubes;
  std::vector<SurfacePoint> kept;
  for (const SurfacePoint& sample : samples) {
    const Eigen::Vector3d scaled = sample.position.cast<double>() * inverse;
    const Eigen::Vector3d cell = scaled.array().floor().max(-1e6).min(1e6);
    const Eigen::Vector3i at = cell.cast<int>();
    bool is_near = false;
    for (int i = 0; i < 27 && !is_near; ++i) {
      const auto found =
          cubes.find(key(at.x() + i % 3 - 1, at.y() + i / 3 % 3 - 1, at.z() + i / 9 - 1));
      if (found == cubes.end()) continue;
      is_near = std::any_of(found->second.begin(), found->second.end(), [&](uint32_t j) {
        return (kept[j].position - sample.position).squaredNorm() < limit &&
               kept[j].normal.dot(sample.normal) > cosine;
      });
    }
    if (is_near) continue;
    if (kept.size() == max_points) break;
    cubes[key(at.x(), at.y(), at.z())].push_back(static_cast<uint32_t>(kept.size()));
    kept.push_back(sample);
  }
  return kept;
}

void PpfTable::SetScale() {
  const double angle_step = parameters_.angle_step_deg * kDegree;
  distance_scale_ = static_cast<float>(1.0 / (parameters_.distance_step * diameter_));
  angle_scale_ = static_cast<float>(1.0 / angle_step);
  // The diameter is known to 1 %.
  distance_bins_ = static_cast<int>(std::ceil(1.02 / parameters_.distance_step)) + 1;
  angle_bins_ = static_cast<int>(std::ceil(std::numbers::pi / angle_step - 1e-9));
}

std::array<float, 4> PpfTable::Scale(const PointPairFeature& feature) const {
  return {feature.distance * distance_scale_,
          feature.angle_normal1 * angle_scale_,
          feature.angle_normal2 * angle_scale_,
          feature.angle_normals * angle_scale_};
}

PpfTable::Bins PpfTable::Quantize(const PointPairFeature& feature) const {
  const std::array<float, 4> scaled = Scale(feature);
  Bins bins{};
  // A distance far beyond the table's must not overflow.
  bins[0] = static_cast<int>(std::min(scaled[0], 1e6F));
  // The angle pi itself belongs to the last bin.
  for (size_t i = 1; i < 4; ++i) bins[i] = std::min(static_cast<int>(scaled[i]), angle_bins_ - 1);
  return bins;
}

size_t PpfTable::Cell(const Bins& bins) const {
  const auto angles = static_cast<size_t>(angle_bins_);
  return ((static_cast<size_t>(bins[0]) * angles + static_cast<size_t>(bins[1])) * angles +
          static_cast<size_t>(bins[2])) *
             angles +
         static_cast<size_t>(bins[3]);
}

size_t PpfTable::NumCells() const {
  const auto angles = static_cast<size_t>(angle_bins_);
  return static_cast<size_t>(distance_bins_) * angles * angles * angles;
}

std::span<const PpfTable::Entry> PpfTable::Lookup(const Bins& bins) const {
  if (bins[0] < 0 || bins[0] >= distance_bins_) return {};
  for (size_t i = 1; i < 4; ++i) {
    if (bins[i] < 0 || bins[i] >= angle_bins_) return {};
  }
  const size_t cell = Cell(bins);
  return std::span<const Entry>(entries_).subspan(starts_[cell], starts_[cell + 1] - starts_[cell]);
}

Result<PpfTable> PpfTable::Train(std::span<const SurfacePoint> samples,
                                 double diameter,
                                 const PpfTableParameters& parameters) {
  if (Result<void> valid = parameters.Validate(); !valid) return valid.error();
  if (!(diameter > 0.0 && diameter < 1e3)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("diameter = %g m of a model, expected above 0", diameter)};
  }
  for (const SurfacePoint& sample : samples) {
    if (!sample.position.allFinite() || !(std::abs(sample.normal.norm() - 1.0F) < 1e-3F)) {
      return Error{ErrorCode::kInvalidArgument,
                   "a surface sample of the model is not finite or its normal not of unit length"};
    }
  }
  PpfTable table;
  table.parameters_ = parameters;
  table.diameter_ = diameter;
  table.SetScale();
  table.points_ = ThinSamples(samples,
                              parameters.sample_distance * diameter,
                              30.0 * kDegree,
                              static_cast<size_t>(parameters.max_points));
  const size_t size = table.points_.size();
  if (size < 3) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%zu surface points are left of %zu samples, expected 3 or more",
                        size,
                        samples.size())};
  }
  // Two passes, counting sort by cell; within a cell by reference, then by second point.
  std::vector<Entry> unsorted(size * size);
  std::vector<uint32_t> cells(size * size);
  constexpr uint32_t kNone = 0xffffffffU;
  table.starts_.assign(table.NumCells() + 1, 0);
  SurfaceLanes lanes;
  lanes.Assign(table.points_);
  PairFeatures features;
  for (size_t i = 0; i < size; ++i) {
    ComputePairFeatures(table.points_[i], lanes, &features);
    for (size_t j = 0; j < size; ++j) {
      const size_t pair = i * size + j;
      cells[pair] = kNone;
      if (i == j) continue;
      const Bins bins = table.Quantize({features.distance[j],
                                        features.angle_normal1[j],
                                        features.angle_normal2[j],
                                        features.angle_normals[j]});
      if (bins[0] >= table.distance_bins_) continue;
      cells[pair] = static_cast<uint32_t>(table.Cell(bins));
      unsorted[pair] = {static_cast<uint16_t>(i), QuantizeTurn(features.turn[j])};
      ++table.starts_[cells[pair] + 1];
    }
  }
  std::partial_sum(table.starts_.begin(), table.starts_.end(), table.starts_.begin());
  std::vector<uint32_t> next(table.starts_.begin(), table.starts_.end() - 1);
  table.entries_.resize(table.starts_.back());
  for (size_t pair = 0; pair < cells.size(); ++pair) {
    if (cells[pair] != kNone) table.entries_[next[cells[pair]]++] = unsorted[pair];
  }
  return table;
}

}  // namespace vantage
