#include "drivers/v4l2/v4l2_controls.h"

#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <limits>

namespace vantage {
namespace {

V4l2Control Integer(int64_t lowest, int64_t highest, uint64_t step) {
  V4l2Control control;
  control.type = V4L2_CTRL_TYPE_INTEGER;
  control.lowest = lowest;
  control.highest = highest;
  control.step = step;
  return control;
}

std::string Complaint(const V4l2Control& control, int64_t value) {
  const Result<void> fits = control.CheckValue(value);
  return fits.ok() ? "" : fits.error().message;
}

TEST(ControlName, IsAsV4l2CtlHasIt) {
  EXPECT_EQ(ControlName("Brightness"), "brightness");
  EXPECT_EQ(ControlName("Exposure, Auto"), "exposure_auto");
  EXPECT_EQ(ControlName("Exposure (Absolute)"), "exposure_absolute");
  EXPECT_EQ(ControlName("White Balance, Auto & Preset"), "white_balance_auto_preset");
  EXPECT_EQ(ControlName("  Integer 32 Bits"), "integer_32_bits");
  EXPECT_EQ(ControlName(""), "");
  EXPECT_EQ(ControlName("***"), "");
}

TEST(V4l2Control, IntegersHaveRangeAndStep) {
  const V4l2Control control = Integer(-64, 64, 8);
  for (const int64_t good : {-64, -56, 0, 64}) EXPECT_EQ(Complaint(control, good), "") << good;
  EXPECT_EQ(Complaint(control, 65), "expected -64 to 64 in steps of 8");
  EXPECT_EQ(Complaint(control, 3), "expected -64 to 64 in steps of 8");
  EXPECT_EQ(Complaint(Integer(0, 255, 1), 256), "expected 0 to 255");
  EXPECT_EQ(Complaint(Integer(0, 255, 0), 255), "");
  constexpr int64_t kLowest = std::numeric_limits<int64_t>::min();
  constexpr int64_t kHighest = std::numeric_limits<int64_t>::max();
  EXPECT_EQ(Complaint(Integer(kLowest, kHighest, 1), kHighest), "");
  EXPECT_NE(Complaint(Integer(kLowest, kHighest, 2), kHighest), "");
}

TEST(V4l2Control, MenusHaveItemsAndGaps) {
  V4l2Control menu = Integer(0, 3, 1);
  menu.type = V4L2_CTRL_TYPE_MENU;
  menu.items = {{1, "Manual Mode"}, {3, "Aperture Priority Mode"}};
  EXPECT_EQ(Complaint(menu, 1), "");
  EXPECT_EQ(Complaint(menu, 0), "expected one of 1 (Manual Mode), 3 (Aperture Priority Mode)");
  EXPECT_NE(Complaint(menu, 4), "");
}

TEST(V4l2Control, OtherTypes) {
  V4l2Control control = Integer(0, 1, 1);
  control.type = V4L2_CTRL_TYPE_BOOLEAN;
  EXPECT_EQ(Complaint(control, 1), "");
  EXPECT_EQ(Complaint(control, 2), "expected 0 or 1");
  control = Integer(0, 0x5, 0);
  control.type = V4L2_CTRL_TYPE_BITMASK;
  EXPECT_EQ(Complaint(control, 4), "");
  EXPECT_EQ(Complaint(control, 2), "expected bits of 0x5");
  EXPECT_NE(Complaint(control, -1), "");
  control.type = V4L2_CTRL_TYPE_BUTTON;
  EXPECT_EQ(Complaint(control, 12345), "");
  control.type = V4L2_CTRL_TYPE_STRING;
  EXPECT_EQ(Complaint(control, 0), "it takes no number");
  control = Integer(0, 10, 1);
  control.flags = V4L2_CTRL_FLAG_READ_ONLY;
  EXPECT_EQ(Complaint(control, 5), "it can only be read");
}

TEST(V4l2Controls, OfAFileThatHasNone) {
  V4l2Controls controls(-1, "/dev/video0");
  EXPECT_TRUE(controls.all().empty());
  const Result<void> set = controls.Set("gain", 1);
  ASSERT_FALSE(set.ok());
  EXPECT_EQ(set.error().message, "device /dev/video0 has no control gain, expected one of: none");
  EXPECT_FALSE(controls.SetExposure(0).ok());
  EXPECT_FALSE(controls.SetExposure(1000).ok());
  EXPECT_FALSE(controls.SetGain(1).ok());
}

}  // namespace
}  // namespace vantage
