#include "fusion/bayesian_histogram.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/rng.h"
#include "fusion/orientation_histogram.h"

namespace vantage {
namespace {

OrientationView Seen(const Eigen::Quaterniond& truth, double sigma, Rng& rng) {
  const Eigen::Vector3d error(rng.Normal(), rng.Normal(), rng.Normal());
  return {truth * ExpSo3(sigma * error), 1e-6};
}

// A distribution on all cells, by the rules of probability written down.
class DensePosterior {
 public:
  DensePosterior(const So3Grid& grid, const OrientationPrior& prior) {
    std::vector<So3Grid::Cell> cells;
    grid.CellsAt(0, grid.num_cells(), &cells);
    for (const So3Grid::Cell cell : cells) {
      representatives_.push_back(grid.Representative(cell));
      areas_.push_back(grid.Area(cell));
      prior_.push_back(prior.Density(grid.Ordinal(cell)));
    }
    densities_ = prior_;
  }

  // Bayes' rule with a truncated Gaussian and a uniform share of outliers as likelihood.
  void Update(const Eigen::Quaterniond& q, double sigma, double outlier_share) {
    const std::vector<double> gaussian = Gaussian(q, sigma);
    double sum = 0.0;
    for (size_t i = 0; i < densities_.size(); ++i) {
      densities_[i] *= (1.0 - outlier_share) * gaussian[i] + outlier_share;
      sum += densities_[i] * areas_[i];
    }
    for (double& density : densities_) density /= sum;
  }

  // What an untouched cell has of its prior density.
  [[nodiscard]] double Untouched() const {
    double lowest = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i < prior_.size(); ++i) {
      lowest = std::min(lowest, densities_[i] / prior_[i]);
    }
    return lowest;
  }
  // Every cell's mass above `untouched` of the prior spread by a Gaussian; the prior stays.
  void Move(double sigma, double untouched) {
    std::vector<double> moved(densities_.size());
    for (size_t i = 0; i < moved.size(); ++i) moved[i] = untouched * prior_[i];
    for (size_t i = 0; i < densities_.size(); ++i) {
      const double mass = (densities_[i] - untouched * prior_[i]) * areas_[i];
      if (std::abs(mass) < 1e-17) continue;  // No more than rounding.
      const std::vector<double> gaussian = Gaussian(representatives_[i], sigma);
      for (size_t j = 0; j < moved.size(); ++j) moved[j] += mass * gaussian[j];
    }
    densities_ = moved;
  }

  [[nodiscard]] const std::vector<double>& densities() const { return densities_; }

 private:
  [[nodiscard]] std::vector<double> Gaussian(const Eigen::Quaterniond& q, double sigma) const {
    std::vector<double> gaussian(areas_.size(), 0.0);
    double mass = 0.0;
    for (size_t i = 0; i < areas_.size(); ++i) {
      const double dot = std::abs(q.coeffs().dot(representatives_[i].coeffs()));
      if (dot < 0.999 * std::cos(1.5 * sigma)) continue;
      const double angle = 2.0 * std::acos(std::min(1.0, dot));
      if (angle > 3.0 * sigma) continue;
      gaussian[i] = std::exp(-0.5 * angle * angle / (sigma * sigma));
      mass += gaussian[i] * areas_[i];
    }
    for (double& density : gaussian) density /= mass;
    return gaussian;
  }

