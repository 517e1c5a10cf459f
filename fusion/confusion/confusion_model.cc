#include "fusion/confusion/confusion_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "common/check.h"
#include "common/format.h"
#include "fusion/confusion/difference_modes.h"
#include "fusion/confusion/symmetric_nearness.h"
#include "fusion/confusion/viewing_direction.h"

namespace vantage {
namespace {

// Shares below this are counted as scattered.
constexpr double kLeastShare = 1e-4;

Result<void> CheckTrials(const ContingencyTable& table) {
  const size_t num_directions = table.directions.size();
  if (num_directions < static_cast<size_t>(DirectionGrid::kFewest) ||
      num_directions > static_cast<size_t>(DirectionGrid::kMost)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("the contingency table of \"%s\" has %zu viewing directions, expected %d "
                        "to %d",
                        table.key.model_id.c_str(),
                        num_directions,
                        DirectionGrid::kFewest,
                        DirectionGrid::kMost)};
  }
  bool any = false;
  for (size_t i = 0; i < num_directions; ++i) {
    const DirectionTrials& direction = table.directions[i];
    int64_t detected = 0;
    bool positive = direction.trials >= 0 && direction.missed >= 0;
    for (const DifferenceCount& difference : direction.differences) {
      positive = positive && difference.count > 0;
      detected += difference.count;
    }
    if (!positive || detected + direction.missed != direction.trials) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("the contingency table of \"%s\" has %d trials from direction %zu, of "
                          "which %d missed and %lld detected something, expected these to add up",
                          table.key.model_id.c_str(),
                          direction.trials,
                          i,
                          direction.missed,
                          static_cast<long long>(detected))};
    }
    any = any || direction.trials > 0;
  }
  if (any) return {};
  return Error{ErrorCode::kInvalidArgument,
               Format("the contingency table of \"%s\" has no trials by direction",
                      table.key.model_id.c_str())};
}

// Of each direction: outcome shares, each direction's trials and its neighbors' together.
struct SmoothedShares {
  std::vector<std::vector<ConfusionModel::Share>> modes;
  std::vector<double> missed;  // Nothing was detected.
};

// Gaussian weights by the angle between directions times their trials.
SmoothedShares Smooth(const std::vector<DirectionTrials>& directions,
                      const DifferenceModes& modes,
                      const DirectionGrid& grid,
                      double sigma) {
  constexpr double kCutoff = 3.0;
  SmoothedShares smoothed;
  smoothed.modes.resize(directions.size());
  smoothed.missed.resize(directions.size(), 0.0);
  std::vector<Eigen::Vector3d> centers;
  for (int i = 0; i < grid.num_cells(); ++i) centers.push_back(grid.Center(i));
  std::vector<double> sums(modes.differences.size());
  for (size_t i = 0; i < directions.size(); ++i) {
    if (directions[i].trials == 0) continue;
    std::vector<int> neighbors = {static_cast<int>(i)};
    if (sigma > 0.0) neighbors = grid.CellsWithin(centers[i], kCutoff * sigma);
    std::fill(sums.begin(), sums.end(), 0.0);
    double trials = 0.0;
    double missed = 0.0;
    for (const int neighbor : neighbors) {
      const auto n = static_cast<size_t>(neighbor);
      double weight = 1.0;
      if (n != i) {
        const double angle = std::acos(std::clamp(centers[i].dot(centers[n]), -1.0, 1.0));
        weight = std::exp(-0.5 * angle * angle / (sigma * sigma));
      }
      trials += weight * directions[n].trials;
      missed += weight * directions[n].missed;
      for (const DifferenceModes::Count& count : modes.counts[n]) {
        sums[static_cast<size_t>(count.mode)] += weight * count.count;
      }
    }
    smoothed.missed[i] = missed / trials;
    for (size_t mode = 0; mode < sums.size(); ++mode) {
      if (sums[mode] <= 0.0) continue;
      smoothed.modes[i].push_back({static_cast<int>(mode), sums[mode] / trials});
    }
  }
  return smoothed;
}

// The measured direction nearest to one that is not.
size_t NearestMeasured(const std::vector<DirectionTrials>& directions,
                       const DirectionGrid& grid,
                       const Eigen::Vector3d& center) {
  for (double radius = 0.1;; radius *= 2.0) {
    size_t nearest = 0;
    double largest = -2.0;
    const bool all = radius >= std::numbers::pi;
    for (const int cell : grid.CellsWithin(center, std::min(radius, 2.0 * std::numbers::pi))) {
      const double along = center.dot(grid.Center(cell));
      if (directions[static_cast<size_t>(cell)].trials == 0 || along <= largest) continue;
      largest = along;
      nearest = static_cast<size_t>(cell);
    }
    if (largest > -2.0 || all) return nearest;
  }
}

}  // namespace

Result<void> ConfusionModelParameters::Validate() const {
  if (!(mode_radius >= 0.1 * kDegree && mode_radius <= 45.0 * kDegree)) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("mode_radius = %g rad, expected 0.0017 to 0.785 (0.1 to 45 deg)", mode_radius)};
  }
  if (!(outlier_share > 0.0 && outlier_share < 1.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("outlier_share = %g, expected above 0 and below 1", outlier_share)};
  }
  if (!(direction_smoothing >= 0.0 && direction_smoothing <= std::numbers::pi)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("direction_smoothing = %g rad, expected 0 to pi", direction_smoothing)};
  }
  return {};
}

