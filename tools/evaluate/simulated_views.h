#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/camera_model.h"
#include "common/result.h"
#include "common/rng.h"
#include "perception/model/object_model.h"

namespace vantage {

/// What a simulated sequence of views is for.
enum class SequenceKind {
  kCircle,  ///< the paper's: all around the object at one elevation (section 7.3, Fig. 13)
  kRandom,  ///< every sequence from other places, of another pose of the object
};

/// "circle", "random".
std::string Name(SequenceKind kind);

/// Where cameras of a sequence are. Distances are to the object's center and hold for objects of up
/// to about 0.2 m; of larger ones they all grow alike, so that the whole object stays in the image
/// and beyond the sensor's nearest depth.
struct SimulatedViewParameters {
  int circle_views = 30;               ///< evenly around: 12 deg apart (section 7.3)
  double circle_elevation_deg = 45.0;  ///< deg, above the table (section 7.3)
  double circle_distance = 0.75;       ///< m

  int random_views = 12;
  double lowest_elevation_deg = 20.0;   ///< deg, uniform from here
  double highest_elevation_deg = 75.0;  ///< deg, up to here
  double nearest_distance = 0.6;        ///< m, uniform from here
  double farthest_distance = 0.9;       ///< m, up to here
  /// m, what the camera looks at is uniform in a cube of this half side about the center.
  double aim_jitter = 0.03;

  [[nodiscard]] int NumViews(SequenceKind kind) const;
  Result<void> Validate() const;
};

/// An object on a level table at z = 0 and the places that it is seen from.
struct SimulatedViews {
  Pose T_world_object = Pose::Identity();
  std::vector<Pose> T_world_camera;
  double scale = 1.0;  ///< by which the parameters' distances were multiplied
};

/// The views of one sequence. The object's lowest vertex touches the table and its center is above
/// the origin. It is turned at random about the vertical, upright as its model is, in the circle
/// and in random sequences of even index; in those of odd index its orientation is uniform over
/// SO(3), as if something held it. Circles keep the image upright; in random sequences azimuth and
/// roll about the optical axis are uniform.
/// @param nearest m, of the sensor.
SimulatedViews MakeSimulatedViews(const ObjectModel& model,
                                  SequenceKind kind,
                                  int index,
                                  const SimulatedViewParameters& parameters,
                                  const CameraModel& camera,
                                  double nearest,
                                  Rng& rng);

}  // namespace vantage
