#include "common/camera_model.h"

#include <cmath>

#include "common/format.h"

namespace vantage {

Result<void> CameraModel::Validate() const {
  constexpr int kLargest = 16384;
  if (width < 1 || width > kLargest || height < 1 || height > kLargest) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("camera image of %d x %d px, expected 1 to %d each", width, height, kLargest)};
  }
  // Far beyond any camera; so near to 0 or so large that a ray's square overflows is worse. NaN
  // fails.
  constexpr double kFarthest = 1e6;  // px
  const auto is_focal = [](double f) { return f >= 1.0 && f <= kFarthest; };
  if (!is_focal(fx) || !is_focal(fy)) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("focal lengths fx = %g, fy = %g px, expected 1 to %g each", fx, fy, kFarthest)};
  }
  if (!(std::abs(cx) <= kFarthest && std::abs(cy) <= kFarthest)) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("principal point cx = %g, cy = %g px, expected within %g of 0", cx, cy, kFarthest)};
  }
  return {};
}

CameraModel CameraModel::Scaled(double factor) const {
  CameraModel scaled;
  scaled.width = static_cast<int>(std::lround(width * factor));
  scaled.height = static_cast<int>(std::lround(height * factor));
  scaled.fx = fx * factor;
  scaled.fy = fy * factor;
  // Pixel centres are whole numbers, so the image's corner is at -0.5.
  scaled.cx = (cx + 0.5) * factor - 0.5;
  scaled.cy = (cy + 0.5) * factor - 0.5;
  return scaled;
}

CameraModel CameraFromFieldOfView(int width, int height, double horizontal, double vertical) {
  CameraModel camera;
  camera.width = width;
  camera.height = height;
  camera.fx = width / (2.0 * std::tan(0.5 * horizontal));
  camera.fy = height / (2.0 * std::tan(0.5 * vertical));
  camera.cx = 0.5 * (width - 1);
  camera.cy = 0.5 * (height - 1);
  return camera;
}

}  // namespace vantage
