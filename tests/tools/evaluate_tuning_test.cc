// The search for each method's parameters, by methods whose errors are known.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "tools/evaluate/fusion_methods.h"
#include "tools/evaluate/tuning.h"

namespace vantage {
namespace {

// Always says the same.
class Constant final : public OrientationFusion {
 public:
  explicit Constant(const Eigen::Quaterniond& q) : q_(q) {}
  Result<void> Add(const OrientationView&) override { return {}; }
  [[nodiscard]] Result<Eigen::Quaterniond> Estimate() const override { return q_; }

 private:
  Eigen::Quaterniond q_;
};

Eigen::Quaterniond Turned(double degrees) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(degrees * kDegree, Eigen::Vector3d::UnitX()));
}

// Sequences whose truth is the identity, with one detection each.
class TuningTest : public ::testing::Test {
 protected:
  static constexpr size_t kSequences = 20;

  TuningTest() : sequences_(kSequences) {
    for (DetectionSequence& sequence : sequences_) {
      sequence.views.resize(1);
      sequence.views[0].detections.resize(1);
      evaluated_.push_back({&sequence, &symmetry_});
    }
    parameters_.run.seed = 0;
  }

  // A method with two parameters whose error, deg, on the i-th sequence is given.
  template <class Error>
  static TunableMethod Method(Error error) {
    TunableMethod method;
    method.info.id = "made_up";
    method.parameters = {{"a", "deg", 1.0, {1, 2, 3, 4, 5}}, {"b", "", 10.0, {10, 20, 30}}};
    method.make = [error](const std::vector<double>& values) -> FusionMaker {
      return [error, values](uint64_t seed, const SymmetryGroup&) {
        return std::make_unique<Constant>(Turned(error(values[0], values[1], seed)));
      };
    };
    return method;
  }
  std::vector<TuningTrial> Tune(const TunableMethod& method) {
    return TuneMethod(method, evaluated_, parameters_, {}, {});
  }
  static const TuningTrial& Best(const std::vector<TuningTrial>& trials) {
    EXPECT_EQ(
        std::count_if(
            trials.begin(), trials.end(), [](const TuningTrial& trial) { return trial.is_best; }),
        1);
    return *std::find_if(
        trials.begin(), trials.end(), [](const TuningTrial& trial) { return trial.is_best; });
  }

  SymmetryGroup symmetry_;
  std::vector<DetectionSequence> sequences_;
  std::vector<EvaluatedSequence> evaluated_;
  TuningParameters parameters_;
};

TEST_F(TuningTest, FindsTheLeastMedianOfBothParameters) {
  // The best a depends on b, so one turn over the parameters is not enough.
  const auto trials = Tune(Method([](double a, double b, uint64_t) {
    const double x = a - 4.0;
    const double y = b / 10.0 - 3.0;
    return 0.5 + 0.1 * (x * x + y * y + 0.6 * x * y);
  }));
  const TuningTrial& best = Best(trials);
  EXPECT_EQ(best.values, (std::vector<double>{4.0, 30.0}));
  EXPECT_NEAR(best.median_deg, 0.5, 1e-9);
  EXPECT_NEAR(best.mean_deg, 0.5, 1e-9);
  EXPECT_EQ(best.wrong_mode_rate, 0.0);
  EXPECT_EQ(best.parameters, "a 4 deg, b 30");
  std::set<std::vector<double>> tried;
  for (const TuningTrial& trial : trials) EXPECT_TRUE(tried.insert(trial.values).second);
  EXPECT_LE(trials.size(), 15U);
}

TEST_F(TuningTest, WhatIsUsedStaysBestWhereItIs) {
  TunableMethod method =
      Method([](double a, double b, uint64_t) { return 1.0 + std::abs(a - 2.0) + b / 100.0; });
  method.parameters[0].value = 2.0;
  const auto trials = Tune(method);
  EXPECT_TRUE(trials.front().is_best);
  EXPECT_TRUE(trials.front().is_used);
  EXPECT_EQ(trials.size(), 5U + 3U - 1U);
  EXPECT_EQ(
      std::count_if(
          trials.begin(), trials.end(), [](const TuningTrial& trial) { return trial.is_used; }),
      1);
}

TEST_F(TuningTest, ClearlyMoreWrongModesOutweighTheMedian) {
  // The larger a the better, but at 5 every fifth sequence is lost.
  const auto trials = Tune(Method(
      [](double a, double, uint64_t seed) { return a > 4.5 && seed % 5 == 0 ? 90.0 : 6.0 - a; }));
  EXPECT_EQ(Best(trials).values[0], 4.0);
  const auto lost = std::find_if(trials.begin(), trials.end(), [](const TuningTrial& trial) {
    return trial.values[0] == 5.0;
  });
  ASSERT_NE(lost, trials.end());
  EXPECT_NEAR(lost->wrong_mode_rate, 0.2, 1e-12);
  EXPECT_NEAR(lost->median_deg, 1.0, 1e-9);
  EXPECT_NEAR(lost->mean_deg, 0.8 * 1.0 + 0.2 * 90.0, 1e-9);
}

TEST_F(TuningTest, RatesWithinTheToleranceAreDecidedByTheMedian) {
  std::vector<TuningTrial> trials(3);
  trials[0].wrong_mode_rate = 0.050;
  trials[0].median_deg = 0.3;
  trials[1].wrong_mode_rate = 0.059;
  trials[1].median_deg = 0.2;
  trials[2].wrong_mode_rate = 0.061;
  trials[2].median_deg = 0.1;
  EXPECT_EQ(BestTrial(trials, 0.01), 1U);
  EXPECT_EQ(BestTrial(trials, 0.02), 2U);
  EXPECT_EQ(BestTrial(trials, 0.0), 0U);
}

