#include "fusion/compared/scatter.h"

#include <Eigen/Eigenvalues>

#include "common/check.h"
#include "common/so3.h"

namespace vantage {

ScatterMean MeanOfScatter(const Eigen::Matrix4d& scatter) {
  const double count = scatter.trace();
  VANTAGE_CHECK(count > 0.0, "the scatter of no orientations");
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(scatter);
  const Eigen::Vector4d largest = solver.eigenvectors().col(3);
  return {Canonical(Eigen::Quaterniond(largest).normalized()), solver.eigenvalues()[3] / count};
}

}  // namespace vantage
