#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <span>
#include <string>

#include "common/result.h"
#include "common/so3.h"
#include "common/symmetry_group.h"
#include "common/triangle_mesh.h"
#include "perception/model/object_model.h"

namespace vantage {

/// A model of a scan, m, with the symmetry that its shape has. Errors as ImportMesh and
/// CheckAndMendMesh, which name the file.
Result<ObjectModel> LoadScan(const std::string& id, const std::filesystem::path& file);

/// The symmetry of a shape, as far as scans tell: turns about the principal axes of the surface
/// through its centroid that bring 95 % of it to within 1.5 % of the diameter of itself; every turn
/// when those by 37 and 101 deg do, half turns otherwise.
SymmetryGroup MeasureSymmetry(const TriangleMesh& mesh);

/// Points of an object brought onto its mesh.
struct ScanAlignment {
  Pose T_mesh_points = Pose::Identity();
  double median = 0.0;  ///< m, distance of the points to the surface
};

/// Point-to-plane ICP (Chen, Medioni 1992) from a start that is off by some mm and degrees.
/// @param points at least one, finite.
ScanAlignment AlignToScan(std::span<const Eigen::Vector3d> points,
                          const TriangleMesh& mesh,
                          const Pose& T_mesh_points_start);

}  // namespace vantage
