#include "fusion/orientation_histogram.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "fusion/confidence_weight.h"
#include "fusion/verification_weight.h"

namespace vantage {
namespace {

struct Detected {
  Eigen::Quaterniond q;
  double w_v;
};

std::vector<Detected> RandomDetections(int count, Rng& rng) {
  std::vector<Detected> detections;
  for (int i = 0; i < count; ++i) detections.push_back({rng.Rotation(), rng.Uniform(0.1, 1.0)});
  return detections;
}

OrientationHistogram Fuse(const So3Grid& grid, const std::vector<Detected>& all, double sigma) {
  OrientationHistogram histogram(grid);
  for (const Detected& detected : all) histogram.Add(detected.q, sigma, detected.w_v);
  return histogram;
}

// Equations 2, 3 and 5 written down over every cell of the grid.
std::map<So3Grid::Cell, double> FuseDensely(const So3Grid& grid,
                                            const std::vector<Detected>& all,
                                            double sigma) {
  std::map<So3Grid::Cell, double> weights;
  const std::vector<So3Grid::Cell> cells = grid.ValidCells();
  for (const Detected& detected : all) {
    std::map<So3Grid::Cell, double> confidence;
    double mass = 0.0;
    for (const So3Grid::Cell cell : cells) {
      const double angle = GeodesicAngle(detected.q, grid.Representative(cell));
      if (angle > kConfidenceCutoff * sigma) continue;
      confidence[cell] = std::exp(-angle * angle / (2.0 * sigma * sigma));
      mass += confidence[cell] * grid.Area(cell);
    }
    for (const auto& [cell, weight] : confidence) weights[cell] += detected.w_v * weight / mass;
  }
  return weights;
}

TEST(ConfidenceWeight, IsEquation2) {
  EXPECT_DOUBLE_EQ(ConfidenceWeight(0.0, 0.1), 1.0);
  EXPECT_NEAR(ConfidenceWeight(0.1, 0.1), std::exp(-0.5), 1e-15);
  EXPECT_NEAR(ConfidenceWeight(-0.2, 0.1), std::exp(-2.0), 1e-15);
}

TEST(VerificationWeight, IsEquation4) {
  EXPECT_DOUBLE_EQ(VerificationWeight(0.0, 6.25e-6), 1.0);
  EXPECT_NEAR(VerificationWeight(6.25e-6, 6.25e-6), std::exp(-0.5), 1e-15);
  EXPECT_NEAR(VerificationWeight(1.25e-5, 6.25e-6), std::exp(-2.0), 1e-15);
  EXPECT_LT(VerificationWeight(1.0, 6.25e-6), 1e-300);
}

TEST(OrientationHistogram, EqualsTheDenseUpdate) {
  Rng rng(11);
  const So3Grid grid(8);
  for (const double sigma_deg : {5.0, 12.0, 40.0, 90.0}) {
    const std::vector<Detected> detections = RandomDetections(6, rng);
    const OrientationHistogram sparse = Fuse(grid, detections, sigma_deg * kDegree);
    const std::map<So3Grid::Cell, double> dense =
        FuseDensely(grid, detections, sigma_deg * kDegree);
    ASSERT_EQ(sparse.weights().Entries().size(), dense.size()) << sigma_deg;
    for (const auto& [cell, weight] : dense) {
      ASSERT_NEAR(sparse.Weight(cell), weight, 2e-6 * weight);
    }
  }
}

TEST(OrientationHistogram, BothQuaternionsOfAnOrientationGiveTheSame) {
  Rng rng(2);
  const So3Grid grid(16);
  for (int i = 0; i < 200; ++i) {
    Eigen::Quaterniond q = rng.Rotation();
    if (i % 2 == 0) q.w() = i % 4 == 0 ? 0.0 : 1e-12;
    q.normalize();
    const OrientationHistogram a = Fuse(grid, {{q, 1.0}}, 4.0 * kDegree);
    const OrientationHistogram b =
        Fuse(grid, {{Eigen::Quaterniond(-q.coeffs()), 1.0}}, 4.0 * kDegree);
    ASSERT_EQ(a.weights().Entries(), b.weights().Entries());
  }
}

TEST(OrientationHistogram, EveryDetectionAddsItsVerificationWeight) {
  Rng rng(3);
  const So3Grid grid(16);
  // Also narrower than the grid, where no representative is within reach.
  for (const double sigma_deg : {0.01, 0.5, 3.0, 20.0}) {
    OrientationHistogram histogram(grid);
    double expected = 0.0;
    for (const Detected& detected : RandomDetections(40, rng)) {
      histogram.Add(detected.q, sigma_deg * kDegree, detected.w_v);
      expected += detected.w_v;
      ASSERT_NEAR(histogram.Mass(), expected, 1e-9);
    }
  }
  OrientationHistogram corner(grid);  // Lies in a cell that meets the sphere there alone.
  corner.Add(Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5), 1e-6, 0.7);
  EXPECT_NEAR(corner.Mass(), 0.7, 1e-12);
}

TEST(OrientationHistogram, OrderDoesNotMatter) {
  Rng rng(4);
  const So3Grid grid(16);
  std::vector<Detected> detections = RandomDetections(5, rng);
  for (int i = 0; i < 20; ++i) {
    detections.push_back({detections.front().q * ExpSo3(0.05 * rng.UnitVector()), 0.5});
  }
  const OrientationHistogram forward = Fuse(grid, detections, 6.0 * kDegree);
  std::reverse(detections.begin(), detections.end());
  const OrientationHistogram backward = Fuse(grid, detections, 6.0 * kDegree);
  const std::vector<CellWeights::Entry> a = forward.weights().Entries();
  const std::vector<CellWeights::Entry> b = backward.weights().Entries();
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].cell, b[i].cell);
    ASSERT_NEAR(a[i].weight, b[i].weight, 1e-6F * a[i].weight);
  }
}

