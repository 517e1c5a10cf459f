#include <array>

#include "tests/bench/pose_comparison/compared_estimator.h"

namespace vantage {

std::span<const EstimatorKind> EstimatorKinds() {
  static const std::array kinds = {
      EstimatorKind{"ppf", false, MakePpf},
      EstimatorKind{"shot", false, MakeShot},
      EstimatorKind{"pcl-ppf", true, MakePclPpf},
      EstimatorKind{"pcl-ppf-fine", true, MakePclPpfFine},
      EstimatorKind{"pcl-prerejective", true, MakePclPrerejective},
      EstimatorKind{"pcl-sac-ia", true, MakePclSacIa},
      EstimatorKind{"opencv-ppf", true, MakeOpenCvPpf},
  };
  return kinds;
}

}  // namespace vantage