  std::vector<Eigen::Quaterniond> representatives_;
  std::vector<double> areas_;
  std::vector<double> prior_;
  std::vector<double> densities_;
};

void ExpectSame(const BayesianHistogram& posterior, const std::vector<double>& expected) {
  for (size_t i = 0; i < expected.size(); ++i) {
    const double density = posterior.Density(static_cast<int32_t>(i));
    ASSERT_NEAR(density, expected[i], 2e-5 * expected[i]) << i;
  }
}

double MassWithin(const So3Grid& grid,
                  const BayesianHistogram& posterior,
                  const Eigen::Quaterniond& q,
                  double radius) {
  std::vector<So3Grid::NearCell> near;
  grid.CellsWithin(q, radius, &near);
  double mass = 0.0;
  for (const So3Grid::NearCell& cell : near) mass += cell.area * posterior.Density(cell.ordinal);
  return mass;
}

TEST(BayesianHistogram, ParametersAreChecked) {
  using Parameters = BayesianHistogramParameters;
  EXPECT_TRUE(Parameters().Validate().ok());
  for (const double share : {0.0, 1.0, -0.1, static_cast<double>(NAN)}) {
    EXPECT_FALSE((Parameters{.outlier_share = share}).Validate().ok()) << share;
  }
  for (const double sigma : {0.0, -1.0, 4.0, static_cast<double>(NAN)}) {
    EXPECT_FALSE((Parameters{.sigma = sigma}).Validate().ok()) << sigma;
  }
  EXPECT_FALSE((Parameters{.peaks = {.w_min = 2.0}}).Validate().ok());
}

TEST(BayesianHistogram, BeforeTheFirstViewItIsThePrior) {
  const So3Grid grid(8);
  const std::vector<LikelyPose> poses = {{ExpSo3({1.0, 0.2, 0.0}), 0.3, 1.0}};
  const auto prior = OrientationPrior::AroundPoses(grid, poses, 0.2);
  ASSERT_TRUE(prior.ok());
  const BayesianHistogram posterior(grid, {}, *prior);
  for (int32_t i = 0; i < grid.num_cells(); ++i) {
    ASSERT_NEAR(posterior.Density(i), prior->Density(i), 1e-12);
  }
  ASSERT_EQ(posterior.Peaks().size(), 1U);
  EXPECT_LT(GeodesicAngle(posterior.Peaks().front().q, poses.front().q_world_object), 0.1);
  EXPECT_FALSE(posterior.Estimate().ok());
  EXPECT_TRUE(BayesianHistogram(grid, {}).Peaks().empty());
}

// One detection where the object hardly ever is: an outlier is likelier than that. A second one
// makes up for it.
TEST(BayesianHistogram, AStrongPriorOutweighsOneDetection) {
  const So3Grid grid(16);
  Rng rng(9);
  for (int trial = 0; trial < 5; ++trial) {
    const Eigen::Quaterniond likely = rng.Rotation();
    const Eigen::Quaterniond rare = likely * ExpSo3(rng.Uniform(1.0, 3.0) * rng.UnitVector());
    const std::vector<LikelyPose> poses = {{likely, 5.0 * kDegree, 1.0}};
    const auto prior = OrientationPrior::AroundPoses(grid, poses, 1e-6);
    ASSERT_TRUE(prior.ok());
    BayesianHistogram posterior(grid, {}, *prior);
    for (const Eigen::Quaterniond& expected : {likely, rare}) {
      ASSERT_TRUE(posterior.Add({rare, 0.0}).ok());
      ASSERT_TRUE(posterior.Estimate().ok());
      EXPECT_LT(GeodesicAngle(*posterior.Estimate(), expected), 4.0 * kDegree);
      EXPECT_GT(MassWithin(grid, posterior, expected, 20.0 * kDegree), 0.5);
    }
  }
}

TEST(BayesianHistogram, EqualsBayesRuleOnAllCells) {
  const So3Grid grid(8);
  Rng rng(1);
  for (const double outlier_share : {0.02, 0.3}) {
    for (const bool is_uniform : {true, false}) {
      const Eigen::Quaterniond truth = rng.Rotation();
      OrientationPrior prior;
      if (!is_uniform) {
        const std::vector<LikelyPose> poses = {{truth * ExpSo3({0.5, 0.0, 0.0}), 0.5, 1.0},
                                               {rng.Rotation(), 0.8, 2.0}};
        prior = *OrientationPrior::AroundPoses(grid, poses, 0.1);
      }
      const BayesianHistogramParameters parameters{.sigma = 12.0 * kDegree,
                                                   .outlier_share = outlier_share};
      BayesianHistogram posterior(grid, parameters, prior);
      DensePosterior expected(grid, prior);
      for (int view = 0; view < 7; ++view) {
        const OrientationView seen =
            view % 3 == 2 ? OrientationView{rng.Rotation(), 0.0} : Seen(truth, 6.0 * kDegree, rng);
        ASSERT_TRUE(posterior.Add(seen).ok());
        expected.Update(seen.q_world_object, parameters.sigma, outlier_share);
        if (view == 0 || view == 6) ExpectSame(posterior, expected.densities());
      }
    }
  }
}

TEST(BayesianHistogram, APriorOfZeroStaysZero) {
  const So3Grid grid(8);
  Rng rng(2);
  const Eigen::Quaterniond possible = rng.Rotation();
  const Eigen::Quaterniond excluded = possible * ExpSo3({0.0, 2.5, 0.0});
  const std::vector<LikelyPose> poses = {{possible, 0.2, 1.0}};
  const auto prior = OrientationPrior::AroundPoses(grid, poses, 0.0);
  ASSERT_TRUE(prior.ok());
  BayesianHistogram posterior(grid, {.sigma = 0.2}, *prior);
  ASSERT_TRUE(posterior.Add({excluded, 0.0}).ok());
  EXPECT_EQ(MassWithin(grid, posterior, excluded, 0.6), 0.0);
  // It can only have been an outlier.
  ASSERT_TRUE(posterior.Estimate().ok());
  EXPECT_LT(GeodesicAngle(*posterior.Estimate(), possible), 10.0 * kDegree);
  posterior.Move(0.3);
  EXPECT_EQ(MassWithin(grid, posterior, excluded, 0.6), 0.0);
  ASSERT_TRUE(posterior.Add({possible, 0.0}).ok());
  ASSERT_TRUE(posterior.Estimate().ok());
  EXPECT_LT(GeodesicAngle(*posterior.Estimate(), possible), 10.0 * kDegree);
}

TEST(BayesianHistogram, OrderDoesNotMatter) {
  const So3Grid grid(16);
  Rng rng(3);
  const Eigen::Quaterniond truth = rng.Rotation();
  std::vector<OrientationView> views;
  for (int i = 0; i < 12; ++i) {
    views.push_back(i % 3 == 0 ? OrientationView{rng.Rotation(), 0.0} : Seen(truth, 0.05, rng));
  }
  BayesianHistogram forward(grid, {});
  BayesianHistogram backward(grid, {});
  for (size_t i = 0; i < views.size(); ++i) {
    ASSERT_TRUE(forward.Add(views[i]).ok());
    OrientationView other_side = views[views.size() - 1 - i];
    other_side.q_world_object.coeffs() *= -1.0;
    ASSERT_TRUE(backward.Add(other_side).ok());
  }
  std::vector<So3Grid::NearCell> near;
  grid.CellsWithin(truth, 0.2, &near);
  for (const So3Grid::NearCell& cell : near) {
    const double density = forward.Density(cell.ordinal);
    ASSERT_NEAR(backward.Density(cell.ordinal), density, 1e-4 * density);
  }
  EXPECT_LT(GeodesicAngle(*forward.Estimate(), *backward.Estimate()), 1e-5);
}

TEST(BayesianHistogram, MotionIsAConvolution) {
  const So3Grid grid(8);
  Rng rng(4);
  constexpr double kSigma = 12.0 * kDegree;
  constexpr double kMotion = 14.0 * kDegree;
  BayesianHistogram posterior(grid, {.sigma = kSigma, .outlier_share = 0.2});
  DensePosterior expected(grid, {});
  DensePosterior all_spread = expected;
  const Eigen::Quaterniond truth = rng.Rotation();
  const auto see = [&](const OrientationView& view) {
    ASSERT_TRUE(posterior.Add(view).ok());
    expected.Update(view.q_world_object, kSigma, 0.2);
  };
  for (int i = 0; i < 2; ++i) see(Seen(truth, 5.0 * kDegree, rng));
  see({rng.Rotation(), 0.0});
  all_spread = expected;
  expected.Move(kMotion, expected.Untouched());
  posterior.Move(kMotion);
  ExpectSame(posterior, expected.densities());
  // The background spread too differs by how unevenly the grid spreads a uniform density.
  const double background = expected.Untouched();
  all_spread.Move(kMotion, 0.0);
  for (size_t i = 0; i < expected.densities().size(); ++i) {
    ASSERT_NEAR(all_spread.densities()[i], expected.densities()[i], 0.2 * background);
  }
  // And on from there.
  see(Seen(truth, 5.0 * kDegree, rng));
  ExpectSame(posterior, expected.densities());
  expected.Move(kMotion, expected.Untouched());
  posterior.Move(kMotion);
  ExpectSame(posterior, expected.densities());
}

TEST(BayesianHistogram, MotionLeadsToThePrior) {
  const So3Grid grid(8);
  Rng rng(8);
  const Eigen::Quaterniond truth = rng.Rotation();
  const std::vector<LikelyPose> poses = {{truth * ExpSo3({0.4, 0.0, 0.0}), 0.4, 1.0}};
  const auto prior = OrientationPrior::AroundPoses(grid, poses, 0.3);
  ASSERT_TRUE(prior.ok());
  BayesianHistogram posterior(grid, {.sigma = 0.2, .outlier_share = 0.2}, *prior);
  DensePosterior expected(grid, *prior);
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(posterior.Add({truth, 0.0}).ok());
    expected.Update(truth, 0.2, 0.2);
    expected.Move(0.3, expected.Untouched());
    posterior.Move(0.3);
    ExpectSame(posterior, expected.densities());
  }
}

