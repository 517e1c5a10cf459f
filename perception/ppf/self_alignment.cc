#include "perception/ppf/self_alignment.h"

#include <algorithm>

#include "perception/ppf/ppf_voting.h"
#include "perception/refinement/refinement.h"

namespace vantage {
namespace {

constexpr double kTolerance = 0.03;        // Of the diameter, of a point to the moved surface.
constexpr double kLikeNormals = 0.7;       // Cosine of 45 deg.
constexpr double kMinShare = 0.75;         // Of the surface that must come to lie on itself.
constexpr double kApart = 10.0 * kDegree;  // Between alignments that count as different.
constexpr double kFocal = 500.0;           // px; decides only the weights of points.

double AlignedShare(const NearestGrid& grid,
                    std::span<const SurfacePoint> points,
                    double diameter,
                    const Pose& T) {
  const Eigen::Isometry3f T_inverse(T.inverse().matrix().cast<float>());
  const auto tolerance = static_cast<float>(kTolerance * diameter);
  size_t aligned = 0;
  for (const SurfacePoint& point : points) {
    const Eigen::Vector3f place = T_inverse * point.position;
    const uint32_t nearest = grid.Find(place);
    if (nearest == NearestGrid::kNone) continue;
    const SurfacePoint& target = grid.points()[nearest];
    const bool is_near = (target.position - place).norm() <= tolerance;
    const Eigen::Vector3f normal = T_inverse.linear() * point.normal;
    if (is_near && static_cast<double>(target.normal.dot(normal)) > kLikeNormals) ++aligned;
  }
  return static_cast<double>(aligned) / static_cast<double>(points.size());
}

}  // namespace

std::vector<Pose> FindSelfAlignments(const PpfTable& table,
                                     const NearestGrid& grid,
                                     const ModelShape& model,
                                     const SymmetryGroup& symmetry,
                                     Rng& rng) {
  PpfVotingParameters voting;
  voting.max_references = 100;
  voting.peaks_per_reference = 20;
  voting.max_hypotheses = 100;
  voting.cluster_angle_deg = 8.0;
  const RefinementParameters refinement;
  ScenePoints scene;
  scene.Assign(table.points(), kFocal, refinement.noise);
  std::vector<Pose> alignments;
  for (const PoseHypothesis& voted : VotePoses(table, table.points(), model.center, voting, rng)) {
    // Points of the model take the place of a scene; its "camera" is the model's frame.
    const Pose T =
        RefineCoarse(grid, model, voted.T_camera_object, scene, refinement).T_camera_object;
    const Eigen::Quaterniond q(T.linear());
    if (SymmetricAngle(symmetry, Eigen::Quaterniond::Identity(), q) < kApart) continue;
    if (AlignedShare(grid, table.points(), model.diameter, T) < kMinShare) continue;
    const bool is_known = std::any_of(alignments.begin(), alignments.end(), [&](const Pose& other) {
      return GeodesicAngle(Eigen::Quaterniond(other.linear()), q) < kApart;
    });
    if (!is_known) alignments.push_back(T);
  }
  return alignments;
}

}  // namespace vantage
