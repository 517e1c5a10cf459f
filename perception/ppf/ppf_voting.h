#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/result.h"
#include "common/rng.h"
#include "common/so3.h"
#include "perception/estimator/pose_proposer.h"
#include "perception/ppf/ppf_table.h"

namespace vantage {

struct PpfVotingParameters {
  double reference_share = 0.2;  ///< of the scene's points (Drost et al. 2010: 1/5)
  int min_references = 16;
  int max_references = 24;
  int turn_bins = 30;   ///< of the turn about the normal (Drost et al. 2010: 30)
  double spread = 0.1;  ///< bins; a feature this near to a border votes in both cells
  int peaks_per_reference = 3;
  double cluster_distance = 0.1;    ///< of the diameter, between centers of equal poses
  double cluster_angle_deg = 15.0;  ///< deg, between orientations of equal poses
  int max_hypotheses = 12;
  Result<void> Validate() const;
};

/// Counts of a reference point: for every model point and turn, how many scene pairs agree.
/// Row by row, model point first; points().size() * turn_bins values.
using VoteCounts = std::vector<uint32_t>;

/// The votes of all pairs (reference, other scene point), paper section 3.1.
void AccumulateVotes(const PpfTable& table,
                     std::span<const SurfacePoint> scene,
                     size_t reference,
                     const PpfVotingParameters& parameters,
                     VoteCounts* counts);

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