Result<ConfusionModel> ConfusionModel::Make(const ContingencyTable& table,
                                            const SymmetryGroup& symmetry,
                                            const ConfusionModelParameters& parameters) {
  if (auto valid = parameters.Validate(); !valid) return valid.error();
  if (auto valid = CheckTrials(table); !valid) return valid.error();
  ConfusionModel model(static_cast<int>(table.directions.size()), symmetry, parameters);
  const DifferenceModes modes =
      FindDifferenceModes(table.directions, symmetry, parameters.mode_radius);
  SmoothedShares smoothed =
      Smooth(table.directions, modes, model.grid_, parameters.direction_smoothing);
  for (size_t i = 0; i < table.directions.size(); ++i) {
    if (table.directions[i].trials > 0) continue;
    ++model.num_unmeasured_;
    const size_t nearest =
        NearestMeasured(table.directions, model.grid_, model.grid_.Center(static_cast<int>(i)));
    smoothed.modes[i] = smoothed.modes[nearest];
    smoothed.missed[i] = smoothed.missed[nearest];
  }
  // Kept are modes that come up from some direction more than outliers do.
  std::vector<double> largest(modes.differences.size(), 0.0);
  for (const std::vector<Share>& shares : smoothed.modes) {
    for (const Share& share : shares) {
      double& most = largest[static_cast<size_t>(share.mode)];
      most = std::max(most, share.share);
    }
  }
  std::vector<int> kept(largest.size(), -1);
  for (size_t mode = 0; mode < largest.size(); ++mode) {
    if (mode > 0 && largest[mode] < parameters.outlier_share) continue;
    kept[mode] = model.num_modes();
    model.differences_.push_back(modes.differences[mode]);
  }
  for (std::vector<Share>& shares : smoothed.modes) {
    std::erase_if(shares, [&](const Share& share) {
      return kept[static_cast<size_t>(share.mode)] < 0 || share.share < kLeastShare;
    });
    for (Share& share : shares) share.mode = kept[static_cast<size_t>(share.mode)];
  }
  model.nothing_ = std::move(smoothed.missed);
  model.TakeShares(smoothed.modes);
  return model;
}

// Of directions whose nothing_ is set.
void ConfusionModel::TakeShares(const std::vector<std::vector<Share>>& shares) {
  const auto entropy_of = [](double p) { return p > 0.0 ? -p * std::log(p) : 0.0; };
  first_share_.push_back(0);
  for (size_t i = 0; i < shares.size(); ++i) {
    double detected = 0.0;
    double entropy = 0.0;
    for (const Share& share : shares[i]) {
      shares_.push_back(share);
      detected += share.share;
      entropy += entropy_of(WithOutliers(share.share));
    }
    const auto num_never = static_cast<double>(differences_.size() - shares[i].size());
    entropy += num_never * entropy_of(WithOutliers(0.0));
    first_share_.push_back(shares_.size());
    missed_.push_back(std::max(0.0, 1.0 - detected));
    entropy += entropy_of(WithOutliers(nothing_[i])) +
               entropy_of(WithOutliers(Scattered(static_cast<int>(i))));
    entropy_.push_back(entropy);
  }
}

const Eigen::Quaterniond& ConfusionModel::Difference(int mode) const {
  VANTAGE_CHECK(mode >= 0 && mode < num_modes(), Format("mode %d of %d", mode, num_modes()));
  return differences_[static_cast<size_t>(mode)];
}

int ConfusionModel::DirectionOf(const Eigen::Quaterniond& q_camera_object) const {
  return grid_.CellOf(ViewingDirection(q_camera_object));
}

std::span<const ConfusionModel::Share> ConfusionModel::SharesFrom(int direction) const {
  const size_t i = Checked(direction);
  return std::span(shares_).subspan(first_share_[i], first_share_[i + 1] - first_share_[i]);
}

double ConfusionModel::ShareFrom(int direction, int mode) const {
  const std::span<const Share> shares = SharesFrom(direction);
  const auto found = std::ranges::lower_bound(shares, mode, {}, &Share::mode);
  return found != shares.end() && found->mode == mode ? found->share : 0.0;
}

double ConfusionModel::Missed(int direction) const { return missed_[Checked(direction)]; }

double ConfusionModel::Scattered(int direction) const {
  const size_t i = Checked(direction);
  return std::max(0.0, missed_[i] - nothing_[i]);
}

double ConfusionModel::Entropy(int direction) const { return entropy_[Checked(direction)]; }

int ConfusionModel::ModeOf(const Eigen::Quaterniond& difference) const {
  int nearest = -1;
  double best = std::cos(0.5 * parameters_.mode_radius);
  for (int mode = 0; mode < num_modes(); ++mode) {
    const double nearness = SymmetricNearness(symmetry_, difference, Difference(mode));
    if (nearness < best || (nearness == best && nearest >= 0)) continue;
    best = nearness;
    nearest = mode;
  }
  return nearest;
}

size_t ConfusionModel::Checked(int direction) const {
  VANTAGE_CHECK(direction >= 0 && direction < num_directions(),
                Format("direction %d of %d", direction, num_directions()));
  return static_cast<size_t>(direction);
}

}  // namespace vantage
