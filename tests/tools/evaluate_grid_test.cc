#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "tools/evaluate/grid_statistics.h"
#include "tools/evaluate/paper_figures.h"

namespace vantage {
namespace {

struct Cells {
  std::vector<Eigen::Vector4d> representatives;  // Of cells that have an area.
  std::vector<double> angles_deg;                // Of all representatives from the identity.
};

Cells CellsOf(const So3Grid& grid) {
  Cells cells;
  for (const So3Grid::Cell cell : grid.ValidCells()) {
    const Eigen::Quaterniond q = grid.Representative(cell);
    cells.angles_deg.push_back(GeodesicAngle(q, Eigen::Quaterniond::Identity()) / kDegree);
    if (grid.Area(cell) > 0.0) cells.representatives.push_back(q.coeffs());
  }
  return cells;
}

double NearestNeighborDeg(const std::vector<Eigen::Vector4d>& all, size_t own) {
  double largest = 0.0;
  for (size_t i = 0; i < all.size(); ++i) {
    if (i != own) largest = std::max(largest, std::abs(all[own].dot(all[i])));
  }
  return 2.0 * std::acos(std::min(1.0, largest)) / kDegree;
}

struct Moments {
  double mean = 0.0;
  double deviation = 0.0;
};

Moments MomentsOf(const std::vector<double>& values) {
  const auto count = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
  double squares = 0.0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return {mean, std::sqrt(squares / count)};
}

int64_t Total(const BinCounts& bins) {
  return std::accumulate(bins.counts.begin(), bins.counts.end(), int64_t{0});
}

// Bins of the same width by hand; values on the edge of two may fall into either.
void ExpectBins(const BinCounts& bins, const std::vector<double>& values) {
  EXPECT_EQ(Total(bins), static_cast<int64_t>(values.size()));
  int64_t below = 0;
  for (size_t bin = 0; bin + 1 < bins.counts.size(); ++bin) {
    below += bins.counts[bin];
    const double edge = bins.bin_width_deg * static_cast<double>(bin + 1);
    const auto surely = [&](double margin) {
      return std::count_if(
          values.begin(), values.end(), [&](double value) { return value < edge + margin; });
    };
    EXPECT_GE(below, surely(-1e-4)) << bin;
    EXPECT_LE(below, surely(1e-4)) << bin;
  }
}

TEST(GridStatistics, EqualComparingAllPairs) {
  for (const int k : {4, 8}) {
    const GridMeasurement measured = MeasureGrid(k);
    const Cells cells = CellsOf(So3Grid(k));
    std::vector<double> distances;
    for (size_t i = 0; i < cells.representatives.size(); ++i) {
      distances.push_back(NearestNeighborDeg(cells.representatives, i));
    }
    const Moments expected = MomentsOf(distances);
    EXPECT_EQ(measured.statistics.k, k);
    EXPECT_NEAR(measured.statistics.mean_deg, expected.mean, 1e-4);
    EXPECT_NEAR(measured.statistics.deviation_deg, expected.deviation, 1e-4);
    ExpectBins(measured.distances, distances);
    ExpectBins(measured.angles, cells.angles_deg);
  }
}

TEST(GridStatistics, EqualComparingSomeWithAll) {
  const GridMeasurement measured = MeasureGrid(16);
  const Cells cells = CellsOf(So3Grid(16));
  ExpectBins(measured.angles, cells.angles_deg);
  Rng rng(1);
  std::vector<double> distances;
  for (int i = 0; i < 1500; ++i) {
    const uint32_t own = rng.Below(static_cast<uint32_t>(cells.representatives.size()));
    distances.push_back(NearestNeighborDeg(cells.representatives, own));
  }
  const Moments sampled = MomentsOf(distances);
  const double standard_error =
      sampled.deviation / std::sqrt(static_cast<double>(distances.size()));
  EXPECT_NEAR(measured.statistics.mean_deg, sampled.mean, 4.0 * standard_error);
  EXPECT_NEAR(measured.statistics.deviation_deg, sampled.deviation, 4.0 * standard_error);
}

// All pairs at the paper's finer grids. Exchanging coordinates and signs maps the representatives
// onto themselves, so that one of each kind stands for all: at k = 32 3,364 are compared with
// 548,496. Single precision tells angles of 2 degrees apart to 1e-3.
TEST(GridStatistics, EqualComparingOneOfEachKindWithAll) {
  for (const int k : {16, 32}) {
    const Cells cells = CellsOf(So3Grid(k));
    std::map<std::array<int64_t, 4>, std::pair<size_t, int64_t>> kinds;  // First one, how many.
    Eigen::Matrix<float, Eigen::Dynamic, 4> all(
        static_cast<Eigen::Index>(cells.representatives.size()), 4);
    for (size_t i = 0; i < cells.representatives.size(); ++i) {
      const Eigen::Vector4d& q = cells.representatives[i];
      all.row(static_cast<Eigen::Index>(i)) = q.transpose().cast<float>();
      std::array<int64_t, 4> kind{};
      for (size_t axis = 0; axis < 4; ++axis) {
        kind[axis] = std::llround(1e6 * std::abs(q[static_cast<Eigen::Index>(axis)]));
      }
      std::sort(kind.begin(), kind.end());
      ++kinds.try_emplace(kind, i, 0).first->second.second;
    }
    double sum = 0.0;
    double squares = 0.0;
    double count = 0.0;
    for (const auto& [kind, members] : kinds) {
      const auto own = static_cast<Eigen::Index>(members.first);
      Eigen::ArrayXf dots = (all * all.row(own).transpose()).array().abs();
      dots[own] = 0.0F;
      Eigen::Index nearest = 0;
      dots.maxCoeff(&nearest);
      const double dot = std::abs(cells.representatives[static_cast<size_t>(nearest)].dot(
          cells.representatives[members.first]));
      const double angle = 2.0 * std::acos(std::min(1.0, dot)) / kDegree;
      const auto num_members = static_cast<double>(members.second);
      sum += num_members * angle;
      squares += num_members * angle * angle;
      count += num_members;
    }
    const double mean = sum / count;
    const GridStatistics measured = MeasureGrid(k).statistics;
    EXPECT_EQ(static_cast<size_t>(count), cells.representatives.size());
    EXPECT_NEAR(measured.mean_deg, mean, 1e-3) << k;
    EXPECT_NEAR(measured.deviation_deg, std::sqrt(squares / count - mean * mean), 1e-3) << k;
  }
}

TEST(GridStatistics, AreThoseOfThePapersTable) {
  ASSERT_GE(PaperGrids().size(), 3U);
  for (const PaperGrid& paper : PaperGrids()) {
    const GridStatistics measured = MeasureGrid(paper.k).statistics;
    EXPECT_EQ(measured.num_cells, paper.num_cells) << paper.k;
    EXPECT_NEAR(measured.mean_deg, paper.mean_deg, 0.05) << paper.k;
    EXPECT_NEAR(measured.deviation_deg, paper.deviation_deg, 0.05) << paper.k;
    EXPECT_LT(measured.megabytes, paper.megabytes) << paper.k;
    EXPECT_GT(measured.megabytes, 4e-6 * static_cast<double>(paper.num_cells)) << paper.k;
  }
}

// A representative outside of its own cell would be its own neighbor, at no distance.
TEST(GridStatistics, NoCellIsItsOwnNeighbor) {
  for (const int k : {2, 3, 5, 13, 32}) {
    const GridMeasurement measured = MeasureGrid(k);
    EXPECT_EQ(measured.distances.counts.front(), 0) << k;
    EXPECT_GT(measured.statistics.mean_deg, 60.0 / k) << k;
  }
}

}  // namespace
}  // namespace vantage
