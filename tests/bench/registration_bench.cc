// Depth registered to color, color to depth, distortion taken out; beside OpenCV.
// `within_2_mm_pct`: share of the color image's pixels that are that near to the truth, hidden ones
// and all.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdlib>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/rgbd/depth.hpp>
#include <vector>

#include "drivers/camera/color_registration.h"
#include "drivers/camera/depth_registration.h"
#include "drivers/camera/undistortion.h"
#include "tests/drivers/camera/traced_scene.h"

namespace vantage {
namespace {

const LensDistortion kLens{.k1 = 0.18, .k2 = -0.36, .p1 = 0.001, .p2 = -0.002, .k3 = 0.0};
const CameraModel kDepth;

CameraModel ColorModel(int scale) { return CameraModel{.fx = 525.0, .fy = 525.0}.Scaled(scale); }

Pose ColorFromDepth() {
  Pose pose = Pose::Identity();
  pose.linear() = ExpSo3({0.002, -0.005, 0.001}).toRotationMatrix();
  pose.translation() << -0.025, 0.001, 0.002;
  return pose;
}

std::vector<uint16_t> DepthFrame() {
  return ToMillimetres(TracedScene().Render({kDepth, {}}, Pose::Identity()));
}

double WithinTwoMillimetresPct(const CameraModel& color, const uint16_t* registered) {
  const std::vector<double> truth = TracedScene().Render({color, {}}, ColorFromDepth());
  size_t num_within = 0;
  for (size_t i = 0; i < truth.size(); ++i) {
    if (std::abs(registered[i] - 1e3 * truth[i]) <= 2.0) ++num_within;
  }
  return 100.0 * static_cast<double>(num_within) / static_cast<double>(truth.size());
}

cv::Matx33d Matrix(const CameraModel& camera) {
  return {camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0};
}

void DepthToColor(benchmark::State& state) {
  const CameraModel color = ColorModel(static_cast<int>(state.range(0)));
  const std::vector<uint16_t> depth = DepthFrame();
  DepthRegistration registration({kDepth, {}}, color, ColorFromDepth());
  std::vector<uint16_t> registered;
  for (auto _ : state) {
    registration.Register(depth, &registered);
    benchmark::DoNotOptimize(registered.data());
  }
  state.counters["within_2_mm_pct"] = WithinTwoMillimetresPct(color, registered.data());
}
BENCHMARK(DepthToColor)->ArgName("scale")->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond);

void DepthToColorByOpenCv(benchmark::State& state) {
  const CameraModel color = ColorModel(static_cast<int>(state.range(0)));
  std::vector<uint16_t> depth = DepthFrame();
  const cv::Mat image(kDepth.height, kDepth.width, CV_16U, depth.data());
  const Pose pose = ColorFromDepth();
  cv::Matx44d transform;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) transform(i, j) = pose.matrix()(i, j);
  }
  cv::Mat registered;
  for (auto _ : state) {
    cv::rgbd::registerDepth(Matrix(kDepth),
                            Matrix(color),
                            cv::Mat(),
                            transform,
                            image,
                            cv::Size(color.width, color.height),
                            registered,
                            true);
    benchmark::DoNotOptimize(registered.data);
  }
  state.counters["within_2_mm_pct"] = WithinTwoMillimetresPct(color, registered.ptr<uint16_t>());
}
BENCHMARK(DepthToColorByOpenCv)->ArgName("scale")->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond);

void ColorToDepth(benchmark::State& state) {
  const CameraModel color = ColorModel(1);
  const std::vector<uint16_t> depth = DepthFrame();
  const std::vector<uint8_t> pixels(3 * depth.size(), 100);
  ColorRegistration registration(kDepth, {color, kLens}, ColorFromDepth());
  std::vector<uint8_t> registered;
  for (auto _ : state) {
    registration.Register(depth, 3, pixels, &registered);
    benchmark::DoNotOptimize(registered.data());
  }
}
BENCHMARK(ColorToDepth)->Unit(benchmark::kMillisecond);

void UndistortImage(benchmark::State& state) {
  const int channels = static_cast<int>(state.range(0));
  ImageUndistortion undistortion({ColorModel(1), kLens});
  const std::vector<uint8_t> given(static_cast<size_t>(channels) * 640 * 480, 100);
  std::vector<uint8_t> pixels;
  for (auto _ : state) {
    pixels = given;
    undistortion.Undistort(channels, &pixels);
    benchmark::DoNotOptimize(pixels.data());
  }
}
BENCHMARK(UndistortImage)->ArgName("channels")->Arg(1)->Arg(3)->Unit(benchmark::kMillisecond);

// As OpenCV's undistort() does for a known camera: maps made once, then remap().
void UndistortImageByOpenCv(benchmark::State& state) {
  const int channels = static_cast<int>(state.range(0));
  const CameraModel color = ColorModel(1);
  const cv::Vec<double, 5> lens(kLens.k1, kLens.k2, kLens.p1, kLens.p2, kLens.k3);
  const cv::Size size(color.width, color.height);
  const cv::Mat given(size, CV_8UC(channels), cv::Scalar::all(100));
  cv::setNumThreads(1);
  cv::Mat places;
  cv::Mat shares;
  cv::initUndistortRectifyMap(
      Matrix(color), lens, cv::Mat(), Matrix(color), size, CV_16SC2, places, shares);
  cv::Mat pixels;
  for (auto _ : state) {
    cv::remap(given, pixels, places, shares, cv::INTER_LINEAR);
    benchmark::DoNotOptimize(pixels.data);
  }
}
BENCHMARK(UndistortImageByOpenCv)
    ->ArgName("channels")
    ->Arg(1)
    ->Arg(3)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace vantage
