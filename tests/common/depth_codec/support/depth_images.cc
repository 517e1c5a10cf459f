#include "tests/common/depth_codec/support/depth_images.h"

#include <cmath>
#include <functional>

#include "common/format.h"

namespace vantage {
namespace {

TestDepth Make(const std::string& name,
               int width,
               int height,
               const std::function<uint32_t(int u, int v)>& value) {
  TestDepth image{Format("%s %d x %d", name.c_str(), width, height), width, height, {}};
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) image.depth.push_back(static_cast<uint16_t>(value(u, v)));
  }
  return image;
}

}  // namespace

TestDepth StructuredLightDepth(int width, int height, double sigma, Rng& rng) {
  constexpr double kDisparityScale = 8.0 * 570.0 * 75.0;  // mm * 1/8 px
  return Make("structured light", width, height, [&](int u, int v) -> uint32_t {
    const bool box = u % 200 > 100 && u % 200 < 160 && v > height / 3 && v < height * 2 / 3;
    const bool shadow = u % 200 > 90 && u % 200 <= 100 && v > height / 3 && v < height * 2 / 3;
    const double noise = sigma * rng.Normal();
    if (shadow || rng.Uniform() < 0.002) return 0;
    const double depth = 750.0 / (1.0 + 0.9 * (v - 0.5 * height) / 570.0) - (box ? 60.0 : 0.0);
    return static_cast<uint32_t>(
        std::lround(kDisparityScale / std::round(kDisparityScale / depth + noise)));
  });
}

std::vector<TestDepth> AdversarialDepths(Rng& rng) {
  std::vector<TestDepth> images;
  const std::vector<std::pair<int, int>> sizes = {{1, 1},
                                                  {1, 2},
                                                  {2, 1},
                                                  {31, 3},
                                                  {32, 2},
                                                  {33, 5},
                                                  {64, 1},
                                                  {65, 65},
                                                  {1, 100},
                                                  {500, 1},
                                                  {97, 41}};
  for (const auto& size : sizes) {
    const int width = size.first;
    const int height = size.second;
    const auto add = [&](const char* name, auto value) {
      images.push_back(Make(name, width, height, value));
    };
    add("nothing", [](int, int) { return 0U; });
    add("constant", [](int, int) { return 65535U; });
    add("noise", [&](int, int) { return rng.NextUint32(); });
    add("holes", [&](int, int) { return rng.Below(2) * (900 + rng.Below(3)); });
    add("few values", [&](int, int) { return rng.Below(9) * 7000; });
    add("checkers", [](int u, int v) { return (u + v) % 2 == 0 ? 1U : 65535U; });
    add("checkers of nothing", [](int u, int v) { return (u + v) % 2 == 0 ? 0U : 800U; });
    add("island", [&](int u, int v) {
      const bool inside = u >= width / 3 && u <= width / 2 && v >= height / 4 && v <= height / 2;
      return inside ? rng.Below(3) * 5 + 700 : 0U;
    });
    add("last pixel", [&](int u, int v) { return u == width - 1 && v == height - 1 ? 900U : 0U; });
    add("ramp", [](int u, int v) { return static_cast<uint32_t>(1 + 3 * u + 5 * v); });
    add("steep ramp", [](int u, int v) { return static_cast<uint32_t>(977 * u + 3001 * v); });
    add("outliers", [&](int u, int) {
      return rng.Below(10) == 0 ? rng.NextUint32() : static_cast<uint32_t>(800 + u / 4);
    });
  }
  images.push_back(Make("all values", 256, 256, [](int u, int v) {
    return static_cast<uint32_t>(u * 256 + v) * 40503U;
  }));
  images.push_back(Make("all values in order", 256, 256, [](int u, int v) {
    return static_cast<uint32_t>(u + 256 * v);
  }));
  // Ranks wrap around as signed numbers: neighbours far apart, smooth within.
  images.push_back(Make("two slopes", 512, 200, [](int u, int v) {
    return static_cast<uint32_t>(u < 256 ? 1 + u * 100 + v : 65535 - u * 50 - v);
  }));
  return images;
}

}  // namespace vantage
