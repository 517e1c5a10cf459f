#include "perception/refinement/scene_points.h"

#include <algorithm>
#include <cmath>

namespace vantage {

void ScenePoints::Assign(std::span<const SurfacePoint> points,
                         double focal,
                         const DepthNoise& noise) {
  blocks_.clear();
  size_ = 0;
  for (const SurfacePoint& point : points) {
    if (!point.position.allFinite() || !point.normal.allFinite()) continue;
    const size_t lane = size_++ % kLanes;
    if (lane == 0) blocks_.emplace_back();
    Block& block = blocks_.back();
    for (size_t i = 0; i < 3; ++i) {
      block.position[i][lane] = point.position[static_cast<Eigen::Index>(i)];
      block.normal[i][lane] = point.normal[static_cast<Eigen::Index>(i)];
    }
    const float distance = point.position.norm();
    const float cosine =
        distance > 0.0F ? std::abs(point.normal.dot(point.position)) / distance : 1.0F;
    const double sigma = noise.AlongNormal(static_cast<double>(point.position.z()),
                                           focal,
                                           static_cast<double>(std::min(cosine, 1.0F)));
    block.variance[lane] = static_cast<float>(sigma * sigma);
  }
}

}  // namespace vantage
