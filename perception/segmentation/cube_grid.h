#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

namespace vantage {

/// Of the points in each cube of a grid the one nearest to their mean. Owns its buffers: allocates
/// nothing once warm.
class CubeGrid {
 public:
  /// Begins anew for at most `size` points, in cubes of `side` m.
  void Clear(size_t size, double side);
  /// Points within 1e6 cubes of 0; others share cubes with some of these.
  void Add(const Eigen::Vector3f& point);
  /// Indices of the chosen points, counted from 0 in the order of Add(); in the order of the
  /// cubes' first points. Valid until Clear().
  std::span<const uint32_t> Choose();

 private:
  struct Cube {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    float count = 0.0F;
    float nearest = 0.0F;  // m^2, of the chosen point to the mean
  };

  float inverse_side_ = 1.0F;    // 1/m
  std::vector<uint32_t> slots_;  // Open addressing: index of a cube and 1, or 0.
  std::vector<Cube> cubes_;
  std::vector<uint64_t> cube_keys_;
  std::vector<Eigen::Vector3f> points_;
  std::vector<uint32_t> cube_of_;
  std::vector<uint32_t> chosen_;
};

}  // namespace vantage
