#include "tools/viewer/fiber_renderer.h"

#include <algorithm>
#include <cmath>

#include "common/so3.h"
#include "tools/support/rgb_canvas.h"
#include "tools/support/sphere_renderer.h"

namespace vantage {
namespace {

constexpr double kKernel = 0.035;  // rad, standard deviation of the smoothing
constexpr double kReach = 3.0 * kKernel;
constexpr int kFiner = 2;  // Pixels drawn for one of the picture.
constexpr Rgb kNone{233, 234, 238};

// Weight at a pixel, and the sum of its angles as directions.
struct Blend {
  float weight = 0.0F;
  float cosine = 0.0F;
  float sine = 0.0F;
};

struct Half {
  Eigen::Matrix3d R_view_world;
  int radius;
  std::vector<Blend> blends;  // (2 radius + 1)^2

  [[nodiscard]] int side() const { return 2 * radius + 1; }
  [[nodiscard]] Blend& at(int column, int row) {
    return blends[static_cast<size_t>(row) * static_cast<size_t>(side()) +
                  static_cast<size_t>(column)];
  }
  // The sphere's point behind a pixel; z < 0 outside of the disk.
  [[nodiscard]] Eigen::Vector3d PointAt(int column, int row) const {
    const double x = static_cast<double>(column - radius) / radius;
    const double y = static_cast<double>(radius - row) / radius;
    const double rest = 1.0 - x * x - y * y;
    return {x, y, rest < 0.0 ? -1.0 : std::sqrt(rest)};
  }
};

void Splat(const FiberPlace& place, double weight, Half& half) {
  const Eigen::Vector3d at = half.R_view_world * place.direction;
  if (at.z() < -kReach) return;
  const auto low = [&](double middle) {
    return std::max(0, static_cast<int>(half.radius * (1.0 + middle - kReach)));
  };
  const auto high = [&](double middle) {
    return std::min(half.side() - 1, static_cast<int>(half.radius * (1.0 + middle + kReach)) + 1);
  };
  const double cosine = std::cos(place.angle);
  const double sine = std::sin(place.angle);
  for (int row = low(-at.y()); row <= high(-at.y()); ++row) {
    for (int column = low(at.x()); column <= high(at.x()); ++column) {
      const Eigen::Vector3d point = half.PointAt(column, row);
      const double chord2 = (point - at).squaredNorm();
      if (point.z() < 0.0 || chord2 > kReach * kReach) continue;
      const double share = weight * std::exp(-0.5 * chord2 / (kKernel * kKernel));
      Blend& blend = half.at(column, row);
      blend.weight += static_cast<float>(share);
      blend.cosine += static_cast<float>(share * cosine);
      blend.sine += static_cast<float>(share * sine);
    }
  }
}

Rgb BlendColor(const Blend& blend, float highest, double light) {
  Rgb color = kNone;
  if (highest > 0.0F && blend.weight > 0.0F) {
    const double agreement =
        static_cast<double>(std::hypot(blend.cosine, blend.sine) / blend.weight);
    const double angle =
        std::atan2(static_cast<double>(blend.sine), static_cast<double>(blend.cosine));
    const Rgb full = Mix({96, 96, 100}, AngleColor(angle), std::clamp(agreement, 0.0, 1.0));
    color = Mix(kNone, full, std::sqrt(static_cast<double>(blend.weight / highest)));
  }
  return Mix({40, 44, 52}, color, light);
}

}  // namespace

Eigen::Matrix3d TwoHalves::Rotation(bool is_far) const {
  return ViewRotation(is_far ? Eigen::Vector3d(-towards) : towards);
}

Eigen::Vector2d TwoHalves::Center(bool is_far) const {
  return {(is_far ? 2.0 : 1.0) * kMargin + (is_far ? 3.0 : 1.0) * radius_px, kMargin + radius_px};
}

Eigen::Vector2d TwoHalves::Project(const Eigen::Vector3d& direction) const {
  const bool is_far = direction.dot(towards) < 0.0;
  const Eigen::Vector3d p = Rotation(is_far) * direction;
  return Center(is_far) + radius_px * Eigen::Vector2d(p.x(), -p.y());
}

// CIE L*a*b* at one lightness and chroma, to sRGB.
Rgb AngleColor(double angle) {
  constexpr double kLightness = 60.0;
  constexpr double kChroma = 46.0;
  const double fy = (kLightness + 16.0) / 116.0;
  const double fx = fy + kChroma * std::cos(angle) / 500.0;
  const double fz = fy - kChroma * std::sin(angle) / 200.0;
  const auto cube = [](double f) {
    return f > 6.0 / 29.0 ? f * f * f : 3.0 * (6.0 / 29.0) * (6.0 / 29.0) * (f - 4.0 / 29.0);
  };
  const Eigen::Vector3d xyz(0.9505 * cube(fx), cube(fy), 1.089 * cube(fz));  // White of D65.
  Eigen::Matrix3d to_rgb;
  to_rgb << 3.2406, -1.5372, -0.4986, -0.9689, 1.8758, 0.0415, 0.0557, -0.2040, 1.0570;
  const Eigen::Vector3d linear = to_rgb * xyz;
  const auto byte = [](double c) {
    c = std::clamp(c, 0.0, 1.0);
    const double gamma = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1.0 / 2.4) - 0.055;
    return static_cast<uint8_t>(std::lround(255.0 * gamma));
  };
  return {byte(linear.x()), byte(linear.y()), byte(linear.z())};
}

RgbImage RenderFibers(std::span<const OrientationSample> samples,
                      const Eigen::Vector3d& v,
                      const Eigen::Quaterniond& reference,
                      const TwoHalves& view,
                      Rgb background) {
  const int radius = kFiner * view.radius_px;
  const size_t count = static_cast<size_t>(2 * radius + 1) * static_cast<size_t>(2 * radius + 1);
  Half halves[2] = {{view.Rotation(false), radius, std::vector<Blend>(count)},
                    {view.Rotation(true), radius, std::vector<Blend>(count)}};
  for (const OrientationSample& sample : samples) {
    const FiberPlace place = PlaceOf(sample.q, v, reference);
    for (Half& half : halves) Splat(place, sample.weight, half);
  }
  float highest = 0.0F;
  for (const Half& half : halves) {
    for (const Blend& blend : half.blends) highest = std::max(highest, blend.weight);
  }
  RgbImage image = FilledImage(kFiner * view.width(), kFiner * view.height(), background);
  for (const bool is_far : {false, true}) {
    Half& half = halves[is_far ? 1 : 0];
    const Eigen::Vector2i corner =
        (kFiner * view.Center(is_far)).cast<int>() - Eigen::Vector2i(radius, radius);
    for (int row = 0; row < half.side(); ++row) {
      for (int column = 0; column < half.side(); ++column) {
        const Eigen::Vector3d point = half.PointAt(column, row);
        if (point.z() < 0.0) continue;
        const double light = 0.80 + 0.20 * point.dot(Eigen::Vector3d(-0.35, 0.45, 0.82));
        SetPixel(image,
                 corner.x() + column,
                 corner.y() + row,
                 BlendColor(half.at(column, row), highest, std::clamp(light, 0.0, 1.0)));
      }
    }
  }
  return Downsample(image, kFiner);
}

}  // namespace vantage
