#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/result.h"
#include "common/symmetry_group.h"
#include "common/triangle_mesh.h"

namespace vantage {

/// A known object: what `vantage-model build` makes of a mesh and estimators, fusion and reports
/// use. A model folder holds model.toml, mesh.ply (m), samples.ply, and the estimators' matching
/// tables (ppf.bin), which are made again when they are absent or belong to another mesh.
struct ObjectModel {
  std::string id;                     ///< The folder's name.
  TriangleMesh mesh;                  ///< m, in the frame of the mesh that it was built from.
  std::vector<SurfacePoint> samples;  ///< Blue-noise surface samples with outward normals.
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< m, surface centroid.
  double diameter = 0.0;              ///< m
  SymmetryGroup symmetry;             ///< As far as known; the trivial group otherwise.
  uint64_t mesh_hash = 0;             ///< FNV-1a of vertices and triangles.
};

/// Errors: no such folder, no mesh in it, a file that is not what it claims, a mesh that does not
/// match the hash in model.toml.
Result<ObjectModel> LoadObjectModel(const std::filesystem::path& folder);

/// Writes the folder whole or not at all (a temporary folder beside it, then renamed).
Result<void> SaveObjectModel(const ObjectModel& model, const std::filesystem::path& folder);

}  // namespace vantage
