#include <array>

#include "tests/bench/pose_comparison/compared_estimator.h"

namespace vantage {

std::span<const EstimatorKind> EstimatorKinds() {
  constexpr int kRepeats = 5;
  static const std::array kinds = {
      EstimatorKind{"ppf", false, kRepeats, MakePpf},
      EstimatorKind{"pcl-ppf", true, 1, MakePclPpf},
      EstimatorKind{"pcl-prerejective", true, 1, MakePclPrerejective},
      EstimatorKind{"pcl-sac-ia", true, 1, MakePclSacIa},
      EstimatorKind{"opencv-ppf", true, 1, MakeOpenCvPpf},
  };
  return kinds;
}

}  // namespace vantage
