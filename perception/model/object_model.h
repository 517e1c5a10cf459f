#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
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
  double diameter = 0.0;                             ///< m
  SymmetryGroup symmetry;  ///< As far as known; the trivial group otherwise.
  uint64_t mesh_hash = 0;  ///< FNV-1a of vertices and triangles.
  std::string source;      ///< What it was made from, for people.
};

/// Errors: no such folder, no mesh in it, a file that is not what it claims, a mesh that does not
/// match the hash in model.toml.
Result<ObjectModel> LoadObjectModel(const std::filesystem::path& folder);

/// Writes further files of a model into the folder that it is given.
using ModelFileWriter = std::function<Result<void>(const std::filesystem::path&)>;

/// Writes the folder whole or not at all (a temporary folder beside it, then renamed). A model
/// folder that is there already is replaced, with its matching tables. Errors: something else is
/// there, the model's id is not the folder's name, the system refuses, or as `add_files`.
/// @param add_files matching tables, written with the rest; may be empty.
Result<void> SaveObjectModel(const ObjectModel& model,
                             const std::filesystem::path& folder,
                             const ModelFileWriter& add_files = {});

/// 1 to 64 of A-Z a-z 0-9 _ - and no leading '-': fit for folders, channels and tables.
Result<void> CheckModelId(const std::string& id);

/// FNV-1a, 64 bits, of the vertices' and the triangles' bytes.
uint64_t HashMesh(const TriangleMesh& mesh);

}  // namespace vantage