TEST(BayesianHistogram, MotionForgets) {
  const So3Grid grid(16);
  const Eigen::Quaterniond truth = ExpSo3({0.2, 0.9, -0.4});
  BayesianHistogram posterior(grid, {});
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(posterior.Add({truth, 0.0}).ok());
  double before = MassWithin(grid, posterior, truth, 8.0 * kDegree);
  EXPECT_GT(before, 0.9);
  for (int i = 0; i < 4; ++i) {
    posterior.Move(6.0 * kDegree);
    const double after = MassWithin(grid, posterior, truth, 8.0 * kDegree);
    EXPECT_LT(after, before);
    before = after;
    EXPECT_NEAR(MassWithin(grid, posterior, truth, M_PI), 1.0, 1e-4);
    EXPECT_LT(GeodesicAngle(*posterior.Estimate(), truth), 4.0 * kDegree);
  }
  EXPECT_LT(before, 0.4);
}

TEST(BayesianHistogram, SmallMotionsAddUp) {
  const So3Grid grid(16);
  const Eigen::Quaterniond truth = ExpSo3({0.2, 0.9, -0.4});
  BayesianHistogram in_steps(grid, {});
  BayesianHistogram at_once(grid, {});
  ASSERT_TRUE(in_steps.Add({truth, 0.0}).ok());
  ASSERT_TRUE(at_once.Add({truth, 0.0}).ok());
  const int32_t own = grid.Ordinal(grid.CellOf(truth));
  const double before = at_once.Density(own);
  at_once.Move(0.0);
  EXPECT_EQ(at_once.Density(own), before);
  // Variances add: 16 motions of a quarter.
  const double sigma = 1.45 / 16.0;
  at_once.Move(sigma);
  for (int i = 0; i < 16; ++i) in_steps.Move(sigma / 4.0);
  EXPECT_LT(at_once.Density(own), 0.7 * before);
  std::vector<So3Grid::NearCell> near;
  grid.CellsWithin(truth, 0.5, &near);
  for (const So3Grid::NearCell& cell : near) {
    const double density = at_once.Density(cell.ordinal);
    ASSERT_NEAR(in_steps.Density(cell.ordinal), density, 1e-5 * density);
  }
}

