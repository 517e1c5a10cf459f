#include "tools/support/progress_bar.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

namespace vantage {
namespace {

std::string LastLine(const std::string& text) {
  const size_t end = text.find_last_not_of('\n');
  const size_t begin = text.find_last_of("\n\r", end);
  return text.substr(begin == std::string::npos ? 0 : begin + 1,
                     end - (begin == std::string::npos ? 0 : begin + 1) + 1);
}

TEST(ProgressBar, WritesALineEveryTenSecondsIntoAFile) {
  std::ostringstream stream;
  ProgressBar bar(stream, "views", 1000, false, 100.0);
  for (int second = 1; second <= 60; ++second) bar.Show(10 * second, 100.0 + second);
  const std::string text = stream.str();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 6);
  EXPECT_EQ(text.find_first_of("\r\033"), std::string::npos);
  EXPECT_EQ(LastLine(text), "[##############..........] 600/1000 views  60 %, 10.0/s, 0:40 left");
  bar.Show(1000, 160.5);
  bar.Finish();
  EXPECT_NE(LastLine(stream.str()).find("1000/1000 views 100 %"), std::string::npos);
}

TEST(ProgressBar, WritesOverItsLineOnATerminal) {
  std::ostringstream stream;
  ProgressBar bar(stream, "views", 100, true, 0.0);
  for (int i = 1; i <= 100; ++i) bar.Show(i, 0.25 * i);
  EXPECT_EQ(stream.str().find('\n'), std::string::npos);
  const std::string text = stream.str();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\r'), 100);
  bar.Finish();
  bar.Finish();
  EXPECT_EQ(stream.str(), text + "\n");
}

TEST(ProgressBar, DoesNotFloodATerminal) {
  std::ostringstream stream;
  ProgressBar bar(stream, "views", 100'000, true, 0.0);
  for (int i = 1; i < 10'000; ++i) bar.Show(i, 1e-4 * i);
  const std::string text = stream.str();
  EXPECT_LE(std::count(text.begin(), text.end(), '\r'), 10);
}

TEST(ProgressBar, RateFollowsAChangeWithinAMinuteOrTwo) {
  std::ostringstream stream;
  ProgressBar bar(stream, "views", 100'000, false, 0.0);
  int done = 0;
  for (int second = 1; second <= 100; ++second) bar.Show(done += 100, second);
  EXPECT_NE(LastLine(stream.str()).find(", 100.0/s"), std::string::npos);
  for (int second = 101; second <= 400; ++second) bar.Show(done += 20, second);
  EXPECT_NE(LastLine(stream.str()).find(", 20.0/s"), std::string::npos);
}

TEST(ProgressBar, SaysNothingOfRatesBeforeItKnowsOne) {
  std::ostringstream stream;
  ProgressBar bar(stream, "views", 5, true, 7.0);
  bar.Show(0, 8.0);
  EXPECT_EQ(LastLine(stream.str()), "[........................] 0/5 views   0 %\033[K");
}

TEST(ClockText, IsReadAsAClock) {
  EXPECT_EQ(ClockText(0.0), "0:00");
  EXPECT_EQ(ClockText(59.6), "1:00");
  EXPECT_EQ(ClockText(750.0), "12:30");
  EXPECT_EQ(ClockText(3725.0), "1:02:05");
  EXPECT_EQ(ClockText(1e300), "99:59:59");
}

}  // namespace
}  // namespace vantage
