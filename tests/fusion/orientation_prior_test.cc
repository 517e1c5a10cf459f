#include "fusion/orientation_prior.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "fusion/orientation_filter.h"
#include "fusion/orientation_histogram.h"

namespace vantage {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double MeanDensity(const So3Grid& grid, const OrientationPrior& prior) {
  double mean = 0.0;
  for (const So3Grid::Cell cell : grid.ValidCells()) {
    mean += grid.Area(cell) * prior.Density(grid.Ordinal(cell));
  }
  return mean;
}

double DensityAt(const So3Grid& grid, const OrientationPrior& prior, const Eigen::Quaterniond& q) {
  return prior.Density(grid.Ordinal(grid.CellOf(q)));
}

// The mixture written down over all cells, each Gaussian cut off at three sigma and normalized.
std::vector<double> Mixture(const So3Grid& grid,
                            const std::vector<LikelyPose>& poses,
                            double uniform_share) {
  std::vector<double> density(static_cast<size_t>(grid.num_cells()), uniform_share);
  double weights = 0.0;
  for (const LikelyPose& pose : poses) weights += pose.weight;
  for (const LikelyPose& pose : poses) {
    std::vector<double> gaussian(density.size(), 0.0);
    double mass = 0.0;
    for (const So3Grid::Cell cell : grid.ValidCells()) {
      const double d = GeodesicAngle(grid.Representative(cell), pose.q_world_object) / pose.spread;
      if (d > 3.0) continue;
      gaussian[static_cast<size_t>(grid.Ordinal(cell))] = std::exp(-0.5 * d * d);
      mass += grid.Area(cell) * std::exp(-0.5 * d * d);
    }
    for (size_t i = 0; i < density.size(); ++i) {
      density[i] += (1.0 - uniform_share) * pose.weight / weights * gaussian[i] / mass;
    }
  }
  return density;
}

TEST(OrientationPrior, IsUniformByDefault) {
  const OrientationPrior prior;
  EXPECT_TRUE(prior.is_uniform());
  EXPECT_EQ(prior.Density(0), 1.0);
  EXPECT_EQ(prior.Density(123456), 1.0);
  EXPECT_EQ(prior.density_elsewhere(), 1.0);
}

TEST(OrientationPrior, LikelyPosesAreAMixtureOfGaussians) {
  const So3Grid grid(8);
  Rng rng(1);
  for (const double uniform_share : {0.0, 0.2, 0.9}) {
    std::vector<LikelyPose> poses;
    for (int i = 0; i < 4; ++i) {
      poses.push_back({rng.Rotation(), rng.Uniform(8.0, 40.0) * kDegree, rng.Uniform(0.0, 5.0)});
    }
    poses.push_back(poses.front());  // One pose twice counts twice.
    const auto prior = OrientationPrior::AroundPoses(grid, poses, uniform_share);
    ASSERT_TRUE(prior.ok()) << prior.error().message;
    EXPECT_FALSE(prior->is_uniform());
    EXPECT_NEAR(MeanDensity(grid, *prior), 1.0, 1e-6);
    EXPECT_EQ(prior->density_elsewhere(), uniform_share);
    const std::vector<double> expected = Mixture(grid, poses, uniform_share);
    for (int32_t i = 0; i < grid.num_cells(); ++i) {
      const double density = expected[static_cast<size_t>(i)];
      ASSERT_NEAR(prior->Density(i), density, 2e-6 * density) << i;
    }
  }
}

TEST(OrientationPrior, WithoutPosesTheBackgroundIsAll) {
  const So3Grid grid(8);
  const auto none = OrientationPrior::AroundPoses(grid, {}, 0.3);
  ASSERT_TRUE(none.ok());
  EXPECT_NEAR(none->Density(17), 1.0, 1e-12);
  const std::vector<LikelyPose> weightless = {{Eigen::Quaterniond::Identity(), 0.1, 0.0}};
  const auto background = OrientationPrior::AroundPoses(grid, weightless, 0.01);
  ASSERT_TRUE(background.ok());
  EXPECT_NEAR(DensityAt(grid, *background, Eigen::Quaterniond::Identity()), 1.0, 1e-12);
  const std::vector<LikelyPose> pose = {{Eigen::Quaterniond::Identity(), 0.1, 2.0}};
  const auto all_uniform = OrientationPrior::AroundPoses(grid, pose, 1.0);
  ASSERT_TRUE(all_uniform.ok());
  EXPECT_NEAR(MeanDensity(grid, *all_uniform), 1.0, 1e-9);
  EXPECT_NEAR(DensityAt(grid, *all_uniform, Eigen::Quaterniond::Identity()), 1.0, 1e-12);
}

TEST(OrientationPrior, CellsAreInProportionToTheirWeights) {
  const So3Grid grid(8);
  Rng rng(2);
  std::vector<So3Grid::Cell> cells;
  grid.CellsAt(0, grid.num_cells(), &cells);
  for (const double elsewhere : {0.0, 0.3, 2.0}) {
    std::vector<CellWeights::Entry> listed;
    std::vector<double> wanted(cells.size(), elsewhere);
    for (size_t i = 0; i < cells.size(); i += 3) {
      const auto weight = i % 2 == 0 ? 0.0F : static_cast<float>(rng.Uniform(0.0, 4.0));
      listed.push_back({cells[i], weight});
      wanted[i] = static_cast<double>(weight);
    }
    double total = 0.0;
    for (size_t i = 0; i < cells.size(); ++i) total += wanted[i] * grid.Area(cells[i]);
    const auto prior = OrientationPrior::OnCells(grid, listed, elsewhere);
    ASSERT_TRUE(prior.ok()) << prior.error().message;
    EXPECT_NEAR(MeanDensity(grid, *prior), 1.0, 1e-6);
    for (size_t i = 0; i < cells.size(); ++i) {
      const double density = prior->Density(static_cast<int32_t>(i));
      ASSERT_NEAR(density, wanted[i] / total, 1e-6 * (1.0 + elsewhere / total));
      if (wanted[i] == 0.0) {
        ASSERT_EQ(density, 0.0);  // Impossible, not just unlikely.
      }
      ASSERT_GE(density, 0.0);
    }
  }
}

TEST(OrientationPrior, CellsWithoutMassAreRefused) {
  const So3Grid grid(4);
  std::vector<CellWeights::Entry> all;
  for (const So3Grid::Cell cell : grid.ValidCells()) all.push_back({cell, 0.0F});
  EXPECT_FALSE(OrientationPrior::OnCells(grid, all, 1.0).ok());
  all.pop_back();
  EXPECT_FALSE(OrientationPrior::OnCells(grid, all, 0.0).ok());
  EXPECT_FALSE(OrientationPrior::OnCells(grid, {}, 0.0).ok());
  EXPECT_TRUE(OrientationPrior::OnCells(grid, {}, 0.1).ok());
}

TEST(OrientationPrior, BadCellsAreRefused) {
  const So3Grid grid(8);
  const So3Grid::Cell good = grid.ValidCells().front();
  const auto refused = [&](const CellWeights::Entry& entry, double elsewhere, const char* part) {
    const std::vector<CellWeights::Entry> listed = {{grid.ValidCells().back(), 1.0F}, entry};
    const auto prior = OrientationPrior::OnCells(grid, listed, elsewhere);
    return !prior.ok() && prior.error().message.find(part) != std::string::npos;
  };
  EXPECT_FALSE(refused({good, 1.0F}, 0.0, ""));
  for (const So3Grid::Cell cell : {-1, 0, 8 * 4096, std::numeric_limits<int32_t>::max()}) {
    EXPECT_TRUE(refused({cell, 1.0F}, 0.0, "none of the grid")) << cell;
  }
  EXPECT_TRUE(refused({good, -0.5F}, 1.0, "not negative"));
  EXPECT_TRUE(refused({good, std::numeric_limits<float>::quiet_NaN()}, 1.0, "not negative"));
  EXPECT_TRUE(refused({good, std::numeric_limits<float>::infinity()}, 1.0, "finite"));
  EXPECT_TRUE(refused({good, 1.0F}, -1.0, "elsewhere"));
  EXPECT_TRUE(refused({good, 1.0F}, NAN, "elsewhere"));
  EXPECT_TRUE(refused({good, 1.0F}, kInfinity, "elsewhere"));
  EXPECT_TRUE(refused({grid.ValidCells().back(), 0.0F}, 1.0, "listed twice"));
}

TEST(OrientationPrior, BadPosesAreRefused) {
  const So3Grid grid(8);
  const auto ok = [&](const LikelyPose& pose, double uniform_share) {
    const std::vector<LikelyPose> poses = {{Eigen::Quaterniond::Identity(), 0.2, 1.0}, pose};
    return OrientationPrior::AroundPoses(grid, poses, uniform_share).ok();
  };
  const Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  EXPECT_TRUE(ok({q, 0.1, 1.0}, 0.1));
  EXPECT_TRUE(ok({q, std::numbers::pi, 0.0}, 0.0));
  for (const double spread : {0.0, -0.1, 4.0, kInfinity, static_cast<double>(NAN)}) {
    EXPECT_FALSE(ok({q, spread, 1.0}, 0.1)) << spread;
  }
  for (const double weight : {-1e-9, kInfinity, static_cast<double>(NAN)}) {
    EXPECT_FALSE(ok({q, 0.1, weight}, 0.1)) << weight;
  }
  for (const double uniform_share : {-0.1, 1.1, kInfinity, static_cast<double>(NAN)}) {
    EXPECT_FALSE(ok({q, 0.1, 1.0}, uniform_share)) << uniform_share;
  }
  EXPECT_FALSE(ok({Eigen::Quaterniond(0.0, 0.0, 0.0, 0.0), 0.1, 1.0}, 0.1));
  EXPECT_FALSE(ok({Eigen::Quaterniond(2.0, 0.0, 0.0, 0.0), 0.1, 1.0}, 0.1));
  EXPECT_FALSE(ok({Eigen::Quaterniond(NAN, 0.0, 0.0, 0.0), 0.1, 1.0}, 0.1));
  EXPECT_FALSE(ok({Eigen::Quaterniond(1.0, kInfinity, 0.0, 0.0), 0.1, 1.0}, 0.1));
  const double huge = std::numeric_limits<double>::max();
  const std::vector<LikelyPose> overflow = {{q, 0.1, huge}, {q, 0.1, huge}};
  EXPECT_FALSE(OrientationPrior::AroundPoses(grid, overflow, 0.1).ok());
  const std::vector<LikelyPose> weightless = {{q, 0.1, 0.0}};
  EXPECT_FALSE(OrientationPrior::AroundPoses(grid, weightless, 0.0).ok());
  EXPECT_FALSE(OrientationPrior::AroundPoses(grid, {}, 0.0).ok());
}

// Two detections of equal weight; only what is known beforehand tells which one is right.
TEST(OrientationPrior, DecidesBetweenEqualPeaks) {
  const So3Grid grid(16);
  Rng rng(3);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Quaterniond a = rng.Rotation();
    const Eigen::Quaterniond b = a * ExpSo3(rng.Uniform(1.0, 3.0) * rng.UnitVector());
    for (const Eigen::Quaterniond& likely : {a, b}) {
      const std::vector<LikelyPose> poses = {{likely, 20.0 * kDegree, 1.0}};
      const auto prior = OrientationPrior::AroundPoses(grid, poses, 0.5);
      ASSERT_TRUE(prior.ok());
      OrientationFilter filter(grid, {}, {.prior = *prior});
      filter.Fuse({{a, 1e-6}, {b, 1e-6}});
      const auto q_f = filter.Estimate();
      ASSERT_TRUE(q_f.ok());
      ASSERT_LT(GeodesicAngle(*q_f, likely), 1.0 * kDegree);
    }
  }
}

