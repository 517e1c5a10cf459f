#include "perception/model/mesh_import.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <charconv>
#include <exception>
#include <string>
#include <string_view>

#include "common/format.h"
#include "perception/model/file_bytes.h"

namespace vantage {
namespace {

constexpr size_t kLargestFile = 512U << 20U;  // bytes

Error NoMesh(const std::filesystem::path& file, const std::string& why) {
  return Error{ErrorCode::kCorrupt,
               Format("%s can't be read as a mesh: %s", file.c_str(), why.c_str())};
}

// The importer allocates what a PLY header's counts claim. Every row of every element takes at
// least one byte a property, so a count that the file can't hold is found before.
Result<void> CheckPlyCounts(const std::filesystem::path& file, std::string_view bytes) {
  size_t rows = 0;
  size_t least_bytes = 0;
  size_t end_of_header = 0;
  for (size_t at = 0; at < bytes.size();) {
    const size_t end = std::min(bytes.find_first_of("\r\n", at), bytes.size());
    std::string_view line = bytes.substr(at, end - at);
    at = end + 1;
    if (line.starts_with("end_header")) {
      end_of_header = end;
      break;
    }
    if (line.starts_with("property")) {
      least_bytes += rows;
    } else if (line.starts_with("element")) {
      const size_t start = line.find_last_of(" \t");
      const char* first = line.data() + (start == std::string_view::npos ? 0 : start + 1);
      const auto [last, error] = std::from_chars(first, line.data() + line.size(), rows);
      if (error != std::errc() || rows > bytes.size()) {
        return NoMesh(file,
                      Format("\"%.60s\", expected a count that fits the file's %zu bytes",
                             std::string(line).c_str(),
                             bytes.size()));
      }
    }
  }
  if (end_of_header == 0) return NoMesh(file, "the PLY header has no end_header");
  if (least_bytes > bytes.size() - end_of_header) {
    return NoMesh(file,
                  Format("%zu bytes follow the PLY header, expected at least %zu for its counts",
                         bytes.size() - end_of_header,
                         least_bytes));
  }
  return {};
}

TriangleMesh JoinParts(const aiScene& scene, double scale) {
  TriangleMesh mesh;
  for (unsigned int part = 0; part < scene.mNumMeshes; ++part) {
    const aiMesh& from = *scene.mMeshes[part];
    const auto offset = static_cast<uint32_t>(mesh.vertices.size());
    for (unsigned int i = 0; i < from.mNumVertices; ++i) {
      const aiVector3D& vertex = from.mVertices[i];
      mesh.vertices.emplace_back(static_cast<float>(scale * static_cast<double>(vertex.x)),
                                 static_cast<float>(scale * static_cast<double>(vertex.y)),
                                 static_cast<float>(scale * static_cast<double>(vertex.z)));
    }
    for (unsigned int i = 0; i < from.mNumFaces; ++i) {
      const aiFace& face = from.mFaces[i];
      if (face.mNumIndices != 3) continue;
      mesh.triangles.push_back(
          {face.mIndices[0] + offset, face.mIndices[1] + offset, face.mIndices[2] + offset});
    }
  }
  return mesh;
}

}  // namespace

Result<TriangleMesh> ImportMesh(const std::filesystem::path& file, double scale) {
  std::string suffix = file.extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  if (suffix != ".ply" && suffix != ".obj" && suffix != ".stl") {
    return Error{ErrorCode::kInvalidArgument,
                 Format("mesh %s has the suffix \"%s\", expected .ply, .obj or .stl",
                        file.c_str(),
                        suffix.c_str())};
  }
  const Result<std::string> bytes = ReadFileBytes(file, kLargestFile);
  if (!bytes) return bytes.error();
  if (bytes->empty()) return NoMesh(file, "it is empty");
  if (suffix == ".ply") {
    if (Result<void> counts = CheckPlyCounts(file, *bytes); !counts) return counts.error();
  }
  try {
    Assimp::Importer importer;
    // Only geometry is wanted; materials would make it open other files.
    const aiScene* scene = importer.ReadFileFromMemory(
        bytes->data(),
        bytes->size(),
        aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_PreTransformVertices,
        suffix.c_str() + 1);
    if (scene == nullptr) return NoMesh(file, importer.GetErrorString());
    TriangleMesh mesh = JoinParts(*scene, scale);
    if (mesh.triangles.empty()) return NoMesh(file, "it has no triangles");
    return mesh;
  } catch (const std::exception& exception) {
    return NoMesh(file, exception.what());
  }
}

}  // namespace vantage
