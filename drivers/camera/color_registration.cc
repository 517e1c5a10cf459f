#include "drivers/camera/color_registration.h"

#include <algorithm>
#include <cmath>

#include "common/check.h"

namespace vantage {
namespace {

// What is nearer by less, relatively, hides nothing: it would be moved by less than a pixel.
constexpr float kTolerance = 0.02F;

// From the four pixels around (u, v), which is within half a pixel of the image.
void Interpolate(const CameraModel& camera,
                 std::span<const uint8_t> pixels,
                 size_t channels,
                 double u,
                 double v,
                 uint8_t* mixed) {
  const float x = static_cast<float>(std::clamp(u, 0.0, camera.width - 1.0));
  const float y = static_cast<float>(std::clamp(v, 0.0, camera.height - 1.0));
  const int left = static_cast<int>(x);
  const int top = static_cast<int>(y);
  const float right_share = x - static_cast<float>(left);
  const float bottom_share = y - static_cast<float>(top);
  const size_t right_step = left + 1 < camera.width ? channels : 0;
  const size_t row = static_cast<size_t>(camera.width) * channels;
  const size_t bottom_step = top + 1 < camera.height ? row : 0;
  const uint8_t* at =
      &pixels[static_cast<size_t>(top) * row + static_cast<size_t>(left) * channels];
  for (size_t c = 0; c < channels; ++c, ++at) {
    const float above = at[0] + right_share * static_cast<float>(at[right_step] - at[0]);
    const uint8_t* under = at + bottom_step;
    const float below = under[0] + right_share * static_cast<float>(under[right_step] - under[0]);
    mixed[c] = static_cast<uint8_t>(above + bottom_share * (below - above) + 0.5F);
  }
}

}  // namespace

ColorRegistration::ColorRegistration(const CameraModel& depth,
                                     const CameraIntrinsics& color,
                                     const Pose& T_color_depth)
    : color_(color),
      projection_({depth, {}}, color.camera, T_color_depth),
      to_color_({depth, {}}, color.camera, T_color_depth),
      u_(projection_.stride()),
      v_(projection_.stride()),
      z_(projection_.stride()) {}

void ColorRegistration::Register(std::span<const uint16_t> depth_mm,
                                 int channels,
                                 std::span<const uint8_t> pixels,
                                 std::vector<uint8_t>* registered) {
  const CameraModel& camera = color_.camera;
  const size_t step = static_cast<size_t>(channels);
  VANTAGE_CHECK(pixels.size() ==
                    step * static_cast<size_t>(camera.width) * static_cast<size_t>(camera.height),
                "a color image of another size");
  to_color_.Register(depth_mm, &seen_mm_);
  registered->assign(step * depth_mm.size(), 0);
  const size_t width = static_cast<size_t>(projection_.width());
  const double last_u = camera.width - 0.5;
  const double last_v = camera.height - 0.5;
  for (int row = 0; row < projection_.height(); ++row) {
    const size_t first = static_cast<size_t>(row) * width;
    projection_.ProjectRow(row, &depth_mm[first], u_.data(), v_.data(), z_.data());
    for (size_t i = 0; i < width; ++i) {
      double u = u_[i];
      double v = v_[i];
      const bool is_inside =
          z_[i] < RayProjection::kFar && u >= -0.5 && v >= -0.5 && u < last_u && v < last_v;
      if (!is_inside) continue;
      const float seen_mm =
          seen_mm_[static_cast<size_t>(v + 0.5) * static_cast<size_t>(camera.width) +
                   static_cast<size_t>(u + 0.5)];
      if (seen_mm > 0.0F && z_[i] > (1.0F + kTolerance) * seen_mm) continue;
      if (!color_.distortion.IsNone()) {
        const Eigen::Vector2d shown =
            color_.distortion.Distort({(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy});
        u = camera.fx * shown.x() + camera.cx;
        v = camera.fy * shown.y() + camera.cy;
        if (!(u >= -0.5 && v >= -0.5 && u < last_u && v < last_v)) continue;
      }
      Interpolate(camera, pixels, step, u, v, &(*registered)[step * (first + i)]);
    }
  }
}

}  // namespace vantage
