#include "drivers/camera/color_registration.h"

#include <algorithm>

#include "common/check.h"
#include "common/simd.h"
#include "drivers/camera/bilinear.h"

namespace vantage {
namespace {

// What is nearer by less, relatively, hides nothing: it would be moved by less than a pixel.
constexpr float kTolerance = 0.02F;

// Within half a pixel of the image. NaN is not.
[[gnu::always_inline]] inline bool IsInside(const CameraModel& camera, float u, float v) {
  return u >= -0.5F && v >= -0.5F && u < static_cast<float>(camera.width) - 0.5F &&
         v < static_cast<float>(camera.height) - 0.5F;
}

}  // namespace

ColorRegistration::ColorRegistration(const CameraModel& depth,
                                     const CameraIntrinsics& color,
                                     const Pose& T_color_depth)
    : color_(color.camera),
      projection_({depth, {}}, color.camera, T_color_depth),
      to_color_({depth, {}}, color.camera, T_color_depth),
      u_(projection_.stride()),
      v_(projection_.stride()),
      z_(projection_.stride()) {
  if (color.distortion.IsNone()) return;
  for (int v = 0; v < color_.height; ++v) {
    for (int u = 0; u < color_.width; ++u) {
      const Eigen::Vector2d ideal((u - color_.cx) / color_.fx, (v - color_.cy) / color_.fy);
      const Eigen::Vector2d shift = color.distortion.Distort(ideal) - ideal;
      shifts_.push_back(
          {static_cast<float>(color_.fx * shift.x()), static_cast<float>(color_.fy * shift.y())});
    }
  }
}

void ColorRegistration::Register(std::span<const uint16_t> depth_mm,
                                 int channels,
                                 std::span<const uint8_t> pixels,
                                 std::vector<uint8_t>* registered) {
  const size_t step = static_cast<size_t>(channels);
  const size_t color_width = static_cast<size_t>(color_.width);
  VANTAGE_CHECK(pixels.size() == step * color_width * static_cast<size_t>(color_.height),
                "a color image of another size");
  // One row and eight bytes more, so that what has no share can be read.
  pixels_.resize(pixels.size() + step * color_width + 8);
  std::ranges::copy(pixels, pixels_.begin());
  to_color_.Register(depth_mm, &seen_mm_);
  registered->assign(step * depth_mm.size(), 0);
  const size_t width = static_cast<size_t>(projection_.width());
  for (int row = 0; row < projection_.height(); ++row) {
    const size_t first = static_cast<size_t>(row) * width;
    projection_.ProjectRow(row, &depth_mm[first], u_.data(), v_.data(), z_.data());
    RegisterRow(step, registered->data() + step * first);
  }
}

VANTAGE_SIMD void ColorRegistration::RegisterRow(size_t channels, uint8_t* registered) const {
  const size_t width = static_cast<size_t>(color_.width);
  const float last_u = static_cast<float>(color_.width - 1);
  const float last_v = static_cast<float>(color_.height - 1);
  const int count = projection_.width();
  for (size_t i = 0; i < static_cast<size_t>(count); ++i, registered += channels) {
    float u = u_[i];
    float v = v_[i];
    if (!(z_[i] < RayProjection::kFar && IsInside(color_, u, v))) continue;
    const size_t nearest = static_cast<size_t>(static_cast<int32_t>(v + 0.5F)) * width +
                           static_cast<size_t>(static_cast<int32_t>(u + 0.5F));
    const float seen_mm = static_cast<float>(seen_mm_[nearest]);
    if (seen_mm > 0.0F && z_[i] > (1.0F + kTolerance) * seen_mm) continue;
    if (!shifts_.empty()) {
      // From one pixel to the next it changes by little.
      u += shifts_[nearest].u;
      v += shifts_[nearest].v;
      if (!IsInside(color_, u, v)) continue;
    }
    u = std::clamp(u, 0.0F, last_u);
    v = std::clamp(v, 0.0F, last_v);
    const auto left = static_cast<int32_t>(u);
    const auto top = static_cast<int32_t>(v);
    const auto share = [](float part) {
      return static_cast<unsigned>(static_cast<int32_t>(part * bilinear::kWhole + 0.5F));
    };
    const unsigned right = share(u - static_cast<float>(left));
    const unsigned down = share(v - static_cast<float>(top));
    const uint8_t* at =
        pixels_.data() + channels * (static_cast<size_t>(top) * width + static_cast<size_t>(left));
    if (channels == 3) {
      bilinear::Rgb(at, 3 * width, right, down, registered);
    } else {
      *registered = bilinear::Gray(at, width, right, down);
    }
  }
}

}  // namespace vantage
