#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "common/so3.h"
#include "fusion/orientation_fusion.h"

namespace vantage {

struct KnnClusteringParameters {
  /// rad, in (0, pi]: detections no farther apart are neighbors. The paper names no value.
  double max_distance = 10.0 * kDegree;

  [[nodiscard]] Result<void> Validate() const;
};

/// The nearest neighbor clustering of Kriegel et al. 2013 as paper 2.3, 7.2 and 7.3.1 describe it:
/// a detection joins the cluster of its neighbors, joining their clusters where there are several,
/// so that clusters do not depend on the detections' order; q_f is the chordal mean of the cluster
/// with the most detections. Of clusters with as many, the one that lies closer together; of
/// equally close ones (single detections), the one with the earliest detection. Detections that are
/// equal to the bit are kept once, with their number: of n different orientations a view costs O(n)
/// time, of an orientation seen before O(log n); memory is O(n).
class KnnClustering final : public OrientationFusion {
 public:
  /// @param parameters valid; checked.
  explicit KnnClustering(const KnnClusteringParameters& parameters = {});

  Result<void> Add(const OrientationView& view) override;
  [[nodiscard]] Result<Eigen::Quaterniond> Estimate() const override;

  /// Detections of each cluster, in the order of their earliest detections.
  [[nodiscard]] std::vector<int64_t> ClusterSizes() const;
  /// Different orientations kept.
  [[nodiscard]] size_t num_orientations() const { return orientations_.size(); }

 private:
  struct Cluster {
    Eigen::Matrix4d scatter;  // Sum of q q^T.
    int64_t size;
  };

  [[nodiscard]] size_t RootOf(size_t orientation) const;
  void Join(size_t a, size_t b);

  double min_dot_;  // |dot| of quaternions max_distance apart.
  std::vector<Eigen::Vector4d> orientations_;
  std::vector<size_t>
      parents_;  // Forest of clusters; a root is its cluster's earliest orientation.
  std::map<size_t, Cluster> clusters_;            // By root.
  std::map<std::array<double, 4>, size_t> seen_;  // Place in orientations_ by canonical q.
};

}  // namespace vantage
