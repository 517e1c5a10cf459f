#pragma once

#include <optional>
#include <span>
#include <vector>

#include "common/camera_model.h"
#include "common/result.h"
#include "common/so3.h"
#include "planner/planned_object.h"

namespace vantage {

struct OcclusionParameters {
  CameraModel camera{};  ///< the sensor's; what is outside of its image is not seen
  /// m, world, of the table's surface, through which nothing is seen; none: there is no table.
  std::optional<double> table_height;

  Result<void> Validate() const;
};

/// How much of an object can be seen from a place.
struct Visibility {
  static constexpr int kNone = -1;   ///< No occluder
  static constexpr int kTable = -2;  ///< The table
  static constexpr int kImage = -3;  ///< It is outside of the image

  double share = 1.0;    ///< of the pixels that it would have alone in an endless image
  int occluder = kNone;  ///< what hides most of it: index of an object, or one of the above

  bool operator==(const Visibility&) const = default;
};

/// By how much the probability that an object is found falls when part of it is hidden: 1 from
/// three quarters visible on, 0 below one quarter, linear between (half of a model must be seen to
/// be taken as found). What is not found counts as missed.
double UnhiddenFactor(const Visibility& visibility);

/// From every candidate: renders each object's mesh at its estimate into a small depth image (a
/// tile of 32 x 32 px about it), alone and with all that may hide it. Only objects whose enclosing
/// balls overlap in the image are rendered together; those without a mesh neither hide nor are
/// hidden. A camera below the table sees nothing of what stands on it.
/// @return candidate by candidate, all objects of each.
std::vector<Visibility> FindOcclusion(const OcclusionParameters& parameters,
                                      std::span<const Pose> candidates,
                                      std::span<const PlannedObject> objects);

/// FindOcclusion, done again only when an object or a candidate is not as it was.
class OcclusionCache {
 public:
  explicit OcclusionCache(const OcclusionParameters& parameters) : parameters_(parameters) {}

  /// The result is the cache's until the next call.
  std::span<const Visibility> Find(std::span<const Pose> candidates,
                                   std::span<const PlannedObject> objects);

 private:
  // What the answer depends on.
  struct Placed {
    const TriangleMesh* mesh;
    Eigen::Matrix4d T_world_object;
    Eigen::Vector3d center_world;
    double radius;
    bool operator==(const Placed&) const = default;
  };

  OcclusionParameters parameters_;
  std::vector<Pose> candidates_;
  std::vector<Placed> placed_;
  std::vector<Visibility> found_;
};

}  // namespace vantage
