#include "fusion/symmetry/closed_group.h"

#include <cstddef>

#include "common/so3.h"
#include "fusion/quaternion_mean.h"

namespace vantage {

std::optional<size_t> FindElement(const std::vector<Eigen::Quaterniond>& group,
                                  const Eigen::Quaterniond& rotation,
                                  double same) {
  std::optional<size_t> nearest;
  double least = same;
  for (size_t i = 0; i < group.size(); ++i) {
    const double angle = GeodesicAngle(group[i], rotation);
    if (angle >= least) continue;
    least = angle;
    nearest = i;
  }
  return nearest;
}

std::optional<std::vector<Eigen::Quaterniond>> JoinGroup(
    std::vector<Eigen::Quaterniond> group,
    const Eigen::Quaterniond& rotation,
    double same,
    const std::function<std::optional<Eigen::Quaterniond>(const Eigen::Quaterniond&)>& find) {
  constexpr size_t kLargest = 120;
  group.push_back(rotation);
  for (size_t i = 0; i < group.size(); ++i) {
    for (size_t j = 0; j <= i; ++j) {
      for (const Eigen::Quaterniond& product : {group[i] * group[j], group[j] * group[i]}) {
        if (FindElement(group, product, same)) continue;
        if (group.size() == kLargest) return std::nullopt;
        const std::optional<Eigen::Quaterniond> found = find(product);
        if (!found || FindElement(group, *found, same)) return std::nullopt;
        group.push_back(*found);
      }
    }
  }
  return group;
}

void MakeExact(std::vector<Eigen::Quaterniond>* group, double same) {
  for (int round = 0; round < 3; ++round) {
    std::vector<Eigen::Quaterniond> better;
    for (const Eigen::Quaterniond& element : *group) {
      std::vector<WeightedOrientation> quotients;
      for (const Eigen::Quaterniond& other : *group) {
        const std::optional<size_t> product = FindElement(*group, element * other, same);
        if (product) quotients.push_back({(*group)[*product] * other.conjugate(), 1.0});
      }
      better.push_back(WeightedMean(quotients));
    }
    *group = better;
  }
  group->front() = Eigen::Quaterniond::Identity();
}

}  // namespace vantage
