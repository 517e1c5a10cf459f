// Every pixel format from the device to the frame, against the scene that the device shows.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <ostream>
#include <set>
#include <vector>

#include "common/jpeg_decoder.h"
#include "tests/drivers/v4l2_live/emulated_devices.h"
#include "tests/drivers/v4l2_live/live_camera.h"
#include "tests/drivers/v4l2_shim/test_scene.h"

namespace vantage {
namespace {

constexpr int kWidth = LiveCamera::kWidth;
constexpr int kHeight = LiveCamera::kHeight;

// What channel c of pixel (x, y) should be.
using Truth = std::function<double(int x, int y, int c, int phase)>;

double Clamped(double value) { return std::clamp(value, 0.0, 255.0); }

// ITU-R BT.601, limited range.
double RgbOfYuv(int x, int y, int c, int phase) {
  const v4l2_shim::YCbCr color = v4l2_shim::SharpColor(x, y, phase);
  const double luma = 255.0 / 219.0 * (color.y - 16.0);
  const double cb = 255.0 / 224.0 * (color.cb - 128.0);
  const double cr = 255.0 / 224.0 * (color.cr - 128.0);
  if (c == 0) return Clamped(luma + 1.402 * cr);
  if (c == 2) return Clamped(luma + 1.772 * cb);
  return Clamped(luma - 0.344136 * cb - 0.714136 * cr);
}

double LumaOfYuv(int x, int y, int, int phase) {
  return Clamped(255.0 / 219.0 * (v4l2_shim::SharpColor(x, y, phase).y - 16.0));
}

double Gray(int x, int y, int, int phase) { return v4l2_shim::SharpColor(x, y, phase).y; }

double Smooth(int x, int y, int c, int phase) {
  return v4l2_shim::SmoothColor(x, y, phase, kWidth, kHeight)[static_cast<size_t>(c)];
}

double SmoothLuma(int x, int y, int, int phase) {
  return 0.299 * Smooth(x, y, 0, phase) + 0.587 * Smooth(x, y, 1, phase) +
         0.114 * Smooth(x, y, 2, phase);
}

// The largest difference to the scene of a phase, without so many pixels at the borders.
double Deviation(
    const std::vector<uint8_t>& pixels, int channels, int border, const Truth& truth, int phase) {
  double largest = 0.0;
  for (int y = border; y < kHeight - border; ++y) {
    for (int x = border; x < kWidth - border; ++x) {
      for (int c = 0; c < channels; ++c) {
        const size_t i = static_cast<size_t>((y * kWidth + x) * channels + c);
        largest = std::max(largest, std::abs(pixels[i] - truth(x, y, c, phase)));
      }
    }
  }
  return largest;
}

struct ColorCase {
  std::string name;
  std::string fourcc;
  std::string more;  // Lines of the description.
  PixelLayout layout = PixelLayout::kRgb8;
  Truth truth;
  double tolerance = 0.0;
  int border = 0;
};
void PrintTo(const ColorCase& each, std::ostream* out) { *out << each.name; }

class ColorFormats : public testing::TestWithParam<ColorCase> {};

TEST_P(ColorFormats, EveryPixelIsThatOfTheScene) {
  const ColorCase& param = GetParam();
  const EmulatedDevices devices;
  devices.Describe(DeviceZero(SmallFormat(param.fourcc) + param.more));
  LiveCamera::Settings settings;
  settings.v4l2.pixel_format = param.fourcc;
  settings.stream.color_layout = param.layout;
  LiveCamera live(settings);
  std::set<int> phases;
  live.on_frame = [&](const CameraFrame& frame) {
    ASSERT_TRUE(frame.color.has_value());
    ASSERT_TRUE(frame.depth_mm.empty());
    ASSERT_EQ(frame.color->width, kWidth);
    ASSERT_EQ(frame.color->height, kHeight);
    ASSERT_EQ(frame.color->layout, param.layout);
    std::vector<uint8_t> pixels = frame.color->data;
    const int channels = param.layout == PixelLayout::kGray8 ? 1 : 3;
    if (param.layout == PixelLayout::kJpeg) {
      pixels.resize(size_t{3} * kWidth * kHeight);
      const Result<void> decoded =
          DecodeJpeg(frame.color->data, kWidth, kHeight, JpegPixels::kRgb, &pixels);
      ASSERT_TRUE(decoded.ok()) << decoded.error().message;
    }
    ASSERT_EQ(pixels.size(), static_cast<size_t>(channels * kWidth * kHeight));
    int best = 0;
    double least = 1e9;
    for (int phase = 0; phase < v4l2_shim::kNumPhases; ++phase) {
      const double deviation = Deviation(pixels, channels, param.border, param.truth, phase);
      if (deviation < least) best = phase;
      least = std::min(least, deviation);
    }
    EXPECT_LE(least, param.tolerance);
    phases.insert(best);
  };
  ASSERT_TRUE(live.GrabFrames(12)) << live.Summary();
  EXPECT_EQ(live.status().num_bad, 0) << live.Summary();
  EXPECT_GT(phases.size(), 2U);  // It moves.
}

INSTANTIATE_TEST_SUITE_P(
    All,
    ColorFormats,
    testing::Values(
        ColorCase{"Yuyv", "YUYV", "", PixelLayout::kRgb8, RgbOfYuv, 1.0},
        ColorCase{"YuyvPadded", "YUYV", "padding 24", PixelLayout::kRgb8, RgbOfYuv, 1.0},
        ColorCase{"YuyvToGray", "YUYV", "", PixelLayout::kGray8, LumaOfYuv, 1.0},
        ColorCase{"Uyvy", "UYVY", "", PixelLayout::kRgb8, RgbOfYuv, 1.0},
        ColorCase{"UyvyToGray", "UYVY", "padding 8", PixelLayout::kGray8, LumaOfYuv, 1.0},
        ColorCase{"Grey", "GREY", "", PixelLayout::kGray8, Gray, 0.0},
        ColorCase{"GreyPadded", "GREY", "padding 3", PixelLayout::kGray8, Gray, 0.0},
        ColorCase{"GreyToRgb", "GREY", "", PixelLayout::kRgb8, Gray, 0.0},
        ColorCase{"Bayer", "GRBG", "", PixelLayout::kRgb8, Smooth, 2.0, 2},
        ColorCase{"BayerPadded", "GRBG", "padding 5", PixelLayout::kRgb8, Smooth, 2.0, 2},
        ColorCase{"BayerToGray", "GRBG", "", PixelLayout::kGray8, SmoothLuma, 2.5, 2},
        ColorCase{"Mjpeg", "MJPG", "", PixelLayout::kRgb8, Smooth, 8.0},
        ColorCase{"MjpegWithoutTables", "MJPG", "jpeg_tables no", PixelLayout::kRgb8, Smooth, 8.0},
        ColorCase{"MjpegToGray", "MJPG", "", PixelLayout::kGray8, SmoothLuma, 6.0},
        ColorCase{"MjpegAsItCame", "MJPG", "", PixelLayout::kJpeg, Smooth, 8.0}),
    [](const auto& each) { return each.param.name; });

double DepthMm(int x, int y, int phase) { return v4l2_shim::DepthValue(x, y, phase); }

// Rounded to the nearest millimetre.
double TenthsOfMillimetres(int x, int y, int phase) {
  return std::floor(0.1 * v4l2_shim::DepthValue(x, y, phase) + 0.5);
}

// z = b f / (disparity in px), an eighth of a px a step from 1090 on.
double KinectMm(int x, int y, int phase) {
  const int d = v4l2_shim::DisparityValue(x, y, phase);
  return d == v4l2_shim::kNoDisparity ? 0.0 : std::round(75.0 * 580.0 / ((1090.0 - d) / 8.0));
}

struct DepthCase {
  std::string name;
  std::string fourcc;
  std::string more;
  int unit_um = 1000;
  std::function<double(int x, int y, int phase)> truth;
};
void PrintTo(const DepthCase& each, std::ostream* out) { *out << each.name; }

class DepthFormats : public testing::TestWithParam<DepthCase> {};

TEST_P(DepthFormats, EveryPixelIsThatOfTheScene) {
  const DepthCase& param = GetParam();
  const EmulatedDevices devices;
  devices.Describe(DeviceZero(SmallFormat(param.fourcc) + param.more));
  LiveCamera::Settings settings;
  settings.v4l2.pixel_format = param.fourcc;
  settings.v4l2.depth_unit_um = param.unit_um;
  LiveCamera live(settings);
  live.on_frame = [&](const CameraFrame& frame) {
    ASSERT_FALSE(frame.color.has_value());
    ASSERT_EQ(frame.depth_mm.size(), size_t{kWidth} * kHeight);
    int64_t fewest_wrong = kWidth * kHeight;
    for (int phase = 0; phase < v4l2_shim::kNumPhases; ++phase) {
      int64_t wrong = 0;
      for (int i = 0; i < kWidth * kHeight; ++i) {
        const double truth = param.truth(i % kWidth, i / kWidth, phase);
        if (std::abs(frame.depth_mm[static_cast<size_t>(i)] - truth) > 0.0) ++wrong;
      }
      fewest_wrong = std::min(fewest_wrong, wrong);
    }
    EXPECT_EQ(fewest_wrong, 0);
  };
  ASSERT_TRUE(live.GrabFrames(12)) << live.Summary();
  EXPECT_EQ(live.status().num_bad, 0) << live.Summary();
}

INSTANTIATE_TEST_SUITE_P(
    All,
    DepthFormats,
    testing::Values(DepthCase{"Z16", "Z16", "", 1000, DepthMm},
                    DepthCase{"Z16Padded", "Z16", "padding 32", 1000, DepthMm},
                    DepthCase{"Z16Tenths", "Z16", "", 100, TenthsOfMillimetres},
                    DepthCase{"Y16", "Y16", "", 1000, DepthMm},
                    DepthCase{"Y10Packed", "Y10B", "", 1000, KinectMm},
                    DepthCase{"Y10PackedPadded", "Y10B", "padding 7", 1000, KinectMm}),
    [](const auto& each) { return each.param.name; });

// Frames of a file, in their order.
TEST(RecordedFrames, AreShownInTurn) {
  const EmulatedDevices devices;
  {
    std::ofstream file(devices.folder() / "frames", std::ios::binary);
    for (const char low : {'\1', '\2', '\3'}) {
      for (int i = 0; i < kWidth * kHeight; ++i) file.put(low).put('\3');
    }
  }
  devices.Describe(
      DeviceZero(SmallFormat("Z16") + "frames " + (devices.folder() / "frames").string()));
  LiveCamera live;
  std::set<uint16_t> seen;
  live.on_frame = [&](const CameraFrame& frame) {
    EXPECT_EQ(frame.depth_mm, std::vector<uint16_t>(kWidth * kHeight, frame.depth_mm[0]));
    seen.insert(frame.depth_mm[0]);
  };
  ASSERT_TRUE(live.GrabUntil([&] { return seen.size() == 3; })) << live.Summary();
  EXPECT_EQ(seen, (std::set<uint16_t>{0x301, 0x302, 0x303}));
}

}  // namespace
}  // namespace vantage
