#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "vantage/orientation_histogram_t.hpp"

namespace vantage {

/// An orientation and its share of a histogram's weight.
struct OrientationSample {
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();  ///< q_world_object
  double weight = 0.0;                                    ///< sums to 1
};

/// The cells of a histogram, each at its representative orientation with its probability: w_r times
/// the cell's area (paper 4.2). Cells that are none of the grid's, weights that are not positive
/// and grids that there can't be are left out.
std::vector<OrientationSample> SamplesOf(const orientation_histogram_t& histogram);

/// The rotated vector's place and what it hides: SO(3) as a circle over each point of the sphere
/// (Hopf's fibration).
struct FiberPlace {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< unit, q v: the sphere's point
  double angle = 0.0;  ///< rad in [-pi, pi), about `direction`, from the reference carried there
};

/// @param v unit, in the object's frame.
/// @param reference has angle 0 at its direction; elsewhere 0 is the reference turned to there by
///   the shortest rotation, which is not unique opposite of the reference's direction.
FiberPlace PlaceOf(const Eigen::Quaterniond& q,
                   const Eigen::Vector3d& v,
                   const Eigen::Quaterniond& reference);

/// A place of the sphere where much of the weight is, with what is on the circle over it.
struct FiberSpot {
  static constexpr size_t kNumBins = 36;  ///< of 10 degrees each, the first from -180 degrees
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
  double weight = 0.0;                                            ///< share of all within the spot
  std::vector<double> bins = std::vector<double>(kNumBins, 0.0);  ///< share of all by fiber angle
};

/// The heaviest places, at most `count`, none with less than 2 % of the weight: each is the middle
/// of a cap of `radius` (rad); a sample counts for the first that holds it.
std::vector<FiberSpot> FindSpots(const std::vector<OrientationSample>& samples,
                                 const Eigen::Vector3d& v,
                                 const Eigen::Quaterniond& reference,
                                 double radius,
                                 size_t count);

}  // namespace vantage
