#include "drivers/camera/undistortion.h"

#include <cmath>

#include "common/check.h"

namespace vantage {

std::vector<int32_t> UndistortionMap(const CameraModel& camera, const BrownConrady& distortion) {
  const auto [k1, k2, p1, p2, k3] = distortion;
  std::vector<int32_t> map;
  map.reserve(static_cast<size_t>(camera.width) * static_cast<size_t>(camera.height));
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const double x = (u - camera.cx) / camera.fx;
      const double y = (v - camera.cy) / camera.fy;
      const double r2 = x * x + y * y;
      const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
      const double x_lens = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
      const double y_lens = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
      const double u_lens = std::round(camera.fx * x_lens + camera.cx);
      const double v_lens = std::round(camera.fy * y_lens + camera.cy);
      const bool inside =
          u_lens >= 0.0 && v_lens >= 0.0 && u_lens < camera.width && v_lens < camera.height;
      map.push_back(
          inside ? static_cast<int32_t>(v_lens) * camera.width + static_cast<int32_t>(u_lens) : -1);
    }
  }
  return map;
}

std::vector<uint16_t> Undistort(std::span<const uint16_t> depth, std::span<const int32_t> map) {
  VANTAGE_CHECK(depth.size() == map.size(), "an undistortion map of another size");
  std::vector<uint16_t> ideal(map.size(), 0);
  for (size_t i = 0; i < map.size(); ++i) {
    if (map[i] >= 0) ideal[i] = depth[static_cast<size_t>(map[i])];
  }
  return ideal;
}

}  // namespace vantage
