#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "common/symmetry_group.h"

namespace vantage {

/// A symmetry group that was measured, from a mesh or from a contingency table (paper 6.3), and how
/// far to trust it. Confidences are in [0, 1]; 0.5 is just a symmetry.
struct FoundSymmetry {
  struct Axis {
    Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
    int order = 0;            ///< rotations by 2 pi / order; 0: all rotations about it
    double confidence = 1.0;  ///< of the worst of its rotations
  };
  /// A plane, through a point near the center, whose reflection maps the object onto itself. No
  /// rotation: told for people alone.
  struct Mirror {
    Eigen::Vector3d normal = Eigen::Vector3d::UnitX();
    double residual = 0.0;  ///< root mean square distance, diameters
  };
  /// A rotation that detections take for no rotation, but not from everywhere.
  struct Confusion {
    Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
    double weight = 0.0;               ///< share of all detections
    double share_of_directions = 0.0;  ///< of the viewing directions from which it occurs
  };

  SymmetryGroup group;
  std::vector<Axis> axes;  ///< highest order first; of a sphere none
  std::vector<Mirror> mirrors;
  std::vector<Confusion> confusions;  ///< heaviest first
  double confidence = 1.0;            ///< that the group is this one, neither smaller nor larger
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< m, in the mesh; the axes pass through it
  double center_offset = 0.0;  ///< m, from the surface's centroid to the nearest such point
  double residual = 0.0;       ///< of the worst element, diameters
  /// Every rotation is a symmetry: the orientation can't be told and needn't be. There is no
  /// SymmetryGroup for it; `group` is the largest one there is, continuous with flips.
  bool is_sphere = false;
};

/// Axes of a group, each rotation's confidence being `confidence` of its index among the elements
/// (finite), or of 0 and 1 for the turns and the flips (continuous).
std::vector<FoundSymmetry::Axis> AxesOf(const SymmetryGroup& group,
                                        const std::vector<double>& confidence);

/// For people: axes, mirrors, confusions and the center, one a line.
std::string FoundSymmetryText(const FoundSymmetry& found);

}  // namespace vantage
