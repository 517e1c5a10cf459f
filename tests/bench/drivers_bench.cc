// What the camera process does with every frame: the clock filter's update, the copy out of the
// device's buffer, and the depth's way onto the wire and off it.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "bus/image_conversion.h"
#include "bus/message_check.h"
#include "common/rng.h"
#include "drivers/camera/frame_conversion.h"
#include "drivers/clock/clock_filter.h"

namespace vantage {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;

// A table seen at 45 degrees from 0.75 m with boxes on it, as a structured-light camera gives it:
// depth in steps of its disparity (focal length 570 px, baseline 75 mm, 1/8 px), noise of half a
// step that is alike over a few pixels, shadows left of the boxes, dropouts.
std::vector<uint16_t> TableFrame() {
  Rng rng(1);
  constexpr double kDisparityScale = 8.0 * 570.0 * 75.0;  // mm * 1/8 px
  std::vector<uint16_t> millimetres(static_cast<size_t>(kWidth) * kHeight, 0);
  double noise = 0.0;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      if (u % 5 == 0) noise = 0.5 * rng.Normal();
      const int box_u = u % 200;
      const bool box = box_u > 100 && box_u < 160 && v > 150 && v < 300;
      const bool shadow = box_u > 90 && box_u <= 100 && v > 150 && v < 300;
      if (shadow || rng.Uniform() < 0.003) continue;
      double depth = 750.0 / (1.0 + 0.9 * (v - 240) / 570.0);
      if (box) depth -= 60.0;
      const double disparity = std::round(kDisparityScale / depth + noise);
      millimetres[static_cast<size_t>(v) * kWidth + static_cast<size_t>(u)] =
          static_cast<uint16_t>(std::lround(kDisparityScale / disparity));
    }
  }
  return millimetres;
}

void DepthToWire(benchmark::State& state, DepthCompression compression) {
  const std::vector<uint16_t> frame = TableFrame();
  size_t bytes = 0;
  for (auto _ : state) {
    const images_t message = DepthToMessage(kWidth, kHeight, frame, 1, 1, "SIM0001", compression);
    bytes = Encode(message).size();
    benchmark::DoNotOptimize(bytes);
  }
  state.counters["kilobytes"] = 1e-3 * static_cast<double>(bytes);
}
BENCHMARK_CAPTURE(DepthToWire, zlib1, DepthCompression::kZlib)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(DepthToWire, vdc, DepthCompression::kVdc)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(DepthToWire, none, DepthCompression::kNone)->Unit(benchmark::kMillisecond);

void DepthFromWire(benchmark::State& state, DepthCompression compression) {
  const std::vector<std::byte> bytes =
      Encode(DepthToMessage(kWidth, kHeight, TableFrame(), 1, 1, "SIM0001", compression));
  for (auto _ : state) {
    const Result<images_t> message = DecodeChecked<images_t>(bytes);
    const Result<DepthFrame> frame = DepthFrameFromMessage(*message);
    benchmark::DoNotOptimize(frame->image.depth.data());
  }
}
BENCHMARK_CAPTURE(DepthFromWire, zlib1, DepthCompression::kZlib)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(DepthFromWire, vdc, DepthCompression::kVdc)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(DepthFromWire, none, DepthCompression::kNone)->Unit(benchmark::kMillisecond);

void FrameCopy(benchmark::State& state) {
  const std::vector<uint16_t> frame = TableFrame();
  StreamDetails details;
  details.width = kWidth;
  details.height = kHeight;
  details.mirrored = state.range(0) != 0;
  RawFrame raw;
  RawImage& depth = raw.depth.emplace();
  depth.width = kWidth;
  depth.height = kHeight;
  depth.stride_bytes = 2 * kWidth;
  depth.data = std::as_bytes(std::span(frame));
  for (auto _ : state) {
    if (!FrameFault(raw, details).empty()) state.SkipWithError("the frame is sound");
    benchmark::DoNotOptimize(DepthMillimetres(depth, details).data());
  }
}
BENCHMARK(FrameCopy)->ArgName("mirrored")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

// A minute at 30 Hz with jitter and stalls, over and over; the time is that of one update.
void ClockFilterUpdate(benchmark::State& state) {
  constexpr int64_t kPeriod = 33'333;  // us
  constexpr int kFrames = 1800;
  Rng rng(2);
  std::vector<int64_t> latencies;
  for (int i = 0; i < kFrames; ++i) {
    const double jitter = -2000.0 * std::log(1.0 - rng.Uniform());
    latencies.push_back(4000 + static_cast<int64_t>(jitter) + (rng.Uniform() < 0.004 ? 25'000 : 0));
  }
  ClockFilter filter;
  int64_t i = 0;
  double worst_us = 0.0;
  for (auto _ : state) {
    const int64_t exposure = kPeriod * i;
    const int64_t device = exposure + exposure / 10'000;  // 100 ppm fast
    const int64_t utime =
        filter.Update(device, exposure + latencies[static_cast<size_t>(i % kFrames)]);
    if (i > 300)
      worst_us = std::max(worst_us, std::abs(static_cast<double>(utime - exposure) - 4000.0));
    ++i;
  }
  // From the true time plus the least latency, after ten seconds.
  state.counters["worst_error_us"] = worst_us;
}
BENCHMARK(ClockFilterUpdate)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace vantage
