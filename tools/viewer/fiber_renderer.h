#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "tools/support/color.h"
#include "tools/support/png_image.h"
#include "tools/viewer/orientation_samples.h"

namespace vantage {

/// Both halves of the unit sphere side by side, each seen from outside: the one about `towards` on
/// the left. The same places as RenderSphereDensity()'s.
struct TwoHalves {
  Eigen::Vector3d towards = Eigen::Vector3d::Ones();
  int radius_px = 110;

  static constexpr int kMargin = 8;  ///< px
  [[nodiscard]] int width() const { return 4 * radius_px + 3 * kMargin; }
  [[nodiscard]] int height() const { return 2 * radius_px + 2 * kMargin; }
  /// Pixel of a direction, in the half that it is on.
  [[nodiscard]] Eigen::Vector2d Project(const Eigen::Vector3d& direction) const;
  /// The middle of a half.
  [[nodiscard]] Eigen::Vector2d Center(bool is_far) const;
  /// Rows: right, up, and towards the viewer of a half.
  [[nodiscard]] Eigen::Matrix3d Rotation(bool is_far) const;
};

/// Color of an angle (rad): equally light all around, so that no angle looks like more.
Rgb AngleColor(double angle);

/// Where orientations take `v`, in the color of the angle about there (PlaceOf): pale where there
/// is little weight, grey where several angles share a place.
RgbImage RenderFibers(std::span<const OrientationSample> samples,
                      const Eigen::Vector3d& v,
                      const Eigen::Quaterniond& reference,
                      const TwoHalves& view,
                      Rgb background);

}  // namespace vantage