TEST(OrientationPrior, WhatItExcludesHasNoWeight) {
  const So3Grid grid(8);
  Rng rng(4);
  const Eigen::Quaterniond possible = rng.Rotation();
  const Eigen::Quaterniond excluded = possible * ExpSo3(2.0 * rng.UnitVector());
  // Excluded by the cells about it, all others being alike, and by a prior that is 0 far away.
  std::vector<So3Grid::NearCell> near;
  grid.CellsWithin(excluded, 40.0 * kDegree, &near);
  std::vector<CellWeights::Entry> cells;
  for (const So3Grid::NearCell& cell : near) cells.push_back({cell.cell, 0.0F});
  const std::vector<LikelyPose> poses = {{possible, 15.0 * kDegree, 1.0}};
  for (const auto& prior : {OrientationPrior::OnCells(grid, cells, 0.3),
                            OrientationPrior::AroundPoses(grid, poses, 0.0)}) {
    ASSERT_TRUE(prior.ok()) << prior.error().message;
    OrientationHistogram histogram(grid, *prior);
    for (int i = 0; i < 3; ++i) histogram.Add(excluded, 8.0 * kDegree, 1.0);
    histogram.Vote(excluded, 1.0);
    EXPECT_EQ(histogram.Mass(), 0.0);
    EXPECT_TRUE(histogram.empty());
    for (const FinalOrientation final_orientation : kFinalOrientations) {
      OrientationFilter filter(grid, {.final_orientation = final_orientation}, {.prior = *prior});
      filter.Fuse({{excluded, 0.0}, {excluded, 0.0}});
      EXPECT_FALSE(filter.Estimate().ok()) << Name(final_orientation);
      EXPECT_FALSE(filter.converged());
      ASSERT_TRUE(filter.Add({possible, 0.0}).ok());
      const auto q_f = filter.Estimate();
      ASSERT_TRUE(q_f.ok()) << Name(final_orientation);
      EXPECT_LT(GeodesicAngle(*q_f, possible), 12.0 * kDegree) << Name(final_orientation);
    }
  }
}

}  // namespace
}  // namespace vantage
