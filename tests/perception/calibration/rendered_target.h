#pragma once

#include <algorithm>
#include <cmath>

#include "common/camera_model.h"
#include "common/rng.h"
#include "common/so3.h"
#include "perception/calibration/calibration_target.h"

namespace vantage {

/// How a test's camera spoils what it sees.
struct ImageFlaws {
  int blur = 0;        ///< px, side of a box that is averaged over is 1 + 2 blur
  double noise = 0.0;  ///< standard deviation of a pixel's brightness
};

/// What a camera without distortion sees of a target before a gray background. Each pixel is the
/// mean of 5 x 5 rays, all within the pixel.
inline GrayImage RenderTarget(const CalibrationTarget& target,
                              const CameraModel& camera,
                              const Pose& T_camera_target,
                              const ImageFlaws& flaws,
                              Rng& rng) {
  const double scale = 3000.0 / target.BoardSize().maxCoeff();
  const GrayImage board = DrawTarget(target, scale).value();
  const Pose T_target_camera = T_camera_target.inverse();
  const Eigen::Vector3d eye = T_target_camera.translation();
  const auto brightness = [&](double u, double v) {
    const Eigen::Vector3d ray = T_target_camera.linear() * camera.Unproject(u, v, 1.0);
    const Eigen::Vector3d hit = eye - eye.z() / ray.z() * ray;
    const double x = scale * hit.x() + 0.5 * board.width;
    const double y = scale * hit.y() + 0.5 * board.height;
    if (!(x >= 0.0 && x < board.width && y >= 0.0 && y < board.height)) return 140.0;
    return 30.0 + 0.75 * board.at(static_cast<int>(x), static_cast<int>(y));
  };
  constexpr int kRays = 5;
  std::vector<double> sharp;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      double sum = 0.0;
      for (int i = 0; i < kRays * kRays; ++i) {
        sum += brightness(u - 0.5 + (i % kRays + 0.5) / kRays, v - 0.5 + (i / kRays + 0.5) / kRays);
      }
      sharp.push_back(sum / (kRays * kRays));
    }
  }
  GrayImage image(camera.width, camera.height);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      double sum = 0.0;
      int count = 0;
      for (int dv = -flaws.blur; dv <= flaws.blur; ++dv) {
        for (int du = -flaws.blur; du <= flaws.blur; ++du) {
          const int u_near = std::clamp(u + du, 0, camera.width - 1);
          const int v_near = std::clamp(v + dv, 0, camera.height - 1);
          sum += sharp[image.Index(u_near, v_near)];
          ++count;
        }
      }
      const double value = sum / count + flaws.noise * rng.Normal();
      image.at(u, v) = static_cast<uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
    }
  }
  return image;
}

}  // namespace vantage
