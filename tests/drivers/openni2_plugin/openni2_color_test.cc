// Color beside depth: which image belongs to which, its size and its layout.
#include "drivers/openni2/openni2_color.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/drivers/openni2_plugin/openni2_fixture.h"

namespace vantage {
namespace {

constexpr int64_t kHalfPeriod = 16'667;  // us

class Openni2Color : public Openni2Plugin {
 protected:
  void SetUp() override {
    Openni2Plugin::SetUp();
    options_.stream.color = true;
  }
  [[nodiscard]] bool GrabWithColor() {
    return GrabUntil([this] { return !frames_.empty() && frames_.back().color; });
  }
  /// No pair is further apart than half a period, no color image comes twice or goes back.
  void ExpectSoundPairs() const {
    int64_t last_us = INT64_MIN;
    for (const CameraFrame& frame : frames_) {
      if (!frame.color) continue;
      const int64_t delay_us = frame.color->utime - frame.utime;
      EXPECT_LE(std::abs(delay_us), kHalfPeriod);
      const int64_t color_us = frame.device_time_us + delay_us;
      EXPECT_GT(color_us, last_us);
      last_us = color_us;
    }
  }
  [[nodiscard]] int64_t NumPairs() const {
    return std::ranges::count_if(frames_,
                                 [](const auto& frame) { return frame.color.has_value(); });
  }
};

TEST_F(Openni2Color, PairsAreOfOneExposure) {
  Create("index:0");
  ASSERT_TRUE(GrabWithColor());
  ASSERT_TRUE(GrabFrames(20));
  ExpectSoundPairs();
  EXPECT_EQ(camera_->status().color_delay_s, 0.0);
  EXPECT_EQ(NumPairs() + camera_->status().num_unpaired, static_cast<int64_t>(frames_.size()));
}

TEST_F(Openni2Color, TakenLaterItIsWaitedForAndSaysByHowMuch) {
  abilities_.color_delay = std::chrono::milliseconds(10);
  Create("index:0");
  ASSERT_TRUE(GrabWithColor());
  ASSERT_TRUE(GrabFrames(15));
  ExpectSoundPairs();
  for (const CameraFrame& frame : frames_) {
    EXPECT_TRUE(!frame.color || frame.color->utime - frame.utime == 10'000);
  }
  EXPECT_EQ(camera_->status().color_delay_s, 0.01);
}

TEST_F(Openni2Color, StoppedDepthGoesOnAlone) {
  Create("index:0");
  ASSERT_TRUE(GrabWithColor());
  Fault(SimFault::Kind::kColorStop);
  ASSERT_TRUE(GrabUntil([this] { return !frames_.back().color; }));
  const int64_t num_pairs = NumPairs();
  const int64_t num_unpaired = camera_->status().num_unpaired;
  ASSERT_TRUE(GrabFrames(15));
  EXPECT_LE(NumPairs(), num_pairs + 1);  // One may have been under way.
  EXPECT_GE(camera_->status().num_unpaired, num_unpaired + 14);
  EXPECT_EQ(camera_->status().state, CameraState::kStreaming);
  Fault(SimFault::Kind::kReplug);
  EXPECT_TRUE(GrabWithColor());
  ExpectSoundPairs();
}

TEST_F(Openni2Color, AtHalfRateEverySecondDepthImageIsAlone) {
  Create("index:0");
  ASSERT_TRUE(GrabWithColor());
  Fault(SimFault::Kind::kColorHalfRate);
  ASSERT_TRUE(GrabUntil([this] { return camera_->status().num_unpaired >= 5; }));
  ASSERT_TRUE(GrabWithColor());
  ExpectSoundPairs();
}

TEST_F(Openni2Color, LateByHalfAPeriodItIsNeverStale) {
  Create("index:0");
  ASSERT_TRUE(GrabWithColor());
  Fault(SimFault::Kind::kColorLate);
  ASSERT_TRUE(GrabFrames(25));
  ExpectSoundPairs();
  EXPECT_EQ(NumPairs() + camera_->status().num_unpaired, static_cast<int64_t>(frames_.size()));
}

TEST_F(Openni2Color, WithStampsOfAnotherTimeItIsLeftOut) {
  Create("index:0");
  ASSERT_TRUE(GrabWithColor());
  Fault(SimFault::Kind::kColorOffset);
  ASSERT_TRUE(GrabUntil([this] { return !frames_.back().color; }));
  const int64_t num_pairs = NumPairs();
  ASSERT_TRUE(GrabFrames(15));
  EXPECT_EQ(NumPairs(), num_pairs);
  ExpectSoundPairs();
}

// OpenNI2 synchronizes by holding depth back until color has come.
TEST_F(Openni2Color, SynchronizedDepthGoesOnAloneToo) {
  abilities_.frame_sync = true;
  Create("index:0");
  ASSERT_TRUE(GrabWithColor());
  ASSERT_TRUE(GrabFrames(10));
  ExpectSoundPairs();
  Fault(SimFault::Kind::kColorStop);
  ASSERT_TRUE(GrabUntil([this] { return !frames_.back().color; }));
  ASSERT_TRUE(GrabFrames(5));
  EXPECT_NE(camera_->status().message.find("it no longer does"), std::string::npos)
      << camera_->status().message;
  EXPECT_EQ(camera_->status().num_reconnects, 0);
  Fault(SimFault::Kind::kReplug);
  EXPECT_TRUE(GrabWithColor());
}

TEST_F(Openni2Color, OfAnotherSizeWhereTheDeviceHasNoOther) {
  abilities_.full_color_only = true;
  options_.stream.width = 320;
  options_.stream.height = 240;
  options_.stream.registration = Registration::kDepthToColor;
  Create("index:0");
  ASSERT_TRUE(GrabWithColor()) << camera_->status().message;
  ExpectedImages expected;
  EXPECT_EQ(frames_.back().width, 320);
  EXPECT_EQ(frames_.back().depth_mm, expected.Depth(320));
  EXPECT_EQ(frames_.back().color->width, 640);
  EXPECT_EQ(frames_.back().color->data, expected.Color(640));
  // Left to whoever knows how the sizes relate.
  EXPECT_FALSE(frames_.back().registered);
}

TEST_F(Openni2Color, IsMadeGray) {
  options_.stream.color_layout = PixelLayout::kGray8;
  Create("index:0");
  ASSERT_TRUE(GrabWithColor());
  const ColorImage& gray = *frames_.back().color;
  EXPECT_EQ(gray.layout, PixelLayout::kGray8);
  ExpectedImages expected;
  const std::vector<uint8_t>& rgb = expected.Color();
  ASSERT_EQ(gray.data.size(), rgb.size() / 3);
  for (size_t i = 0; i < gray.data.size(); ++i) {
    ASSERT_NEAR(
        gray.data[i], 0.299 * rgb[3 * i] + 0.587 * rgb[3 * i + 1] + 0.114 * rgb[3 * i + 2], 0.51);
  }
}

TEST_F(Openni2Color, ADeviceThatGivesGrayGivesGray) {
  abilities_.gray_color = true;
  abilities_.mirroring = SimAbilities::Mirroring::kAlwaysDepth;
  for (const PixelLayout layout : {PixelLayout::kGray8, PixelLayout::kRgb8}) {
    options_.stream.color_layout = layout;
    frames_.clear();
    Create("index:0");
    ASSERT_TRUE(GrabWithColor()) << camera_->status().message;
    EXPECT_EQ(frames_.back().color->layout, PixelLayout::kGray8);
    ExpectedImages expected;
    const std::vector<uint8_t>& rgb = expected.Color();
    const std::vector<uint8_t>& gray = frames_.back().color->data;
    ASSERT_EQ(gray.size(), rgb.size() / 3);
    for (size_t i = 0; i < gray.size(); ++i) ASSERT_EQ(gray[i], rgb[3 * i + 1]);
    camera_.reset();
  }
}

TEST_F(Openni2Color, JpegIsRefusedWithASentence) {
  options_.stream.color_layout = PixelLayout::kJpeg;
  Create("index:0");
  ASSERT_TRUE(GrabUntil([this] {
    return camera_->status().message.find("gives no JPEG images") != std::string::npos;
  })) << camera_->status().message;
}

RawImage Rgb(const std::vector<std::byte>& pixels, int width, int height) {
  RawImage image;
  image.layout = PixelLayout::kRgb8;
  image.width = width;
  image.height = height;
  image.stride_bytes = 3 * width;
  image.data = pixels;
  return image;
}

TEST(ConvertColor, FlipsEveryRow) {
  std::vector<std::byte> pixels;
  for (int i = 0; i < 18; ++i) pixels.push_back(std::byte(i));
  std::vector<std::byte> buffer;
  const RawImage flipped = ConvertColor(Rgb(pixels, 3, 2), false, true, &buffer);
  for (size_t v = 0; v < 2; ++v) {
    for (size_t u = 0; u < 3; ++u) {
      for (size_t c = 0; c < 3; ++c) {
        EXPECT_EQ(flipped.data[9 * v + 3 * u + c], pixels[9 * v + 3 * (2 - u) + c]);
      }
    }
  }
}

TEST(ConvertColor, WhatDoesNotFitComesBackAsItIs) {
  const std::vector<std::byte> pixels(18);
  std::vector<std::byte> buffer;
  for (const auto& [width, height] : {std::pair(4, 2),
                                      std::pair(INT32_MAX, INT32_MAX),
                                      std::pair(-3, -2),
                                      std::pair(0, 2),
                                      std::pair(3, -1)}) {
    RawImage image = Rgb(pixels, 3, 2);
    image.width = width;
    image.height = height;
    const RawImage same = ConvertColor(image, true, true, &buffer);
    EXPECT_EQ(same.data.data(), pixels.data());
    EXPECT_EQ(same.layout, PixelLayout::kRgb8);
  }
}

}  // namespace
}  // namespace vantage
