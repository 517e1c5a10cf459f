#pragma once

#include <Eigen/Geometry>

#include "common/result.h"
#include "fusion/orientation_view.h"

namespace vantage {

/// A way to fuse the orientations that one object was detected in, one view at a time: the
/// histogram filter of paper section 5 and everything that it is compared with (7.2, 7.3).
class OrientationFusion {
 public:
  virtual ~OrientationFusion() = default;

  /// Fuses one more view. Errors, which change nothing: OrientationView::Validate().
  virtual Result<void> Add(const OrientationView& view) = 0;
  /// q_f of all views so far, canonical (w >= 0). Error: no view had any weight yet.
  [[nodiscard]] virtual Result<Eigen::Quaterniond> Estimate() const = 0;
};

}  // namespace vantage
