#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "common/result.h"
#include "common/triangle_mesh.h"

namespace vantage {

// The two kinds of PLY file in a model folder: binary little-endian, float coordinates in metres,
// exactly the elements that are written here. Other people's PLY files go through mesh_import.h.

/// mesh.ply: vertices x y z, faces of three indices.
Result<void> WriteMeshPly(const TriangleMesh& mesh, const std::filesystem::path& file);

/// Errors: absent, another layout, counts that differ from the file's size, vertices that are not
/// finite, indices out of range, faces that are no triangles. Allocates no more than the file's
/// size claims to hold and truly holds.
Result<TriangleMesh> ReadMeshPly(const std::filesystem::path& file);

/// samples.ply: vertices x y z nx ny nz.
Result<void> WriteSamplesPly(std::span<const SurfacePoint> samples,
                             const std::filesystem::path& file);

/// Errors as ReadMeshPly, and normals that are not of unit length within 1 %.
Result<std::vector<SurfacePoint>> ReadSamplesPly(const std::filesystem::path& file);

}  // namespace vantage
