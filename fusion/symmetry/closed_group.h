#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <optional>
#include <vector>

namespace vantage {

/// The element of `group` nearest to a rotation, when within `same` rad.
std::optional<size_t> FindElement(const std::vector<Eigen::Quaterniond>& group,
                                  const Eigen::Quaterniond& rotation,
                                  double same);

/// The smallest group that holds a group and one more rotation. None when `find` finds no symmetry
/// near a product, or at more than 120 elements (twice the icosahedron's; Cyclic(120): 3 degrees).
/// @param same rad, rotations closer than that are one.
/// @param find the symmetry near a product of two, as exactly as it is known.
std::optional<std::vector<Eigen::Quaterniond>> JoinGroup(
    std::vector<Eigen::Quaterniond> group,
    const Eigen::Quaterniond& rotation,
    double same,
    const std::function<std::optional<Eigen::Quaterniond>(const Eigen::Quaterniond&)>& find);

/// Makes the products of a measured group its elements to rounding: each element becomes the mean
/// of all quotients that should equal it.
void MakeExact(std::vector<Eigen::Quaterniond>* group, double same);

}  // namespace vantage
