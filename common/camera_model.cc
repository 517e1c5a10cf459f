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
  if (!(std::isfinite(fx) && fx > 0.0 && std::isfinite(fy) && fy > 0.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("focal lengths fx = %g, fy = %g px, expected positive and finite", fx, fy)};
  }
  if (!std::isfinite(cx) || !std::isfinite(cy)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("principal point cx = %g, cy = %g px, expected finite", cx, cy)};
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
