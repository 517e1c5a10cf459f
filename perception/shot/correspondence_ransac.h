#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "common/triangle_mesh.h"

namespace vantage {

/// A point of the target that may be a point of the model.
struct Correspondence {
  uint32_t keypoint = 0;  ///< of the target; those of one keypoint follow each other
  SurfacePoint query;     ///< p_q, on the target
  SurfacePoint match;     ///< p_m, on the model
};

struct RansacParameters {
  double min_distance = 0.0;        ///< m, t_r of the paper
  double distance_tolerance = 0.0;  ///< m, t_d of the paper
  double angle_tolerance = 0.0;     ///< rad, t_alpha of the paper
  double inlier_distance = 0.0;     ///< m, between a query and its moved match
  double probability = 0.99;        ///< that the largest consensus was found when the search ends
  int max_iterations = 0;           ///< triplets
  int max_hypotheses = 0;
};

/// Conditions 2 to 5 of paper section 3.2 on a triplet: neither its query nor its match points lie
/// on a line, they are `min_distance` apart, their distances agree, and so do corresponding angles:
/// of the two triangles, and of the normals with each other and with the triangles' sides.
bool MeetsConditions(const std::array<Correspondence, 3>& triplet,
                     const RansacParameters& parameters);

/// Draws after which one that succeeds with `chance` each time has come up with `probability`:
/// log(1 - probability) / log(1 - chance), rounded up, at most `largest` (Fischler, Bolles 1981).
int RequiredIterations(double chance, double probability, int largest);

/// The rigid motion that brings the matches nearest to their queries, positions and normals
/// (least squares, Kabsch 1976). @param normal_weight m^2, of a normal beside a position.
Pose AlignMatches(std::span<const Correspondence> pairs, double normal_weight);

/// A rigid motion, and how many keypoints of the target it explains.
struct ConsensusPose {
  Pose T_query_match = Pose::Identity();
  int inliers = 0;
};

/// RANSAC on correspondences, paper section 3.2: the motions that most of them agree with.
class CorrespondenceRansac {
 public:
  /// Motions that differ, most inliers first; ends when it is unlikely that one of more is found.
  /// The first of a triplet is any correspondence, the others of those that meet the conditions
  /// with it. Valid until the next call; allocates nothing once warm.
  std::span<const ConsensusPose> Run(std::span<const Correspondence> correspondences,
                                     const RansacParameters& parameters,
                                     Rng& rng);
  /// Triplets that the last Run drew.
  [[nodiscard]] int iterations() const { return iterations_; }

 private:
  void FindPartners(std::span<const Correspondence> all, uint32_t first);
  void Spread(std::span<const Correspondence> all);
  int Count(std::span<const Correspondence> all, const Pose& T_query_match);
  void CollectInliers(std::span<const Correspondence> all, const Pose& T_query_match);
  void Keep(const ConsensusPose& pose);
  void Refit(std::span<const Correspondence> all, ConsensusPose* pose);

  RansacParameters parameters_;
  Eigen::Vector3d center_ = Eigen::Vector3d::Zero();  // Mean of the matches.
  std::vector<uint32_t> order_;
  std::vector<uint32_t> partners_;
  std::vector<float> lanes_;        // The correspondences, value by value.
  std::vector<int32_t> is_marked_;  // Of the last search, 0 or not.
  std::vector<Correspondence> inliers_;
  std::vector<ConsensusPose> kept_;
  int iterations_ = 0;
};

}  // namespace vantage
