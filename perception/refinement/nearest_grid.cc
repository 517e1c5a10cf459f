#include "perception/refinement/nearest_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/check.h"

namespace vantage {

NearestGrid::NearestGrid(std::vector<SurfacePoint> points, double reach, double cell)
    : points_(std::move(points)), inverse_cell_(static_cast<float>(1.0 / cell)) {
  VANTAGE_CHECK(!points_.empty() && reach > 0.0 && cell > 0.0, "grid without points or size");
  Eigen::AlignedBox3f box;
  for (const SurfacePoint& point : points_) box.extend(point.position);
  const auto side = static_cast<float>(cell);
  const auto limit = static_cast<float>(reach);
  origin_ = box.min() - Eigen::Vector3f::Constant(limit);
  const Eigen::Array3f extent = (box.sizes().array() + 2.0F * limit) * inverse_cell_;
  VANTAGE_CHECK(extent.maxCoeff() < 1000.0F, "grid of more than 1000 cubes a side");
  size_ = extent.ceil().cast<int>() + 1;
  nearest_.assign(static_cast<size_t>(size_.prod()), kNone);
  std::vector<float> best(nearest_.size(), limit * limit);
  const int span = static_cast<int>(std::ceil(limit * inverse_cell_)) + 1;
  for (size_t i = 0; i < points_.size(); ++i) {
    const Eigen::Vector3f& position = points_[i].position;
    const Eigen::Array3i at = ((position - origin_).array() * inverse_cell_).cast<int>();
    const Eigen::Array3i low = (at - span).max(0);
    const Eigen::Array3i high = (at + span).min(size_ - 1);
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) {
          const Eigen::Vector3f middle = origin_ + side * (Eigen::Vector3f(static_cast<float>(x),
                                                                           static_cast<float>(y),
                                                                           static_cast<float>(z)) +
                                                           Eigen::Vector3f::Constant(0.5F));
          const float squared = (middle - position).squaredNorm();
          const auto cube = static_cast<size_t>((z * size_.y() + y) * size_.x() + x);
          if (squared < best[cube]) {
            best[cube] = squared;
            nearest_[cube] = static_cast<uint32_t>(i);
          }
        }
      }
    }
  }
}

uint32_t NearestGrid::Find(const Eigen::Vector3f& place) const {
  const Eigen::Array3f scaled = (place - origin_).array() * inverse_cell_;
  if (!(scaled.minCoeff() >= 0.0F) || !(scaled < size_.cast<float>()).all()) return kNone;
  const Eigen::Array3i at = scaled.cast<int>();
  return nearest_[static_cast<size_t>((at.z() * size_.y() + at.y()) * size_.x() + at.x())];
}

}  // namespace vantage
