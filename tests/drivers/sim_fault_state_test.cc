#include <gtest/gtest.h>

#include <cmath>

#include "drivers/sim/fault_state.h"

namespace vantage {
namespace {

using Kind = SimFault::Kind;

TEST(FaultState, NothingIsWrongAtFirst) {
  FaultState faults;
  EXPECT_TRUE(faults.Plugged(0.0));
  EXPECT_FALSE(faults.Stalled(0.0));
  EXPECT_FALSE(faults.TakeFrame(Kind::kShortFrame, 0.0));
}

TEST(FaultState, FaultsEndAfterTheirDuration) {
  FaultState faults;
  faults.Apply({Kind::kUnplug, 2.0}, 10.0);
  faults.Apply({Kind::kStall, 3.0}, 10.0);
  faults.Apply({Kind::kShortFrame, 1.0}, 10.0);
  EXPECT_FALSE(faults.Plugged(11.9));
  EXPECT_TRUE(faults.Plugged(12.0));
  EXPECT_TRUE(faults.Stalled(12.9));
  EXPECT_FALSE(faults.Stalled(13.0));
  EXPECT_TRUE(faults.TakeFrame(Kind::kShortFrame, 10.5));
  EXPECT_TRUE(faults.TakeFrame(Kind::kShortFrame, 10.9));
  EXPECT_FALSE(faults.TakeFrame(Kind::kShortFrame, 11.0));
}

TEST(FaultState, WithoutADurationTheyLastUntilReplug) {
  for (const double none : {0.0, -1.0, std::nan("")}) {
    FaultState faults;
    faults.Apply({Kind::kUnplug, none}, 10.0);
    faults.Apply({Kind::kStall, none}, 10.0);
    EXPECT_FALSE(faults.Plugged(1e9));
    EXPECT_TRUE(faults.Stalled(1e9));
    faults.Apply({Kind::kReplug, 0.0}, 2e9);
    EXPECT_TRUE(faults.Plugged(2e9));
    EXPECT_FALSE(faults.Stalled(2e9));
  }
}

TEST(FaultState, FaultsOfColorLastFaultsOfFramesAreUsedUp) {
  FaultState faults;
  for (const Kind kind : {Kind::kColorStop, Kind::kColorHalfRate, Kind::kColorLate}) {
    faults.Apply({kind, 0.0}, 10.0);
    EXPECT_TRUE(faults.TakeFrame(kind, 11.0));
    EXPECT_TRUE(faults.TakeFrame(kind, 1e9));
  }
  for (const Kind kind : {Kind::kNoData, Kind::kResized, Kind::kAbsurdSize, Kind::kStampBack}) {
    faults.Apply({kind, 0.0}, 10.0);
    EXPECT_TRUE(faults.TakeFrame(kind, 11.0));
    EXPECT_FALSE(faults.TakeFrame(kind, 11.0));
  }
  faults.Apply({Kind::kReplug, 0.0}, 12.0);
  EXPECT_FALSE(faults.TakeFrame(Kind::kColorStop, 12.0));
}

TEST(FaultState, EachShortFrameIsOneFrame) {
  FaultState faults;
  faults.Apply({Kind::kShortFrame, 0.0}, 10.0);
  faults.Apply({Kind::kShortFrame, 0.0}, 10.0);
  EXPECT_TRUE(faults.TakeFrame(Kind::kShortFrame, 11.0));
  EXPECT_TRUE(faults.TakeFrame(Kind::kShortFrame, 12.0));
  EXPECT_FALSE(faults.TakeFrame(Kind::kShortFrame, 13.0));
}

}  // namespace
}  // namespace vantage
