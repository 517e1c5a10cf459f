#include "fusion/confusion/difference_modes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <unordered_map>

#include "common/so3.h"
#include "fusion/confusion/symmetric_nearness.h"

namespace vantage {
namespace {

// Differences whose rotation vectors share a cube.
struct Bin {
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  int64_t count = 0;
  Eigen::Quaterniond mean;
  std::vector<int> near_modes;  // That a difference in the bin may be of.
};

struct Binned {
  std::vector<Bin> bins;
  std::vector<int> bin_of_entry;  // Of all directions' differences, one after the other.
  std::vector<Eigen::Quaterniond> entries;
};

double NearnessOfAngle(double angle) {
  return std::cos(0.5 * std::min(angle, 2.0 * std::numbers::pi));
}

Binned SortIntoBins(std::span<const DirectionTrials> directions, double width) {
  Binned binned;
  std::unordered_map<uint64_t, int> bin_of_cube;
  const double cubes_per_step = DifferenceCount::kStepDeg * kDegree / width;
  for (const DirectionTrials& direction : directions) {
    for (const DifferenceCount& difference : direction.differences) {
      uint64_t cube = 0;
      for (const int16_t step : difference.steps) {
        const auto along = static_cast<int64_t>(std::floor(step * cubes_per_step + 0.5));
        cube = (cube << 21) ^ (static_cast<uint64_t>(along) & 0x1FFFFFU);
      }
      const auto [found, is_new] =
          bin_of_cube.try_emplace(cube, static_cast<int>(binned.bins.size()));
      if (is_new) binned.bins.emplace_back();
      Bin& bin = binned.bins[static_cast<size_t>(found->second)];
      const Eigen::Quaterniond q = difference.Difference();
      const double sign = bin.sum.dot(q.coeffs()) < 0.0 ? -1.0 : 1.0;
      bin.sum += sign * difference.count * q.coeffs();
      bin.count += difference.count;
      binned.bin_of_entry.push_back(found->second);
      binned.entries.push_back(q);
    }
  }
  for (Bin& bin : binned.bins) bin.mean = Eigen::Quaterniond(bin.sum.normalized());
  return binned;
}

// Mean of the bins in reach of q, each by its equivalent nearest to q; q where there are none.
Eigen::Quaterniond MeanNear(const Eigen::Quaterniond& q,
                            const std::vector<Bin>& bins,
                            const std::vector<int>& left,
                            const SymmetryGroup& symmetry,
                            double reach) {
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  for (const int index : left) {
    const Bin& bin = bins[static_cast<size_t>(index)];
    if (SymmetricNearness(symmetry, bin.mean, q) < reach) continue;
    const Eigen::Vector4d near = NearestEquivalent(symmetry, bin.mean, q).coeffs();
    sum += (near.dot(q.coeffs()) < 0.0 ? -1.0 : 1.0) * static_cast<double>(bin.count) * near;
  }
  return sum.norm() > 0.0 ? Eigen::Quaterniond(sum.normalized()) : q;
}

class ModeSearch {
 public:
  ModeSearch(const std::vector<Bin>& bins, const SymmetryGroup& symmetry, double radius)
      : bins_(bins), symmetry_(symmetry), reach_(NearnessOfAngle(radius)), left_(bins.size()) {
    std::iota(left_.begin(), left_.end(), 0);
    std::stable_sort(left_.begin(), left_.end(), [&](int a, int b) {
      return bins_[static_cast<size_t>(a)].count > bins_[static_cast<size_t>(b)].count;
    });
  }

  std::vector<Eigen::Quaterniond> Find() {
    constexpr int kMostAttempts = 4 * kMostModes;
    Take(Eigen::Quaterniond::Identity());
    std::vector<Eigen::Quaterniond> modes = {Eigen::Quaterniond::Identity()};
    for (int i = 0; i < kMostAttempts && !left_.empty(); ++i) {
      if (static_cast<int>(modes.size()) == kMostModes) break;
      const Eigen::Quaterniond heaviest = bins_[static_cast<size_t>(left_.front())].mean;
      Eigen::Quaterniond q = heaviest;
      for (int round = 0; round < 2; ++round) {
        q = MeanNear(q, bins_, left_, symmetry_, reach_);
      }
      const bool apart = std::ranges::none_of(modes, [&](const Eigen::Quaterniond& mode) {
        return SymmetricNearness(symmetry_, mode, q) >= reach_;
      });
      if (!apart || SymmetricNearness(symmetry_, heaviest, q) < reach_) q = heaviest;
      if (Take(q) < kFewestDetections) continue;
      modes.push_back(NearestEquivalent(symmetry_, q, Eigen::Quaterniond::Identity()));
    }
    return modes;
  }

 private:
  // Takes the bins about q out of those left; how many detections they are.
  int64_t Take(const Eigen::Quaterniond& q) {
    int64_t taken = 0;
    std::erase_if(left_, [&](int index) {
      const Bin& bin = bins_[static_cast<size_t>(index)];
      if (SymmetricNearness(symmetry_, bin.mean, q) < reach_) return false;
      taken += bin.count;
      return true;
    });
    return taken;
  }

  const std::vector<Bin>& bins_;
  const SymmetryGroup& symmetry_;
  double reach_;
  std::vector<int> left_;  // Bins in no mode, heaviest first.
};

}  // namespace

DifferenceModes FindDifferenceModes(std::span<const DirectionTrials> directions,
                                    const SymmetryGroup& symmetry,
                                    double radius) {
  const double width = 0.5 * radius;
  Binned binned = SortIntoBins(directions, width);
  DifferenceModes modes;
  modes.differences = ModeSearch(binned.bins, symmetry, radius).Find();
  const int num_modes = static_cast<int>(modes.differences.size());
  const double reach = NearnessOfAngle(radius);
  const double reach_of_bin = NearnessOfAngle(radius + std::sqrt(3.0) * width);
  for (Bin& bin : binned.bins) {
    for (int mode = 0; mode < num_modes; ++mode) {
      const Eigen::Quaterniond& difference = modes.differences[static_cast<size_t>(mode)];
      if (SymmetricNearness(symmetry, bin.mean, difference) >= reach_of_bin) {
        bin.near_modes.push_back(mode);
      }
    }
  }
  size_t entry = 0;
  std::vector<int> counts(static_cast<size_t>(num_modes), 0);
  for (const DirectionTrials& direction : directions) {
    for (const DifferenceCount& difference : direction.differences) {
      const Eigen::Quaterniond& q = binned.entries[entry];
      int nearest = -1;
      double best = reach;
      for (const int mode :
           binned.bins[static_cast<size_t>(binned.bin_of_entry[entry])].near_modes) {
        const double nearness =
            SymmetricNearness(symmetry, q, modes.differences[static_cast<size_t>(mode)]);
        if (nearness < best || (nearness == best && nearest >= 0)) continue;
        best = nearness;
        nearest = mode;
      }
      if (nearest >= 0) counts[static_cast<size_t>(nearest)] += difference.count;
      ++entry;
    }
    std::vector<DifferenceModes::Count>& of_direction = modes.counts.emplace_back();
    for (int mode = 0; mode < num_modes; ++mode) {
      int& count = counts[static_cast<size_t>(mode)];
      if (count > 0) of_direction.push_back({mode, count});
      count = 0;
    }
  }
  return modes;
}

}  // namespace vantage
