#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <vector>

#include "drivers/sim/sensor_model.h"

namespace vantage {
namespace {

constexpr double kFocalBaseline = 570.34 * 0.075;  // px m

SensorModelParameters AllOff() {
  SensorModelParameters parameters;
  parameters.SwitchAllOff();
  return parameters;
}

RenderedView EmptyView(const CameraModel& camera = {}) {
  RenderedView view;
  view.camera = camera;
  view.window = WholeImage(camera);
  view.depth = DepthImage(camera.width, camera.height);
  view.cos_incidence.assign(view.depth.depth.size(), 0.0F);
  view.surface.assign(view.depth.depth.size(), RenderedView::kNoSurface);
  return view;
}

/// A plane across the optical axis at z m, all rays taken to meet it at an angle of incidence.
RenderedView Wall(double z, double angle = 0.0) {
  RenderedView view = EmptyView();
  std::fill(view.depth.depth.begin(), view.depth.depth.end(), static_cast<float>(z));
  std::fill(
      view.cos_incidence.begin(), view.cos_incidence.end(), static_cast<float>(std::cos(angle)));
  std::fill(view.surface.begin(), view.surface.end(), 0U);
  return view;
}

/// A wall with a nearer strip over columns u0..u1.
RenderedView Strip(double z_near, double z_far, int u0, int u1) {
  RenderedView view = Wall(z_far);
  for (int v = 0; v < view.depth.height; ++v) {
    for (int u = u0; u <= u1; ++u) {
      view.depth.at(u, v) = static_cast<float>(z_near);
      view.surface[view.depth.Index(u, v)] = 1;
    }
  }
  return view;
}

DepthImage Measure(const SensorModelParameters& parameters,
                   const RenderedView& view,
                   int64_t frame = 0,
                   double time = 0.0) {
  SensorModel model(parameters, view.camera);
  DepthImage measured;
  model.Measure(view, frame, time, &measured);
  return measured;
}

double Sigma(const DepthImage& image) {
  double sum = 0.0;
  double squares = 0.0;
  double count = 0.0;
  for (const float z : image.depth) {
    if (std::isnan(z)) continue;
    sum += static_cast<double>(z);
    squares += static_cast<double>(z) * static_cast<double>(z);
    count += 1.0;
  }
  return std::sqrt(squares / count - sum * sum / count / count);
}

size_t CountInvalid(const DepthImage& image) {
  return static_cast<size_t>(
      std::count_if(image.depth.begin(), image.depth.end(), [](float z) { return std::isnan(z); }));
}

TEST(SensorModel, AllOffIsExactlyTheIdealDepth) {
  RenderedView view = Strip(0.61, 1.37, 200, 300);
  for (int u = 0; u < 640; ++u) view.depth.at(u, 10) = DepthImage::kInvalid;
  const DepthImage measured = Measure(AllOff(), view);
  EXPECT_EQ(
      0,
      std::memcmp(
          measured.depth.data(), view.depth.depth.data(), measured.depth.size() * sizeof(float)));
}

TEST(SensorModel, NothingOutsideTheRange) {
  const SensorModelParameters parameters = AllOff();
  EXPECT_EQ(CountInvalid(Measure(parameters, Wall(0.39))), 640U * 480U);
  EXPECT_EQ(CountInvalid(Measure(parameters, Wall(0.41))), 0U);
  EXPECT_EQ(CountInvalid(Measure(parameters, Wall(3.99))), 0U);
  EXPECT_EQ(CountInvalid(Measure(parameters, Wall(4.01))), 640U * 480U);
}

TEST(SensorModel, QuantizationStepsAreEighthsOfADisparity) {
  SensorModelParameters parameters = AllOff();
  parameters.quantization = true;
  RenderedView view = Wall(1.0);
  for (int u = 0; u < 640; ++u) {  // 0.95 .. 1.05 m
    for (int v = 0; v < 480; ++v)
      view.depth.at(u, v) = 0.95F + 0.1F * static_cast<float>(u) / 640.0F;
  }
  const DepthImage measured = Measure(parameters, view);
  std::set<float> values;
  for (int u = 0; u < 640; ++u) {
    const double z = static_cast<double>(measured.at(u, 100));
    const double steps = kFocalBaseline / z * 8.0;
    EXPECT_NEAR(steps, std::round(steps), 1e-3);
    const double truth = static_cast<double>(view.depth.at(u, 100));
    EXPECT_LE(std::abs(z - truth), 0.51 * truth * truth / (8.0 * kFocalBaseline));
    values.insert(measured.at(u, 100));
  }
  for (auto i = values.begin(); std::next(i) != values.end(); ++i) {
    const double z = static_cast<double>(*i);
    const double gap = static_cast<double>(*std::next(i)) - z;
    EXPECT_NEAR(gap, z * z / (8.0 * kFocalBaseline), 2e-5);  // 2.9 mm at 1 m
  }
}

TEST(SensorModel, AxialNoiseWithQuantizationFollowsKhoshelhamAndElberink) {
  SensorModelParameters parameters = AllOff();
  parameters.axial_noise = true;
  parameters.quantization = true;
  for (const double z : {0.6, 1.0, 1.5, 2.2, 3.0}) {
    // Several nearby distances: at a single one the quantiser's phase matters.
    double variance = 0.0;
    constexpr int kPhases = 8;
    for (int i = 0; i < kPhases; ++i) {
      const double truth = kFocalBaseline / (kFocalBaseline / z + i * 0.125 / kPhases);
      const DepthImage measured = Measure(parameters, Wall(truth), i);
      double sum = 0.0;
      for (const float value : measured.depth) {
        const double error = static_cast<double>(value) - truth;
        sum += error * error;
      }
      variance += sum / static_cast<double>(measured.depth.size()) / kPhases;
    }
    EXPECT_NEAR(std::sqrt(variance) / (1.425e-3 * z * z), 1.0, 0.06) << "at " << z << " m";
  }
}

TEST(SensorModel, AxialNoiseIsCorrelatedOverNeighboursAndNotOverFrames) {
  SensorModelParameters parameters = AllOff();
  parameters.axial_noise = true;
  const RenderedView wall = Wall(1.0);
  SensorModel model(parameters, wall.camera);
  DepthImage first;
  DepthImage second;
  model.Measure(wall, 1, 0.0, &first);
  model.Measure(wall, 2, 0.0, &second);
  const auto correlation = [](const DepthImage& a, const DepthImage& b, int shift) {
    double ab = 0.0;
    double aa = 0.0;
    double bb = 0.0;
    for (int v = 0; v < 480; ++v) {
      for (int u = 0; u + shift < 640; ++u) {
        const double x = static_cast<double>(a.at(u, v)) - 1.0;
        const double y = static_cast<double>(b.at(u + shift, v)) - 1.0;
        ab += x * y;
        aa += x * x;
        bb += y * y;
      }
    }
    return ab / std::sqrt(aa * bb);
  };
  // White noise smoothed by a Gaussian of sigma s has correlation exp(-x^2 / (4 s^2)).
  for (const int shift : {1, 2, 3, 12}) {
    EXPECT_NEAR(correlation(first, first, shift), std::exp(-shift * shift / 9.0), 0.03) << shift;
  }
  EXPECT_NEAR(correlation(first, second, 0), 0.0, 0.03);
}

TEST(SensorModel, GrazingNoiseAddsNguyensTerm) {
  SensorModelParameters parameters = AllOff();
  parameters.axial_noise = true;
  const double angle = 80.0 * kDegree;
  const double slant = angle / (90.0 * kDegree - angle);
  const double plain = parameters.axial_sigma / kFocalBaseline;  // m at 1 m
  EXPECT_NEAR(Sigma(Measure(parameters, Wall(1.0, 50.0 * kDegree))) / plain, 1.0, 0.05);
  EXPECT_NEAR(
      Sigma(Measure(parameters, Wall(1.0, angle))) / (plain + 1e-4 * slant * slant), 1.0, 0.06);
}

TEST(SensorModel, ShadowIsAsWideAsTheBaselineSays) {
  SensorModelParameters parameters = AllOff();
  parameters.shadow = true;
  for (const auto& [z_near, z_far] : {std::pair{0.6, 0.8}, {0.7, 1.4}, {1.0, 1.2}, {1.5, 3.5}}) {
    const DepthImage measured = Measure(parameters, Strip(z_near, z_far, 300, 450));
    const double expected = kFocalBaseline * (1.0 / z_near - 1.0 / z_far);
    int width = 0;
    for (int u = 0; u < 640; ++u) {
      if (!std::isnan(measured.at(u, 240))) continue;
      ++width;
      EXPECT_LT(u, 300);  // Left of the strip, the projector being on the right.
      EXPECT_GE(u, 299 - static_cast<int>(expected + 1.0));
    }
    EXPECT_NEAR(width, expected, 1.01) << z_near << " before " << z_far;
  }
}

TEST(SensorModel, ThinObjectsShadeOnlyTheirOwnWidth) {
  SensorModelParameters parameters = AllOff();
  parameters.shadow = true;
  // 5 px wide and a shadow 30 px away from it: the projector sees past it on both sides.
  const DepthImage measured = Measure(parameters, Strip(0.7, 1.4, 300, 304));
  const double shift = kFocalBaseline * (1.0 / 0.7 - 1.0 / 1.4);
  int width = 0;
  for (int u = 0; u < 640; ++u) {
    if (!std::isnan(measured.at(u, 240))) continue;
    ++width;
    EXPECT_NEAR(u, 302.0 - shift, 3.6);
  }
  EXPECT_NEAR(width, 5, 1);
}

TEST(SensorModel, SlantedSurfacesDoNotShadeThemselves) {
  SensorModelParameters parameters = AllOff();
  parameters.shadow = true;
  for (const double slope : {-1.5, -0.8, 0.8, 1.5}) {  // dz/dx of a plane through (0, 0, 1)
    RenderedView view = Wall(1.0);
    for (int v = 0; v < 480; ++v) {
      for (int u = 0; u < 640; ++u) {
        const double x = (u - 319.5) / 570.34;
        view.depth.at(u, v) = static_cast<float>(1.0 / (1.0 - slope * x));
      }
    }
    parameters.farthest = 100.0;
    parameters.nearest = 0.1;
    EXPECT_EQ(CountInvalid(Measure(parameters, view)), 0U) << slope;
  }
}

TEST(SensorModel, LateralNoiseMovesEdgesByNguyensSigma) {
  SensorModelParameters parameters = AllOff();
  parameters.lateral_noise = true;
  const RenderedView view = Strip(0.8, 1.2, 300, 450);
  SensorModel model(parameters, view.camera);
  DepthImage measured;
  // The share of pixels x px inside the edge that show the background is P(N(0, 0.8) < -x).
  std::array<double, 4> background{};
  constexpr int kFrames = 20;
  for (int frame = 0; frame < kFrames; ++frame) {
    model.Measure(view, frame, 0.0, &measured);
    for (int v = 0; v < 480; ++v) {
      for (size_t x = 0; x < background.size(); ++x) {
        const float z = measured.at(300 + static_cast<int>(x), v);
        ASSERT_TRUE(z == 0.8F || z == 1.2F);
        if (z == 1.2F) background[x] += 1.0 / (480.0 * kFrames);
      }
      ASSERT_EQ(measured.at(100, v), 1.2F);  // No noise inside a surface.
      ASSERT_EQ(measured.at(375, v), 0.8F);
    }
  }
  for (size_t x = 0; x < background.size(); ++x) {
    const double distance = static_cast<double>(x) + 0.5;
    EXPECT_NEAR(background[x], 0.5 * std::erfc(distance / (0.8 * std::sqrt(2.0))), 0.03) << x;
  }
}

TEST(SensorModel, DropoutsRiseBeyondTheGrazingAngle) {
  SensorModelParameters parameters = AllOff();
  parameters.grazing_dropout = true;
  const auto share = [&](double angle_deg) {
    double sum = 0.0;
    for (int frame = 0; frame < 4; ++frame) {
      sum += static_cast<double>(
          CountInvalid(Measure(parameters, Wall(1.0, angle_deg * kDegree), frame)));
    }
    return sum / (4.0 * 640.0 * 480.0);
  };
  EXPECT_EQ(share(74.0), 0.0);
  EXPECT_NEAR(share(80.0), 5.0 / 13.0, 0.04);
  EXPECT_NEAR(share(84.0), 9.0 / 13.0, 0.04);
  EXPECT_EQ(share(89.5), 1.0);
}

TEST(SensorModel, BiasIsSmoothBoundedAndTheDevicesOwn) {
  SensorModelParameters parameters = AllOff();
  parameters.bias = true;
  parameters.device_id = DeviceIdFromSerial("SIM0001");
  const DepthImage one = Measure(parameters, Wall(1.0), 3, 10.0);
  double largest = 0.0;
  for (int v = 0; v < 480; ++v) {
    for (int u = 1; u < 640; ++u) {
      const double error = static_cast<double>(one.at(u, v)) - 1.0;
      largest = std::max(largest, std::abs(error));
      ASSERT_LT(std::abs(static_cast<double>(one.at(u, v) - one.at(u - 1, v))), 5e-5);
    }
  }
  EXPECT_LT(largest, 1.01e-3);
  EXPECT_GT(largest, 2e-4);

  const DepthImage again = Measure(parameters, Wall(1.0), 900, 10.0);
  EXPECT_EQ(one.depth, again.depth);  // Not noise: the same in another frame.
  const auto difference = [&one](const DepthImage& other) {
    double sum = 0.0;
    for (size_t i = 0; i < one.depth.size(); ++i) {
      sum += std::abs(static_cast<double>(one.depth[i] - other.depth[i]));
    }
    return sum / static_cast<double>(one.depth.size());
  };
  EXPECT_LT(difference(Measure(parameters, Wall(1.0), 3, 11.0)), 2e-5);
  EXPECT_GT(difference(Measure(parameters, Wall(1.0), 3, 400.0)), 1e-4);
  parameters.device_id = DeviceIdFromSerial("SIM0002");
  EXPECT_GT(difference(Measure(parameters, Wall(1.0), 3, 10.0)), 1e-4);
}

TEST(SensorModel, BiasGrowsWithTheSquareOfDepth) {
  SensorModelParameters parameters = AllOff();
  parameters.bias = true;
  SensorModel model(parameters, CameraModel{});
  DepthImage measured;
  for (const double z : {0.7, 1.3, 2.6}) {
    const double disparity = kFocalBaseline / z;
    model.Measure(Wall(z), 0, 0.0, &measured);
    const double expected = -z * z / kFocalBaseline * model.BiasDisparity(160, 96, disparity, 0.0);
    EXPECT_NEAR(
        static_cast<double>(measured.at(160, 96)) - z, expected, 3e-6 + 0.002 * std::abs(expected));
    EXPECT_LE(std::abs(expected), 1e-3 * z * z);
  }
}

TEST(SensorModel, AFrameDoesNotDependOnThoseBefore) {
  SensorModelParameters parameters;
  const RenderedView view = Strip(0.8, 1.2, 300, 450);
  SensorModel model(parameters, view.camera);
  DepthImage first;
  DepthImage other;
  DepthImage again;
  model.Measure(view, 5, 1.0, &first);
  model.Measure(Wall(2.0), 6, 1.1, &other);
  model.Measure(view, 5, 1.0, &again);
  EXPECT_EQ(
      0, std::memcmp(first.depth.data(), again.depth.data(), first.depth.size() * sizeof(float)));
  model.Measure(view, 6, 1.0, &other);
  EXPECT_NE(
      0, std::memcmp(first.depth.data(), other.depth.data(), first.depth.size() * sizeof(float)));
  const DepthImage same_seed = Measure(parameters, view, 5, 1.0);
  EXPECT_EQ(
      0,
      std::memcmp(first.depth.data(), same_seed.depth.data(), first.depth.size() * sizeof(float)));
}

TEST(SensorModel, HalfResolutionHasTheSameNoiseInDepth) {
  SensorModelParameters parameters = AllOff();
  parameters.axial_noise = true;
  const CameraModel half = CameraModel{}.Scaled(0.5);
  RenderedView view = EmptyView(half);
  std::fill(view.depth.depth.begin(), view.depth.depth.end(), 1.0F);
  std::fill(view.cos_incidence.begin(), view.cos_incidence.end(), 1.0F);
  EXPECT_NEAR(
      Sigma(Measure(parameters, view)) * kFocalBaseline / parameters.axial_sigma, 1.0, 0.05);
}

TEST(SensorModelParameters, ValidateNamesTheBound) {
  EXPECT_TRUE(SensorModelParameters{}.Validate().ok());
  SensorModelParameters parameters;
  parameters.farthest = 0.3;
  const Result<void> wrong = parameters.Validate();
  ASSERT_FALSE(wrong.ok());
  EXPECT_NE(wrong.error().message.find("farthest = 0.3, expected 0.4"), std::string::npos);
  parameters = {};
  parameters.axial_sigma = std::nan("");
  EXPECT_FALSE(parameters.Validate().ok());
}

}  // namespace
}  // namespace vantage
