#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "common/result.h"
#include "common/so3.h"
#include "fusion/orientation_histogram.h"
#include "fusion/orientation_view.h"
#include "fusion/peaks.h"
#include "fusion/so3_grid.h"

namespace vantage {

/// Parameters of the histogram filter (paper section 5).
struct OrientationFilterParameters {
  double sigma_cw = 4.0 * kDegree;    ///< rad, of the confidence weight (eq. 2)
  double sigma_vw = 6.25e-6;          ///< m^2, of the verification weight (eq. 4): (2.5 mm)^2
  double sigma_mode = 4.0 * kDegree;  ///< rad, of the kernels of the density's mode
  PeakParameters peaks{};
  double converge_angle = 1.0 * kDegree;  ///< rad, change of q_f that counts as none (paper 5.2)
  int converge_views = 2;                 ///< last views that must not have changed q_f
  int min_views = 4;                      ///< views before convergence is believed

  Result<void> Validate() const;
};

/// The orientation of one object, fused from one detection a view.
class OrientationFilter {
 public:
  /// @param grid outlives the filter.
  OrientationFilter(const So3Grid& grid, const OrientationFilterParameters& parameters);

  /// Fuses all views of the object, in their order. Steps over views that are as in the last call
  /// are not repeated: a new last view costs one update, a changed one those from there on.
  void Fuse(std::vector<OrientationView> views);

  [[nodiscard]] const OrientationHistogram& histogram() const { return histogram_; }
  /// Modes, best first; empty while no view has weight.
  [[nodiscard]] const std::vector<OrientationPeak>& peaks() const { return peaks_; }
  /// Angle between the last two q_f, rad; -1 before two views.
  [[nodiscard]] double last_change() const;
  /// The termination condition of paper 5.2.
  [[nodiscard]] bool converged() const;

 private:
  const So3Grid* grid_;
  OrientationFilterParameters parameters_;
  OrientationHistogram histogram_;
  std::vector<OrientationView> views_;
  std::vector<OrientationPeak> peaks_;
  std::vector<Eigen::Quaterniond> q_f_;  // After each view; identity while no view had weight.
};

}  // namespace vantage
