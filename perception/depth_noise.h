#pragma once

#include <algorithm>
#include <cmath>

namespace vantage {

/// Noise of a structured-light depth camera: Nguyen, Izadi, Lovell, "Modeling Kinect Sensor Noise
/// for Improved 3D Reconstruction and Tracking", 3DIMPVT 2012.
struct DepthNoise {
  double axial_base = 0.0012;       ///< m, eq. 1 there
  double axial_quadratic = 0.0019;  ///< 1/m, eq. 1 there
  double axial_offset = 0.4;        ///< m, eq. 1 there
  double lateral_px = 0.8;          ///< px, section 3.1 there, surface seen head on

  /// Standard deviation along z at depth z (m), m.
  [[nodiscard]] double Axial(double z) const {
    const double beyond = std::max(z - axial_offset, 0.0);
    return axial_base + axial_quadratic * beyond * beyond;
  }
  /// Standard deviation across the line of sight at depth z (m), m; `focal` in px.
  [[nodiscard]] double Lateral(double z, double focal) const { return lateral_px * z / focal; }
  /// Standard deviation along a surface's normal, m: axial and lateral parts projected onto it.
  /// @param cosine of the angle between normal and line of sight.
  [[nodiscard]] double AlongNormal(double z, double focal, double cosine) const {
    const double axial = Axial(z) * cosine;
    const double lateral = Lateral(z, focal);
    return std::sqrt(axial * axial + lateral * lateral * (1.0 - cosine * cosine));
  }
};

}  // namespace vantage
