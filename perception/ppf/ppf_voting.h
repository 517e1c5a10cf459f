#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/result.h"
#include "common/rng.h"
#include "common/so3.h"
#include "perception/estimator/pose_proposer.h"
#include "perception/ppf/pair_features.h"
#include "perception/ppf/ppf_table.h"

namespace vantage {

struct PpfVotingParameters {
  double reference_share = 0.2;  ///< of the scene's points (Drost et al. 2010: 1/5)
  int min_references = 16;
  int max_references = 16;
  int turn_bins = 30;              ///< of the turn about the normal (Drost et al. 2010: 30)
  double spread = 0.15;            ///< bins; a feature this near to a border votes in both cells
  int votes_per_reference = 2500;  ///< the rarest features' come first, the rest is left out
  int peaks_per_reference = 20;
  double cluster_distance = 0.1;    ///< of the diameter, between centers of equal poses
  double cluster_angle_deg = 15.0;  ///< deg, between orientations of equal poses
  int max_hypotheses = 16;
  Result<void> Validate() const;
  /// Reference points of a scene of so many points.
  [[nodiscard]] size_t NumReferences(size_t scene_points) const;
};

/// Votes of one reference point with its partners (paper section 3.1): for every model point and
/// turn about the normal, how many scene pairs agree.
class PpfVoting {
 public:
  /// A model point on which the reference point may lie.
  struct Peak {
    uint32_t model_point;
    float turn;   ///< rad
    float votes;  ///< of the turn and its neighbors
  };

  /// Counts the votes of the pairs (`reference`, other points of `scene`), those of rare features
  /// first, which tell most, until `votes_per_reference` are cast: so planes, on which most pairs
  /// are alike, neither take long nor hide the rest. Points in one place don't vote for each other.
  /// Deterministic; allocates nothing once warm.
  /// @param reference index into `scene`.
  void Accumulate(const PpfTable& table,
                  const SurfaceLanes& scene,
                  size_t reference,
                  const PpfVotingParameters& parameters);
  /// Of the last reference: the best turn of each model point, of which the best points.
  std::span<const Peak> FindPeaks(size_t keep);
  [[nodiscard]] int count(size_t model_point, size_t turn_bin) const {
    return counts_[model_point * stride_ + turn_bin];
  }

 private:
  void FindCells(const PpfTable& table, const PpfVotingParameters& parameters);
  void SortByRarity(const PpfTable& table, size_t reference);
  size_t Vote(const PpfTable& table, uint32_t pair, size_t budget);
  void CloseRows();
  void MaximizeRows();

  // A pair's cells: the lowest, and which of its neighbors upwards belong to it.
  struct Cells {
    std::vector<int32_t> base;  // -1: none
    std::vector<int32_t> up;    // Bits 0 to 3: distance, angle_normal1, angle_normal2, normals.
  };
  PairFeatures features_;
  Cells cells_;
  std::vector<uint32_t> sizes_;  // Entries in each pair's cells.
  std::vector<uint32_t> order_;
  size_t num_points_ = 0;
  size_t turn_bins_ = 0;
  size_t stride_ = 0;            // Turns wrap around: two more than turn_bins_, rounded up.
  std::vector<int16_t> counts_;  // Row by row.
  std::vector<int16_t> best_;    // Of each row.
  std::vector<uint32_t> histogram_;
  std::vector<Peak> peaks_;
};

/// The pose in which model point `model_point` lies on scene point `scene_point`, their normals
/// agree, and the model is turned by `turn` rad about the normal.
Pose PoseFromAlignment(const SurfacePoint& scene_point,
                       const SurfacePoint& model_point,
                       double turn);

/// Hypotheses of all reference points' peaks, clustered, most votes first.
/// @param scene surface points in camera coordinates, about as dense as the table's.
/// @param center of the model, m, whose places decide how far two poses are apart.
std::vector<PoseHypothesis> VotePoses(const PpfTable& table,
                                      std::span<const SurfacePoint> scene,
                                      const Eigen::Vector3d& center,
                                      const PpfVotingParameters& parameters,
                                      Rng& rng);

/// Greedy clustering: the hypothesis of most votes founds a cluster and takes in all near it; a
/// cluster's pose is the mean weighted by votes.
std::vector<PoseHypothesis> ClusterPoses(std::vector<PoseHypothesis> hypotheses,
                                         const Eigen::Vector3d& center,
                                         double distance,
                                         double angle,
                                         size_t max_clusters);

}  // namespace vantage
