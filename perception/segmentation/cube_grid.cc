#include "perception/segmentation/cube_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace vantage {

void CubeGrid::Clear(size_t size, double side) {
  inverse_side_ = static_cast<float>(1.0 / side);
  slots_.assign(std::bit_ceil(2 * size + 2), 0);
  cubes_.clear();
  cube_keys_.clear();
  points_.clear();
  cube_of_.clear();
}

void CubeGrid::Add(const Eigen::Vector3f& point) {
  constexpr float kOffset = 1048576.0F;  // Cubes; makes what is cut off positive.
  uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto cell = static_cast<int64_t>(std::floor(point(axis) * inverse_side_) + kOffset);
    key = (key << 21U) | (static_cast<uint64_t>(cell) & 0x1fffffU);
  }
  const size_t mask = slots_.size() - 1;
  size_t slot = static_cast<size_t>((key * 0x9e3779b97f4a7c15U) >> 32U) & mask;
  while (slots_[slot] != 0 && cube_keys_[slots_[slot] - 1] != key) slot = (slot + 1) & mask;
  if (slots_[slot] == 0) {
    cubes_.emplace_back();
    cube_keys_.push_back(key);
    slots_[slot] = static_cast<uint32_t>(cubes_.size());
  }
  const uint32_t index = slots_[slot] - 1;
  cubes_[index].sum += point;
  cubes_[index].count += 1.0F;
  points_.push_back(point);
  cube_of_.push_back(index);
}

std::span<const uint32_t> CubeGrid::Choose() {
  for (Cube& cube : cubes_) {
    cube.sum /= cube.count;
    cube.nearest = std::numeric_limits<float>::infinity();
  }
  chosen_.assign(cubes_.size(), 0);
  for (uint32_t i = 0; i < points_.size(); ++i) {
    Cube& cube = cubes_[cube_of_[i]];
    const float distance = (points_[i] - cube.sum).squaredNorm();
    if (!(distance < cube.nearest)) continue;
    cube.nearest = distance;
    chosen_[cube_of_[i]] = i;
  }
  return chosen_;
}

}  // namespace vantage
