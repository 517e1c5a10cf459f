#include "perception/model/mesh_import.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <cctype>
#include <charconv>
#include <cstring>
#include <exception>
#include <string>
#include <string_view>
#include <vector>

#include "common/format.h"
#include "perception/model/file_bytes.h"
#include "perception/model/isolated_work.h"

namespace vantage {
namespace {

constexpr size_t kLargestFile = 512U << 20U;  // bytes

Error NoMesh(const std::filesystem::path& file, const std::string& why) {
  return Error{
      ErrorCode::kCorrupt,
      Format("%s can't be read as a mesh (%s), expected a PLY, OBJ or STL file with triangles",
             file.c_str(),
             why.substr(0, why.find_last_not_of(" .\n") + 1).c_str())};
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

// What the child process hands over: a mesh as counts, vertices and triangles, or a sentence.
constexpr char kMeshFollows = 'm';
constexpr char kErrorFollows = 'e';

template <class T>
void Put(const T* values, size_t count, std::string* bytes) {
  const size_t size = count * sizeof(T);
  const size_t at = bytes->size();
  bytes->resize(at + size);
  if (size > 0) std::memcpy(bytes->data() + at, values, size);
}

std::string JoinParts(const aiScene& scene) {
  std::vector<std::array<float, 3>> vertices;
  std::vector<std::array<uint32_t, 3>> triangles;
  for (unsigned int part = 0; part < scene.mNumMeshes; ++part) {
    const aiMesh& from = *scene.mMeshes[part];
    const auto offset = static_cast<uint32_t>(vertices.size());
    for (unsigned int i = 0; i < from.mNumVertices; ++i) {
      const aiVector3D& vertex = from.mVertices[i];
      vertices.push_back({vertex.x, vertex.y, vertex.z});
    }
    for (unsigned int i = 0; i < from.mNumFaces; ++i) {
      const aiFace& face = from.mFaces[i];
      if (face.mNumIndices != 3) continue;
      triangles.push_back(
          {face.mIndices[0] + offset, face.mIndices[1] + offset, face.mIndices[2] + offset});
    }
  }
  std::string bytes(1, kMeshFollows);
  const std::array<size_t, 2> counts = {vertices.size(), triangles.size()};
  Put(counts.data(), counts.size(), &bytes);
  Put(vertices.data(), vertices.size(), &bytes);
  Put(triangles.data(), triangles.size(), &bytes);
  return bytes;
}

// Runs in the child process. Debian's assimp stops the program where its assertions fail, which
// files from outside can bring about.
std::string ImportWithAssimp(const std::string& bytes, const std::string& suffix) {
  try {
    Assimp::Importer importer;
    // Only geometry is wanted; materials would make it open other files.
    const aiScene* scene = importer.ReadFileFromMemory(
        bytes.data(),
        bytes.size(),
        aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_PreTransformVertices,
        suffix.c_str());
    if (scene == nullptr) {
      const std::string why = importer.GetErrorString();
      return kErrorFollows +
             (why == "std::bad_alloc" ? "it takes too much memory for its size" : why);
    }
    return JoinParts(*scene);
  } catch (const std::exception& exception) {
    return kErrorFollows + std::string(exception.what());
  }
}

Result<TriangleMesh> TakeMesh(const std::filesystem::path& file,
                              std::string_view bytes,
                              double scale) {
  if (bytes.starts_with(kErrorFollows)) return NoMesh(file, std::string(bytes.substr(1)));
  std::array<size_t, 2> counts{};
  constexpr size_t kRow = 12;  // bytes of a vertex or triangle
  if (!bytes.starts_with(kMeshFollows) || bytes.size() < 1 + sizeof(counts)) {
    return NoMesh(file, "the importer left no result");
  }
  std::memcpy(counts.data(), bytes.data() + 1, sizeof(counts));
  bytes.remove_prefix(1 + sizeof(counts));
  const auto [vertices, triangles] = counts;
  if (vertices > bytes.size() || triangles > bytes.size() ||
      (vertices + triangles) * kRow != bytes.size()) {
    return NoMesh(file, "the importer left a result that is not whole");
  }
  if (triangles == 0) return NoMesh(file, "it has no triangles");
  TriangleMesh mesh;
  for (size_t i = 0; i < vertices; ++i) {
    Eigen::Vector3f vertex;
    std::memcpy(vertex.data(), bytes.data() + i * kRow, kRow);
    mesh.vertices.emplace_back((scale * vertex.cast<double>()).cast<float>());
  }
  mesh.triangles.resize(triangles);
  std::memcpy(mesh.triangles.data(), bytes.data() + vertices * kRow, triangles * kRow);
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
  // Of text with the shortest lines the importer makes up to 35 times its bytes. What the lists in
  // a PLY claim to hold may be any number.
  constexpr size_t kMemoryPerByte = 100;
  const IsolationLimits limits{.memory = (size_t{1} << 30U) + kMemoryPerByte * bytes->size()};
  const Result<std::string> imported =
      RunIsolated([&bytes, &suffix] { return ImportWithAssimp(*bytes, suffix.substr(1)); }, limits);
  if (!imported) return NoMesh(file, "the importer " + imported.error().message);
  return TakeMesh(file, *imported, scale);
}

}  // namespace vantage
