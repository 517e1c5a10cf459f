#include "common/result.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "common/check.h"
#include "common/format.h"

namespace vantage {
namespace {

TEST(Result, HoldsAValueOrAnError) {
  const Result<int> value = 3;
  EXPECT_TRUE(value.ok());
  EXPECT_EQ(*value, 3);
  const Result<int> error = Error{ErrorCode::kNotFound, "no model x"};
  EXPECT_FALSE(error.ok());
  EXPECT_EQ(error.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(error.error().message, "no model x");
}

TEST(Result, MovesItsValueOut) {
  Result<std::unique_ptr<int>> result = std::make_unique<int>(4);
  const std::unique_ptr<int> value = std::move(result).value();
  EXPECT_EQ(*value, 4);
}

TEST(Result, OfNothingSucceedsOrTellsWhy) {
  EXPECT_TRUE(Result<void>().ok());
  const Result<void> failed = Error{ErrorCode::kIo, "disk full"};
  EXPECT_FALSE(failed);
  EXPECT_EQ(failed.error().message, "disk full");
}

TEST(ResultDeathTest, ValueOfAnErrorStopsTheProgram) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const Result<int> error = Error{ErrorCode::kNotFound, "no model x"};
  EXPECT_DEATH(static_cast<void>(error.value()), "check failed.*no model x");
}

TEST(CheckDeathTest, NamesFileConditionAndDetail) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const int weight = -1;
  VANTAGE_CHECK(weight < 0, "never");
  EXPECT_DEATH(VANTAGE_CHECK(weight > 0, "weights"), "result_test.cc.*weight > 0.*weights");
}

TEST(Format, IsPrintf) {
  EXPECT_EQ(Format("%s %d %.2f", "a", 5, 1.005), "a 5 1.00");
  EXPECT_EQ(Format("%s", ""), "");
  const std::string longer(5000, 'x');
  EXPECT_EQ(Format("<%s>", longer.c_str()), "<" + longer + ">");
}

}  // namespace
}  // namespace vantage
