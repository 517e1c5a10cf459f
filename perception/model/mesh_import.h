#pragma once

#include <filesystem>

#include "common/result.h"
#include "common/triangle_mesh.h"

namespace vantage {

/// Reads a mesh that somebody else made: PLY, OBJ or STL by its suffix, all its parts joined,
/// polygons split into triangles, lines and points left out. Coordinates are multiplied by `scale`
/// (0.001 for a mesh in mm). What comes out still needs CheckAndMendMesh.
/// Errors: absent, larger than 512 MiB, another suffix, not what the suffix claims, no triangles.
Result<TriangleMesh> ImportMesh(const std::filesystem::path& file, double scale);

}  // namespace vantage