TEST(BayesianHistogram, TenThousandUpdatesStayFinite) {
  const So3Grid grid(16);
  Rng rng(5);
  const Eigen::Quaterniond truth = rng.Rotation();
  BayesianHistogram posterior(grid, {});
  for (int i = 0; i < 10'000; ++i) {
    const OrientationView view =
        i % 10 == 0 ? OrientationView{rng.Rotation(), 0.0} : Seen(truth, 3.0 * kDegree, rng);
    ASSERT_TRUE(posterior.Add(view).ok());
    if (i % 2'000 == 1'999) posterior.Move(0.1);
  }
  EXPECT_NEAR(MassWithin(grid, posterior, truth, M_PI), 1.0, 1e-3);
  const auto q_f = posterior.Estimate();
  ASSERT_TRUE(q_f.ok());
  EXPECT_LT(GeodesicAngle(*q_f, truth), 7.5 * kDegree);  // Half the diagonal of a cell.
  const std::vector<OrientationPeak> peaks = posterior.Peaks();
  EXPECT_GT(peaks.front().weight, 0.0);
  EXPECT_LE(peaks.front().weight, 1.0 + 1e-4);
}

TEST(BayesianHistogram, FindsTheTruthAmongOutliers) {
  const So3Grid grid(32);
  Rng rng(6);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Quaterniond truth = rng.Rotation();
    BayesianHistogram posterior(grid, {});
    for (int i = 0; i < 12; ++i) {
      const OrientationView view =
          i % 2 == 0 ? OrientationView{rng.Rotation(), 0.0} : Seen(truth, 1.0 * kDegree, rng);
      ASSERT_TRUE(posterior.Add(view).ok());
    }
    const auto q_f = posterior.Estimate();
    ASSERT_TRUE(q_f.ok());
    EXPECT_LT(GeodesicAngle(*q_f, truth), 2.5 * kDegree);
    EXPECT_GE(q_f->w(), 0.0);
    EXPECT_GT(MassWithin(grid, posterior, truth, 10.0 * kDegree), 0.99);
  }
}

