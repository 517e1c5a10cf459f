#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>

#include "common/rng.h"
#include "common/so3.h"
#include "common/triangle_mesh.h"

namespace vantage {

/// A pose in which an object may lie, before it was held against the image.
struct PoseHypothesis {
  Pose T_camera_object = Pose::Identity();
  double votes = 0.0;  ///< of its proposer; comparable within one call
};

/// Finds poses of known models from surface points of one segment: the part in which estimators
/// differ.
class PoseProposer {
 public:
  virtual ~PoseProposer() = default;
  /// How dense Propose() wants the scene points of a model, m between neighbors.
  [[nodiscard]] virtual double Spacing(size_t model) const = 0;
  /// Hypotheses that differ, most promising first; empty when nothing was found. Valid until the
  /// next call. The same for equal input and state of `rng`; allocates nothing once warm.
  /// @param scene points seen by the camera, in its coordinates, normals towards it.
  virtual std::span<const PoseHypothesis> Propose(size_t model,
                                                  std::span<const SurfacePoint> scene,
                                                  Rng& rng) = 0;
  /// Another that proposes the same, for another thread.
  [[nodiscard]] virtual std::unique_ptr<PoseProposer> Clone() const = 0;
};

}  // namespace vantage