TEST_F(TuningTest, SequencesWithoutDetectionAreWrong) {
  for (size_t i = 0; i < 5; ++i) sequences_[i].views[0].detections.clear();
  const auto trials = Tune(Method([](double, double, uint64_t) { return 1.0; }));
  EXPECT_NEAR(trials.front().wrong_mode_rate, 0.25, 1e-12);
  EXPECT_NEAR(trials.front().mean_deg, 0.25 * 180.0 + 0.75, 1e-9);
}

TEST_F(TuningTest, ThreadsChangeNothing) {
  const TunableMethod method = Method([](double a, double b, uint64_t seed) {
    return std::abs(a - 3.0) + std::abs(b - 20.0) + 0.01 * static_cast<double>(seed);
  });
  const auto one = Tune(method);
  parameters_.run.threads = 3;
  const auto three = Tune(method);
  ASSERT_EQ(one.size(), three.size());
  for (size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].values, three[i].values);
    EXPECT_EQ(one[i].median_deg, three[i].median_deg);
    EXPECT_EQ(one[i].mean_deg, three[i].mean_deg);
    EXPECT_EQ(one[i].is_best, three[i].is_best);
  }
  EXPECT_EQ(Best(one).values, (std::vector<double>{3.0, 20.0}));
  EXPECT_NEAR(Best(one).median_deg, 0.095, 1e-9);
}

TEST_F(TuningTest, AStopLeavesNothing) {
  std::stop_source stop;
  const TunableMethod method = Method([](double, double, uint64_t) { return 1.0; });
  const auto trials =
      TuneMethod(method, evaluated_, parameters_, stop.get_token(), [&](int64_t, int64_t) {
        stop.request_stop();
      });
  EXPECT_TRUE(trials.empty());
}

TEST_F(TuningTest, ProgressGrowsUpToItsTotal) {
  int64_t last = 0;
  const TunableMethod method =
      Method([](double a, double b, uint64_t) { return 0.1 + std::abs(a - b / 10.0 - 1.0); });
  TuneMethod(method, evaluated_, parameters_, {}, [&](int64_t done, int64_t total) {
    EXPECT_GE(done, last);
    EXPECT_LE(done, total);
    last = done;
  });
  EXPECT_GT(last, 0);
}

TEST(TuningCsv, HasALineATrialWithQuotedParameters) {
  TuningTrial trial;
  trial.method_id = "made_up";
  trial.parameters = "a 1, b 2";
  trial.median_deg = 0.25;
  trial.is_used = true;
  EXPECT_EQ(TuningCsv(std::vector{trial}),
            "method,parameters,median_deg,mean_deg,wrong_mode_rate,seconds_per_view,is_best,"
            "is_used\nmade_up,\"a 1, b 2\",0.250000,0.000000,0.000000,0,0,1\n");
}

TEST(TunableMethods, EachCandidateMakesAMethodAndTheUsedValueIsOne) {
  const Result<So3Grid> grid = So3Grid::Create(8);
  ASSERT_TRUE(grid.ok());
  std::set<std::string> ids;
  std::set<std::string> texts;
  for (const TunableMethod& method : TunableMethods(*grid)) {
    SCOPED_TRACE(method.info.id);
    EXPECT_TRUE(ids.insert(method.info.id).second);
    for (size_t i = 0; i < method.parameters.size(); ++i) {
      const MethodParameter& parameter = method.parameters[i];
      EXPECT_TRUE(std::is_sorted(parameter.candidates.begin(), parameter.candidates.end()));
      EXPECT_EQ(
          std::count(parameter.candidates.begin(), parameter.candidates.end(), parameter.value), 1)
          << parameter.name;
      for (const double candidate : parameter.candidates) {
        std::vector<double> values = method.Values();
        values[i] = candidate;
        const FusionMethod made = method.With(values);
        if (candidate != parameter.value) {
          EXPECT_TRUE(texts.insert(made.info.id + made.info.parameters).second);
        }
        // Methods check their parameters as they are made.
        if (!made.is_slow) {
          EXPECT_NE(made.make(1, SymmetryGroup::None()), nullptr);
        }
      }
    }
    // The slow ones at the ends of their ranges.
    for (const bool last : {false, true}) {
      std::vector<double> values;
      for (const MethodParameter& parameter : method.parameters) {
        values.push_back(last ? parameter.candidates.back() : parameter.candidates.front());
      }
      EXPECT_NE(method.With(values).make(1, SymmetryGroup::None()), nullptr);
    }
  }
  EXPECT_TRUE(ids.count(kBestOursId) == 1 && ids.count(kBestBlindId) == 1);
  EXPECT_TRUE(ids.count(kParticleFilterId) == 1);
}

TEST(TunableMethods, FindOneExactDetectionAgain) {
  const Result<So3Grid> grid = So3Grid::Create(32);
  ASSERT_TRUE(grid.ok());
  Rng rng(7);
  const Eigen::Quaterniond q = rng.Rotation();
  for (const FusionMethod& method : FusionMethods(*grid)) {
    const auto fusion = method.make(3, SymmetryGroup::None());
    for (int view = 0; view < 3; ++view) {
      ASSERT_TRUE(fusion->Add({q, 1e-6}).ok()) << method.info.id;
    }
    const auto estimate = fusion->Estimate();
    ASSERT_TRUE(estimate.ok()) << method.info.id;
    // A cell of k = 32 is about three degrees wide; voting gives its middle.
    const double most_deg = method.info.is_histogram ? 3.0 : 0.3;
    EXPECT_LT(GeodesicAngle(*estimate, q) / kDegree, most_deg) << method.info.id;
  }
}

}  // namespace
}  // namespace vantage
