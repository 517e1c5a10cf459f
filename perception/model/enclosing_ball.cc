#include "perception/model/enclosing_ball.h"

#include <algorithm>

namespace vantage {

double RadiusAboutCenter(const ObjectModel& model) {
  double radius = 0.0;
  for (const Eigen::Vector3f& vertex : model.mesh.vertices) {
    radius = std::max(radius, (vertex.cast<double>() - model.center).norm());
  }
  return radius;
}

}  // namespace vantage
