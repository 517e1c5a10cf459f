#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/simd.h"
#include "common/triangle_mesh.h"

namespace vantage {

/// The nearest of fixed surface points to any place near them, from a grid of cubes in constant
/// time: exact for the middle of nearly every cube, and up to the cube's diagonal worse elsewhere.
/// Two bytes a cube, so that it stays in a core's cache.
class NearestGrid {
 public:
  static constexpr uint32_t kNone = 0xffffffffU;

  /// @param points 1 to 65,534.
  /// @param reach m; places farther than this from all points have no nearest.
  /// @param cell m, side of a cube.
  NearestGrid(std::vector<SurfacePoint> points, double reach, double cell);

  /// Index of the nearest point, or kNone.
  [[nodiscard]] uint32_t Find(const Eigen::Vector3f& place) const;
  [[nodiscard]] std::span<const SurfacePoint> points() const { return points_; }

  /// Eight of Find() at once: positions and normals of the nearest points; a normal of 0 stands for
  /// none.
  [[gnu::always_inline]] inline void FindLanes(const F8s<3>& place,
                                               F8s<3>* position,
                                               F8s<3>* normal) const;

 private:
  // A point as a row of eight numbers: position, normal, two of no meaning.
  using Row = std::array<float, kLanes>;

  void Seed();
  void Spread();
  void Sweep(const Eigen::Array3i& direction);
  void CutOff(double reach);
  [[nodiscard]] Eigen::Vector3f Middle(const Eigen::Array3i& at) const;
  [[nodiscard]] size_t Cube(const Eigen::Array3i& at) const {
    return static_cast<size_t>((at.z() * size_.y() + at.y()) * size_.x() + at.x());
  }
  void Offer(const Eigen::Vector3f& middle, uint16_t candidate, size_t cube);

  std::vector<SurfacePoint> points_;
  Eigen::Vector3f origin_;
  float cell_;
  float inverse_cell_;
  Eigen::Array3i size_;
  std::vector<uint16_t> nearest_;  // points_.size() stands for none, as in all cubes of the border.
  std::vector<Row> rows_;          // Of points_, and one of zeros for none.
  std::vector<float> squared_;     // Only while it is built.
};

void NearestGrid::FindLanes(const F8s<3>& place, F8s<3>* position, F8s<3>* normal) const {
  F8s<3> at;
  for (size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    const F8 scaled = (place[i] - origin_[axis]) * inverse_cell_;
    const F8 last = F8{} + static_cast<float>(size_[axis] - 1);
    const F8 low = scaled > 0.0F ? scaled : F8{};  // Also what is no number.
    at[i] = low < last ? low : last;
  }
  const I8 x = __builtin_convertvector(at[0], I8);
  const I8 y = __builtin_convertvector(at[1], I8);
  const I8 z = __builtin_convertvector(at[2], I8);
  const I8 cube = (z * size_.y() + y) * size_.x() + x;
  F8s<kLanes> rows;
  for (size_t lane = 0; lane < kLanes; ++lane) {
    const uint16_t nearest = nearest_[static_cast<size_t>(cube[lane])];
    __builtin_memcpy(&rows[lane], rows_[nearest].data(), sizeof(F8));
  }
  Transpose(&rows);
  *position = {{rows[0], rows[1], rows[2]}};
  *normal = {{rows[3], rows[4], rows[5]}};
}

}  // namespace vantage
