#include "perception/refinement/nearest_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/check.h"

namespace vantage {

NearestGrid::NearestGrid(std::vector<SurfacePoint> points, double reach, double cell)
    : points_(std::move(points)),
      cell_(static_cast<float>(cell)),
      inverse_cell_(static_cast<float>(1.0 / cell)) {
  VANTAGE_CHECK(!points_.empty() && points_.size() < std::numeric_limits<uint16_t>::max(),
                "grid of no points, or of more than 65,534");
  VANTAGE_CHECK(reach > 0.0 && cell > 0.0, "grid without size");
  Eigen::AlignedBox3f box;
  for (const SurfacePoint& point : points_) {
    box.extend(point.position);
    const Eigen::Vector3f& p = point.position;
    const Eigen::Vector3f& n = point.normal;
    rows_.push_back({p.x(), p.y(), p.z(), n.x(), n.y(), n.z(), 0.0F, 0.0F});
  }
  rows_.push_back({});
  const float margin = static_cast<float>(reach) + cell_;
  origin_ = box.min() - Eigen::Vector3f::Constant(margin);
  const Eigen::Array3f extent = (box.sizes().array() + 2.0F * margin) * inverse_cell_;
  VANTAGE_CHECK(extent.maxCoeff() < 1000.0F, "grid of more than 1000 cubes a side");
  size_ = extent.ceil().cast<int>() + 1;
  Seed();
  Spread();
  CutOff(reach);
  squared_ = {};
}

Eigen::Vector3f NearestGrid::Middle(const Eigen::Array3i& at) const {
  return origin_ + cell_ * (at.cast<float>() + 0.5F).matrix();
}

void NearestGrid::Offer(const Eigen::Vector3f& middle, uint16_t candidate, size_t cube) {
  const float squared = (middle - points_[candidate].position).squaredNorm();
  if (squared < squared_[cube]) {
    squared_[cube] = squared;
    nearest_[cube] = candidate;
  }
}

// Exact next to the points.
void NearestGrid::Seed() {
  nearest_.assign(static_cast<size_t>(size_.prod()), static_cast<uint16_t>(points_.size()));
  squared_.assign(nearest_.size(), std::numeric_limits<float>::infinity());
  for (size_t i = 0; i < points_.size(); ++i) {
    const Eigen::Array3i at = ((points_[i].position - origin_).array() * inverse_cell_).cast<int>();
    const Eigen::Array3i low = (at - 1).max(0);
    const Eigen::Array3i high = (at + 1).min(size_ - 1);
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) {
          const Eigen::Array3i cube(x, y, z);
          Offer(Middle(cube), static_cast<uint16_t>(i), Cube(cube));
        }
      }
    }
  }
}

// Every cube takes over the nearest of its neighbors if it is nearer than its own (Danielsson,
// "Euclidean Distance Mapping", 1980), swept once along each diagonal of the space.
void NearestGrid::Spread() {
  for (const int z : {1, -1}) {
    for (const int y : {1, -1}) {
      for (const int x : {1, -1}) Sweep({x, y, z});
    }
  }
}

void NearestGrid::Sweep(const Eigen::Array3i& direction) {
  const auto none = static_cast<uint16_t>(points_.size());
  const Eigen::Array3i first = (direction > 0).select(Eigen::Array3i::Zero(), size_ - 1);
  const ptrdiff_t back_x = -direction.x();
  const ptrdiff_t back_y = -direction.y() * size_.x();
  const ptrdiff_t back_z = -direction.z() * size_.x() * size_.y();
  for (int k = 0, z = first.z(); k < size_.z(); ++k, z += direction.z()) {
    for (int j = 0, y = first.y(); j < size_.y(); ++j, y += direction.y()) {
      auto cube = static_cast<ptrdiff_t>(Cube({first.x(), y, z}));
      Eigen::Vector3f middle = Middle({first.x(), y, z});
      for (int i = 0; i < size_.x(); ++i, cube -= back_x) {
        middle.x() =
            origin_.x() + cell_ * (static_cast<float>(first.x() + i * direction.x()) + 0.5F);
        const auto take_from = [&](ptrdiff_t neighbor) {
          const uint16_t candidate = nearest_[static_cast<size_t>(neighbor)];
          if (candidate == none || candidate == nearest_[static_cast<size_t>(cube)]) return;
          Offer(middle, candidate, static_cast<size_t>(cube));
        };
        if (i > 0) take_from(cube + back_x);
        if (j > 0) take_from(cube + back_y);
        if (k > 0) take_from(cube + back_z);
      }
    }
  }
}

void NearestGrid::CutOff(double reach) {
  const auto limit = static_cast<float>(reach * reach);
  for (int z = 0; z < size_.z(); ++z) {
    for (int y = 0; y < size_.y(); ++y) {
      for (int x = 0; x < size_.x(); ++x) {
        const Eigen::Array3i at(x, y, z);
        const bool is_border = at.minCoeff() == 0 || (at == size_ - 1).any();
        if (is_border || !(squared_[Cube(at)] < limit)) {
          nearest_[Cube(at)] = static_cast<uint16_t>(points_.size());
        }
      }
    }
  }
}

uint32_t NearestGrid::Find(const Eigen::Vector3f& place) const {
  const Eigen::Array3f scaled = (place - origin_).array() * inverse_cell_;
  if (!(scaled.minCoeff() >= 0.0F) || !(scaled < size_.cast<float>()).all()) return kNone;
  const uint16_t nearest = nearest_[Cube(scaled.cast<int>())];
  return nearest < points_.size() ? nearest : kNone;
}

}  // namespace vantage
