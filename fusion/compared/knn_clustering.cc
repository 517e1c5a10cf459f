#include "fusion/compared/knn_clustering.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/check.h"
#include "common/format.h"
#include "fusion/compared/scatter.h"

namespace vantage {

Result<void> KnnClusteringParameters::Validate() const {
  if (!(max_distance > 0.0 && max_distance <= std::numbers::pi)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("max_distance = %g rad, expected above 0 and at most pi", max_distance)};
  }
  return {};
}

KnnClustering::KnnClustering(const KnnClusteringParameters& parameters)
    : min_dot_(std::cos(0.5 * parameters.max_distance)) {
  VANTAGE_CHECK(parameters.Validate().ok(), "parameters of the nearest neighbor clustering");
}

size_t KnnClustering::RootOf(size_t orientation) const {
  while (parents_[orientation] != orientation) orientation = parents_[orientation];
  return orientation;
}

void KnnClustering::Join(size_t a, size_t b) {
  const size_t root = std::min(RootOf(a), RootOf(b));
  const size_t other = std::max(RootOf(a), RootOf(b));
  if (root == other) return;
  const auto found = clusters_.find(other);
  Cluster& cluster = clusters_.at(root);
  cluster.scatter += found->second.scatter;
  cluster.size += found->second.size;
  clusters_.erase(found);
  parents_[other] = root;
}

Result<void> KnnClustering::Add(const OrientationView& view) {
  if (const Result<void> valid = view.Validate(); !valid) return valid.error();
  const Eigen::Vector4d q = Canonical(view.q_world_object.normalized()).coeffs();
  const size_t last = orientations_.size();
  // 0 and -0 are the same to the map.
  const auto [place, is_new] = seen_.try_emplace({q[0], q[1], q[2], q[3]}, last);
  if (!is_new) {
    Cluster& cluster = clusters_.at(RootOf(place->second));
    cluster.scatter += q * q.transpose();
    ++cluster.size;
    return {};
  }
  orientations_.push_back(q);
  parents_.push_back(last);
  clusters_.emplace(last, Cluster{q * q.transpose(), 1});
  for (size_t i = 0; i < last; ++i) {
    if (std::abs(orientations_[i].dot(q)) < min_dot_) continue;
    Join(i, last);
    parents_[i] = RootOf(i);  // Keeps the forest flat: a neighbor's root is near.
  }
  return {};
}

Result<Eigen::Quaterniond> KnnClustering::Estimate() const {
  if (clusters_.empty()) {
    return Error{ErrorCode::kNotFound, "the largest cluster of no view yet, expected one or more"};
  }
  int64_t most = 0;
  for (const auto& [root, cluster] : clusters_) most = std::max(most, cluster.size);
  constexpr double kRounding = 1e-12;  // Of the concentration of equally close clusters.
  ScatterMean best{Eigen::Quaterniond::Identity(), -1.0};
  for (const auto& [root, cluster] : clusters_) {
    if (cluster.size < most) continue;
    const ScatterMean mean = MeanOfScatter(cluster.scatter);
    if (mean.concentration > best.concentration + kRounding) best = mean;
  }
  return best.mean;
}

std::vector<int64_t> KnnClustering::ClusterSizes() const {
  std::vector<int64_t> sizes;
  for (const auto& [root, cluster] : clusters_) sizes.push_back(cluster.size);
  return sizes;
}

}  // namespace vantage