// Detections exactly where cells, octants and the half spheres of q and -q meet.
TEST(OrientationHistogram, OnTheSeamsOfTheGridADetectionKeepsItsMass) {
  const So3Grid grid(8);
  std::vector<Eigen::Quaterniond> seams;
  const std::vector<double> lattice = {-1.0, -0.75, -0.5, -0.125, -0.0, 0.0, 0.125, 0.5, 0.75, 1.0};
  for (const double x : lattice) {
    for (const double y : lattice) {
      for (const double z : lattice) {
        // On the lattice in three coordinates, and where the sphere allows it in the fourth.
        const double rest = 1.0 - x * x - y * y - z * z;
        if (rest < 0.0) continue;
        for (const double w : {std::sqrt(rest), -std::sqrt(rest)}) seams.emplace_back(w, x, y, z);
      }
    }
  }
  ASSERT_GT(seams.size(), 500U);
  for (const Eigen::Quaterniond& q : seams) {
    const Eigen::Quaterniond minus(-q.coeffs());
    const So3Grid::Cell cell = grid.CellOf(q);
    ASSERT_TRUE(grid.IsValid(cell)) << q.coeffs().transpose();
    ASSERT_EQ(grid.CellOf(minus), cell) << q.coeffs().transpose();
    for (const double sigma_deg : {0.001, 4.0, 10.0}) {
      const OrientationHistogram histogram = Fuse(grid, {{q, 1.0}}, sigma_deg * kDegree);
      ASSERT_NEAR(histogram.Mass(), 1.0, 1e-12);
      double mass = 0.0;
      for (const CellWeights::Entry& entry : histogram.weights().Entries()) {
        mass += static_cast<double>(entry.weight) * grid.Area(entry.cell);
      }
      ASSERT_NEAR(mass, 1.0, 1e-6);
      const OrientationHistogram same = Fuse(grid, {{minus, 1.0}}, sigma_deg * kDegree);
      ASSERT_EQ(same.weights().Entries(), histogram.weights().Entries());
    }
  }
}

TEST(OrientationHistogram, EntropyGrowsWithSpread) {
  const So3Grid grid(16);
  Rng rng(5);
  const Eigen::Quaterniond q = rng.Rotation();
  EXPECT_DOUBLE_EQ(OrientationHistogram(grid).Entropy(), 0.0);
  EXPECT_NEAR(Fuse(grid, {{q, 1.0}}, 1e-4).Entropy(), 0.0, 1e-12);
  const double narrow = Fuse(grid, {{q, 1.0}}, 4.0 * kDegree).Entropy();
  const double wide = Fuse(grid, {{q, 1.0}}, 12.0 * kDegree).Entropy();
  EXPECT_GT(wide, narrow);
  // Volume of a Gaussian's support grows with the third power.
  EXPECT_NEAR(wide - narrow, 3.0 * std::log(3.0), 0.4);
  // Two equal modes are one bit more.
  const Eigen::Quaterniond opposite = q * ExpSo3(Eigen::Vector3d(0.0, 0.0, 2.0));
  const double two = Fuse(grid, {{q, 1.0}, {opposite, 1.0}}, 4.0 * kDegree).Entropy();
  EXPECT_NEAR(two - narrow, std::log(2.0), 0.2);
}

}  // namespace
}  // namespace vantage
