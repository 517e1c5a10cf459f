#include "common/time_range.h"

#include <gtest/gtest.h>

#include <limits>

namespace vantage {
namespace {

TEST(TimeRange, HoldsTheYears1970To2200) {
  EXPECT_TRUE(IsPlausibleUtime(0));
  EXPECT_TRUE(IsPlausibleUtime(1'700'000'000'000'000));
  EXPECT_TRUE(IsPlausibleUtime(kLatestUtime));
  EXPECT_FALSE(IsPlausibleUtime(-1));
  EXPECT_FALSE(IsPlausibleUtime(kLatestUtime + 1));
  EXPECT_FALSE(IsPlausibleUtime(std::numeric_limits<int64_t>::min()));
  EXPECT_FALSE(IsPlausibleUtime(std::numeric_limits<int64_t>::max()));
}

}  // namespace
}  // namespace vantage
