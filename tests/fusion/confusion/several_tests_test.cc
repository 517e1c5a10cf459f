#include "fusion/confusion/several_tests.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/rng.h"

namespace vantage {
namespace {

TEST(SeveralTests, HolmsExample) {
  // 0.01 <= 0.05 / 4, 0.015 <= 0.05 / 3, 0.03 > 0.05 / 2: two are rejected, though 0.04 <= 0.05.
  const std::vector<double> p_values = {0.03, 0.01, 0.04, 0.015};
  const SeveralTests all = Combine(p_values);
  EXPECT_EQ(all.num_tests, 4);
  EXPECT_EQ(all.num_rejected, 4);
  EXPECT_DOUBLE_EQ(all.expected_rejected, 0.2);
  EXPECT_EQ(all.num_rejected_by_holm, 2);
  EXPECT_DOUBLE_EQ(all.smallest_p, 0.04);
}

TEST(SeveralTests, BordersAndNone) {
  EXPECT_EQ(Combine({}).num_rejected_by_holm, 0);
  EXPECT_EQ(Combine({}).uniformity_p, 1.0);
  EXPECT_EQ(Combine(std::vector<double>{0.05}).num_rejected_by_holm, 1);
  EXPECT_EQ(Combine(std::vector<double>{0.051}).num_rejected_by_holm, 0);
  EXPECT_EQ(Combine(std::vector<double>{0.0, 0.0, 0.0}).num_rejected_by_holm, 3);
  EXPECT_EQ(Combine(std::vector<double>{1.0, 1.0}).smallest_p, 1.0);
}

// Under the null any rejection at all happens in at most alpha of the cases.
TEST(SeveralTests, HolmKeepsTheLevelForAllTogether) {
  Rng rng(1);
  int any = 0;
  constexpr int kRuns = 2000;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<double> p_values(60);
    for (double& p : p_values) p = rng.Uniform();
    any += Combine(p_values).num_rejected_by_holm > 0 ? 1 : 0;
  }
  EXPECT_NEAR(any / static_cast<double>(kRuns), 0.05, 0.015);
}

TEST(UniformityTest, PValuesAreUniformUnderTheNull) {
  Rng rng(2);
  for (const int n : {5, 60, 400}) {
    int below_tenth = 0;
    int below_half = 0;
    constexpr int kRuns = 3000;
    for (int run = 0; run < kRuns; ++run) {
      std::vector<double> values(static_cast<size_t>(n));
      for (double& value : values) value = rng.Uniform();
      const double p = UniformityTest(values);
      below_tenth += p <= 0.1 ? 1 : 0;
      below_half += p <= 0.5 ? 1 : 0;
    }
    EXPECT_NEAR(below_tenth / static_cast<double>(kRuns), 0.1, 0.025) << n;
    EXPECT_NEAR(below_half / static_cast<double>(kRuns), 0.5, 0.04) << n;
  }
}

TEST(UniformityTest, FindsWhatIsNot) {
  Rng rng(3);
  std::vector<double> values(60);
  for (double& value : values) value = std::pow(rng.Uniform(), 2.0);
  EXPECT_LT(UniformityTest(values), 0.01);
  std::fill(values.begin(), values.end(), 1.0);
  EXPECT_LT(UniformityTest(values), 1e-6);
  for (size_t i = 0; i < values.size(); ++i) values[i] = (static_cast<double>(i) + 0.5) / 60.0;
  EXPECT_GT(UniformityTest(values), 0.999);
  EXPECT_EQ(UniformityTest({}), 1.0);
}

}  // namespace
}  // namespace vantage
