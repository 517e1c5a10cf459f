#include "fusion/confusion/stopping_rule.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "common/rng.h"

namespace vantage {
namespace {

using Outcome = std::optional<Eigen::Quaterniond>;

Eigen::Quaterniond Near(const Eigen::Quaterniond& mode, Rng& rng) {
  return mode * ExpSo3(1.0 * kDegree * Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal()));
}

Eigen::Quaterniond AboutZ(double angle_deg) {
  return ExpSo3(angle_deg * kDegree * Eigen::Vector3d::UnitZ());
}

template <class Draw>
int TrialsUntilDone(StoppingRule rule, Draw&& draw) {
  while (!rule.IsDone()) rule.Add(draw());
  return rule.num_trials();
}

TEST(StoppingRule, AnUnambiguousDirectionIsDoneAfter60To80Trials) {
  Rng rng(1);
  const int trials = TrialsUntilDone(StoppingRule({}, SymmetryGroup::None()), [&]() -> Outcome {
    return Near(Eigen::Quaterniond::Identity(), rng);
  });
  EXPECT_EQ(trials, 69);  // As the parameter's comment has it.
}

TEST(StoppingRule, ADirectionInWhichNothingIsFoundIsDoneAsSoon) {
  EXPECT_EQ(TrialsUntilDone(StoppingRule({}, SymmetryGroup::None()),
                            []() -> Outcome { return std::nullopt; }),
            69);
}

TEST(StoppingRule, AnAmbiguousDirectionTakesMore) {
  Rng rng(2);
  double sum = 0.0;
  constexpr int kRuns = 50;
  for (int run = 0; run < kRuns; ++run) {
    const int trials = TrialsUntilDone(StoppingRule({}, SymmetryGroup::None()), [&]() -> Outcome {
      return Near(AboutZ(180.0 * rng.Below(2)), rng);
    });
    EXPECT_GT(trials, 69);
    EXPECT_LE(trials, 250);
    sum += trials;
  }
  EXPECT_NEAR(sum / kRuns, 120.0, 10.0);
}

// Chance agreement that ends the trials of a confused direction early is rare.
TEST(StoppingRule, SeldomTakesAConfusedDirectionForAnUnambiguousOne) {
  Rng rng(3);
  int all_agreed = 0;
  constexpr int kRuns = 400;
  for (int run = 0; run < kRuns; ++run) {
    StoppingRule rule({}, SymmetryGroup::None());
    while (!rule.IsDone()) rule.Add(AboutZ(rng.Uniform() < 0.08 ? 90.0 : 0.0));
    all_agreed += rule.num_modes() == 1 ? 1 : 0;
  }
  EXPECT_LE(all_agreed, 0.05 * kRuns);
}

// However the outcomes fall, none ends sooner than agreement of all.
TEST(StoppingRule, AgreementEndsSoonest) {
  Rng rng(6);
  for (const double share : {0.01, 0.05, 0.1, 0.3, 0.5}) {
    for (int run = 0; run < 20; ++run) {
      EXPECT_GE(
          TrialsUntilDone(StoppingRule({}, SymmetryGroup::None()),
                          [&]() -> Outcome { return AboutZ(rng.Uniform() < share ? 90.0 : 0.0); }),
          69);
    }
  }
}

TEST(StoppingRule, KeepsWithinItsBounds) {
  Rng rng(4);
  StoppingParameters parameters;
  parameters.least_trials = 40;
  parameters.most_trials = 90;
  parameters.largest_confusion = 0.5;
  parameters.widest = 0.9;
  const auto one_mode = []() -> Outcome { return Eigen::Quaterniond::Identity(); };
  const auto anything = [&]() -> Outcome { return rng.Rotation(); };
  EXPECT_EQ(TrialsUntilDone(StoppingRule(parameters, SymmetryGroup::None()), one_mode), 40);
  parameters.largest_confusion = 1e-6;
  parameters.widest = 1e-6;
  EXPECT_EQ(TrialsUntilDone(StoppingRule(parameters, SymmetryGroup::None()), anything), 90);
  EXPECT_EQ(TrialsUntilDone(StoppingRule(parameters, SymmetryGroup::None()), one_mode), 90);
  parameters.least_trials = parameters.most_trials = 1;
  EXPECT_EQ(TrialsUntilDone(StoppingRule(parameters, SymmetryGroup::None()), anything), 1);
}

TEST(StoppingRule, ModesAreModuloTheSymmetry) {
  Rng rng(5);
  const SymmetryGroup brick = SymmetryGroup::Dihedral(2, {0, 0, 1}, {1, 0, 0});
  const SymmetryGroup bottle = SymmetryGroup::Continuous({0, 0, 1}, false);
  StoppingRule none({}, SymmetryGroup::None());
  StoppingRule of_brick({}, brick);
  StoppingRule of_bottle({}, bottle);
  for (int i = 0; i < 60; ++i) {
    const Eigen::Quaterniond difference = Near(brick.elements[rng.Below(4)], rng);
    none.Add(difference);
    of_brick.Add(difference);
    of_bottle.Add(Near(AboutZ(rng.Uniform(0.0, 360.0)), rng));
  }
  EXPECT_EQ(none.num_modes(), 4);
  EXPECT_EQ(of_brick.num_modes(), 1);
  EXPECT_EQ(of_bottle.num_modes(), 1);
}

TEST(StoppingRule, JoinsTheNearestModeWithinTheRadius) {
  StoppingRule rule({}, SymmetryGroup::None());
  rule.Add(AboutZ(0.0));
  rule.Add(AboutZ(9.9));
  EXPECT_EQ(rule.num_modes(), 1);
  rule.Add(AboutZ(10.1));
  EXPECT_EQ(rule.num_modes(), 2);
  rule.Add(AboutZ(-349.9));  // As 10.1.
  rule.Add(Eigen::Quaterniond(-AboutZ(10.1).coeffs()));
  EXPECT_EQ(rule.num_modes(), 2);
  rule.Add(std::nullopt);
  EXPECT_EQ(rule.num_modes(), 2);
  EXPECT_EQ(rule.num_trials(), 6);
}

TEST(StoppingParameters, ValuesOutOfRangeAreNamed) {
  EXPECT_TRUE(StoppingParameters().Validate().ok());
  const auto expect_error = [](const std::string& name, auto&& change) {
    StoppingParameters parameters;
    change(&parameters);
    const Result<void> valid = parameters.Validate();
    ASSERT_FALSE(valid.ok()) << name;
    EXPECT_NE(valid.error().message.find(name), std::string::npos) << valid.error().message;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expect_error("least_trials", [](StoppingParameters* p) { p->least_trials = 0; });
  expect_error("most_trials", [](StoppingParameters* p) { p->most_trials = 23; });
  expect_error("most_trials", [](StoppingParameters* p) { p->most_trials = 2'000'000'000; });
  for (const double bad : {0.0, 1.0, -0.1, nan}) {
    expect_error("largest_confusion", [&](StoppingParameters* p) { p->largest_confusion = bad; });
    expect_error("widest", [&](StoppingParameters* p) { p->widest = bad; });
    expect_error("alpha", [&](StoppingParameters* p) { p->alpha = bad; });
  }
  for (const double bad : {0.0, 3.2, -1.0, nan}) {
    expect_error("mode_radius", [&](StoppingParameters* p) { p->mode_radius = bad; });
  }
}

TEST(StoppingParameters, TextTellsParametersApart) {
  const std::string text = StoppingParameters().Text();
  EXPECT_NE(text.find("most_trials 250"), std::string::npos) << text;
  StoppingParameters changed;
  changed.widest += 1e-12;
  EXPECT_NE(changed.Text(), text);
  changed = {};
  changed.least_trials = 25;
  EXPECT_NE(changed.Text(), text);
  EXPECT_EQ(StoppingParameters().Text(), text);
}

}  // namespace
}  // namespace vantage
