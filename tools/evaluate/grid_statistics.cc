#include "tools/evaluate/grid_statistics.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <vector>

#include "common/so3.h"
#include "fusion/cell_weights.h"

namespace vantage {
namespace {

// Representatives that are alike but for the order and the signs of their coordinates.
struct Kind {
  Eigen::Quaterniond representative;
  int64_t num_cells;
};

Eigen::Quaterniond Representative(const So3Grid& grid, std::array<int, 4> lower) {
  const int k = grid.k();
  const int xyz = ((lower[0] + k) * 2 * k + lower[1] + k) * 2 * k + lower[2] + k;
  return grid.Representative(xyz * k + lower[3]);
}

std::vector<Kind> KindsOf(const So3Grid& grid) {
  std::vector<Kind> kinds;
  const int k = grid.k();
  for (int d = 0; d < k; ++d) {
    for (int c = 0; c <= d; ++c) {
      for (int b = 0; b <= c; ++b) {
        for (int a = 0; a <= b; ++a) {
          std::array<int, 4> lower = {a, b, c, d};
          const int xyz = ((a + k) * 2 * k + b + k) * 2 * k + c + k;
          if (!grid.IsValid(xyz * k + d) || grid.Area(xyz * k + d) <= 0.0) continue;
          int64_t orders = 0;
          do ++orders;
          while (std::next_permutation(lower.begin(), lower.end()));
          kinds.push_back({Representative(grid, lower), 8 * orders});
        }
      }
    }
  }
  return kinds;
}

double NearestNeighbor(const So3Grid& grid, const Eigen::Quaterniond& q) {
  const So3Grid::Cell own = grid.CellOf(q);
  std::vector<So3Grid::NearCell> near;
  for (double radius = 2.0 / grid.k();; radius *= 1.5) {
    grid.CellsWithin(q, radius, &near);
    double nearest = std::numeric_limits<double>::infinity();
    for (const So3Grid::NearCell& cell : near) {
      if (cell.cell == own || cell.area <= 0.0) continue;
      nearest = std::min(nearest, GeodesicAngle(grid.Representative(cell.cell), q));
    }
    if (nearest <= radius) return nearest;
  }
}

void Count(double value, int64_t amount, BinCounts* bins) {
  const auto bin = static_cast<size_t>(value / bins->bin_width_deg);
  bins->counts[std::min(bin, bins->counts.size() - 1)] += amount;
}

// Angles from the identity: the largest coordinate may be any, so all orders of a kind count.
void CountAngles(const So3Grid& grid, BinCounts* bins) {
  std::vector<So3Grid::Cell> cells;
  constexpr int32_t kBlock = 4096;
  for (int32_t first = 0; first < grid.num_cells(); first += kBlock) {
    grid.CellsAt(first, std::min(kBlock, grid.num_cells() - first), &cells);
    for (const So3Grid::Cell cell : cells) {
      const double w = std::abs(grid.Representative(cell).w());
      Count(2.0 * std::acos(std::min(1.0, w)) / kDegree, 1, bins);
    }
  }
}

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

GridMeasurement MeasureGrid(int k) {
  GridMeasurement measurement;
  GridStatistics& statistics = measurement.statistics;
  const auto start = std::chrono::steady_clock::now();
  const So3Grid grid(k);
  statistics.build_seconds = SecondsSince(start);
  statistics.k = k;
  statistics.num_cells = grid.num_cells();
  CellWeights weights(grid);
  for (int32_t i = 0; i < grid.num_cells(); ++i) weights.Add(i, 1.0F);
  statistics.megabytes = 1e-6 * static_cast<double>(grid.bytes() + weights.bytes());

  const std::vector<Kind> kinds = KindsOf(grid);
  std::vector<double> distances;
  double count = 0.0;
  double sum = 0.0;
  double square_sum = 0.0;
  for (const Kind& kind : kinds) {
    const double distance = NearestNeighbor(grid, kind.representative) / kDegree;
    const auto num_cells = static_cast<double>(kind.num_cells);
    distances.push_back(distance);
    count += num_cells;
    sum += num_cells * distance;
    square_sum += num_cells * distance * distance;
  }
  statistics.mean_deg = sum / count;
  statistics.deviation_deg =
      std::sqrt(std::max(0.0, square_sum / count - statistics.mean_deg * statistics.mean_deg));

  measurement.distances = {statistics.mean_deg / 20.0, std::vector<int64_t>(40, 0)};
  for (size_t i = 0; i < kinds.size(); ++i) {
    Count(distances[i], kinds[i].num_cells, &measurement.distances);
  }
  measurement.angles = {2.0, std::vector<int64_t>(90, 0)};
  CountAngles(grid, &measurement.angles);
  return measurement;
}

}  // namespace vantage