// The reason for additive fusion (paper 5.1): two detections that are wrong in the same way make
// the product all but certain, while the sum keeps the third one as an alternative.
TEST(BayesianHistogram, IsSureWhereAdditiveFusionIsNot) {
  const So3Grid grid(32);
  Rng rng(7);
  const Eigen::Quaterniond twice = rng.Rotation();
  const Eigen::Quaterniond once = twice * ExpSo3({0.0, 0.0, 2.0});
  BayesianHistogram posterior(grid, {});
  OrientationHistogram histogram(grid);
  for (const Eigen::Quaterniond& q : {twice, once, twice}) {
    ASSERT_TRUE(posterior.Add({q, 0.0}).ok());
    histogram.Add(q, 4.0 * kDegree, 1.0);
  }
  const auto additive = [&](const Eigen::Quaterniond& q) {
    std::vector<So3Grid::NearCell> near;
    grid.CellsWithin(q, 15.0 * kDegree, &near);
    double mass = 0.0;
    for (const So3Grid::NearCell& cell : near) mass += cell.area * histogram.Weight(cell.cell);
    return mass / histogram.Mass();
  };
  EXPECT_NEAR(additive(twice), 2.0 / 3.0, 1e-5);
  EXPECT_NEAR(additive(once), 1.0 / 3.0, 1e-5);
  EXPECT_GT(MassWithin(grid, posterior, twice, 15.0 * kDegree), 0.999);
  EXPECT_LT(MassWithin(grid, posterior, once, 15.0 * kDegree), 1e-3);
}

TEST(BayesianHistogram, BadViewsChangeNothing) {
  const So3Grid grid(8);
  BayesianHistogram posterior(grid, {});
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(posterior.Add({Eigen::Quaterniond(0.0, 0.0, 0.0, 0.0), 0.0}).ok());
  EXPECT_FALSE(posterior.Add({Eigen::Quaterniond(NAN, 0.0, 0.0, 0.0), 0.0}).ok());
  EXPECT_FALSE(posterior.Add({Eigen::Quaterniond(1.0, 0.0, kInfinity, 0.0), 0.0}).ok());
  EXPECT_FALSE(posterior.Add({Eigen::Quaterniond(1.5, 0.0, 0.0, 0.0), 0.0}).ok());
  EXPECT_FALSE(posterior.Add({Eigen::Quaterniond::Identity(), -1.0}).ok());
  EXPECT_FALSE(posterior.Add({Eigen::Quaterniond::Identity(), NAN}).ok());
  EXPECT_FALSE(posterior.Estimate().ok());
  for (int32_t i = 0; i < grid.num_cells(); i += 11) EXPECT_EQ(posterior.Density(i), 1.0);
}

}  // namespace
}  // namespace vantage
