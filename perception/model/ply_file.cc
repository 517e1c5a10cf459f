#include "perception/model/ply_file.h"

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include "common/format.h"
#include "perception/model/file_bytes.h"

namespace vantage {
namespace {

static_assert(std::endian::native == std::endian::little, "PLY files are written little-endian");

constexpr size_t kLargestFile = 256U << 20U;  // bytes
constexpr size_t kVertexBytes = 3 * sizeof(float);
constexpr size_t kFaceBytes = 1 + 3 * sizeof(uint32_t);
constexpr size_t kSampleBytes = 6 * sizeof(float);

constexpr std::string_view kStart = "ply\nformat binary_little_endian 1.0\ncomment metres\n";
constexpr std::string_view kPosition = "property float x\nproperty float y\nproperty float z\n";
constexpr std::string_view kNormal = "property float nx\nproperty float ny\nproperty float nz\n";
constexpr std::string_view kFace = "property list uchar uint vertex_indices\n";
constexpr std::string_view kEnd = "end_header\n";

template <class T>
void Put(const T& value, std::string* bytes) {
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), &value, sizeof(T));
  bytes->append(raw.data(), raw.size());
}

void Put(const Eigen::Vector3f& vector, std::string* bytes) {
  for (int i = 0; i < 3; ++i) Put(vector[i], bytes);
}

// Takes one thing after the other off the front of a file's bytes.
class Cursor {
 public:
  explicit Cursor(std::string_view bytes) : bytes_(bytes) {}

  // True, and past it, when `text` comes next.
  bool Skip(std::string_view text) {
    if (!bytes_.starts_with(text)) return false;
    bytes_.remove_prefix(text.size());
    return true;
  }
  // "element NAME COUNT\n".
  std::optional<size_t> Element(std::string_view name) {
    if (!Skip("element ") || !Skip(name) || !Skip(" ")) return std::nullopt;
    size_t count = 0;
    const auto [end, error] = std::from_chars(bytes_.data(), bytes_.data() + bytes_.size(), count);
    if (error != std::errc()) return std::nullopt;
    bytes_.remove_prefix(static_cast<size_t>(end - bytes_.data()));
    if (!Skip("\n")) return std::nullopt;
    return count;
  }
  // Only where the caller knows that enough bytes are left.
  template <class T>
  T Take() {
    T value;
    std::memcpy(&value, bytes_.data(), sizeof(T));
    bytes_.remove_prefix(sizeof(T));
    return value;
  }
  Eigen::Vector3f TakeVector() {
    const float x = Take<float>();
    const float y = Take<float>();
    const float z = Take<float>();
    return {x, y, z};
  }
  [[nodiscard]] size_t left() const { return bytes_.size(); }

 private:
  std::string_view bytes_;
};

Error Corrupt(const std::filesystem::path& file, const std::string& what) {
  return Error{ErrorCode::kCorrupt,
               Format("%s: %s; build the model again with: vantage-model build (or generate)",
                      file.c_str(),
                      what.c_str())};
}

Error WrongSize(const std::filesystem::path& file, size_t found, const std::string& expected) {
  return Corrupt(file, Format("%zu bytes follow the header, expected %s", found, expected.c_str()));
}

}  // namespace

Result<void> WriteMeshPly(const TriangleMesh& mesh, const std::filesystem::path& file) {
  std::string bytes(kStart);
  bytes += Format("element vertex %zu\n", mesh.vertices.size());
  bytes += kPosition;
  bytes += Format("element face %zu\n", mesh.triangles.size());
  bytes += kFace;
  bytes += kEnd;
  for (const Eigen::Vector3f& vertex : mesh.vertices) Put(vertex, &bytes);
  for (const std::array<uint32_t, 3>& triangle : mesh.triangles) {
    Put(uint8_t{3}, &bytes);
    for (const uint32_t index : triangle) Put(index, &bytes);
  }
  return WriteFileBytes(file, bytes);
}

Result<TriangleMesh> ReadMeshPly(const std::filesystem::path& file) {
  const Result<std::string> bytes = ReadFileBytes(file, kLargestFile);
  if (!bytes) return bytes.error();
  Cursor cursor(*bytes);
  const bool starts = cursor.Skip(kStart);
  const std::optional<size_t> vertices = cursor.Element("vertex");
  const bool has_position = cursor.Skip(kPosition);
  const std::optional<size_t> faces = cursor.Element("face");
  const bool has_face = cursor.Skip(kFace);
  if (!starts || !vertices || !has_position || !faces || !has_face || !cursor.Skip(kEnd)) {
    return Corrupt(file, "is not a mesh as vantage-model writes it (binary little-endian PLY)");
  }
  // Counts are bounded by the file's size before they are multiplied.
  if (*vertices > cursor.left() || *faces > cursor.left() ||
      *vertices * kVertexBytes + *faces * kFaceBytes != cursor.left()) {
    return WrongSize(file, cursor.left(), Format("%zu vertices and %zu faces", *vertices, *faces));
  }
  TriangleMesh mesh;
  mesh.vertices.reserve(*vertices);
  for (size_t i = 0; i < *vertices; ++i) {
    mesh.vertices.push_back(cursor.TakeVector());
    if (!mesh.vertices.back().allFinite()) {
      return Corrupt(file, Format("vertex %zu is not finite", i));
    }
  }
  mesh.triangles.reserve(*faces);
  for (size_t i = 0; i < *faces; ++i) {
    const auto corners = cursor.Take<uint8_t>();
    if (corners != 3) {
      return Corrupt(file, Format("face %zu has %d corners, expected 3", i, int{corners}));
    }
    std::array<uint32_t, 3> triangle{};
    for (uint32_t& index : triangle) {
      index = cursor.Take<uint32_t>();
      if (index >= *vertices) {
        return Corrupt(
            file, Format("face %zu names vertex %u, expected 0 to %zu", i, index, *vertices - 1));
      }
    }
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

Result<void> WriteSamplesPly(std::span<const SurfacePoint> samples,
                             const std::filesystem::path& file) {
  std::string bytes(kStart);
  bytes += Format("element vertex %zu\n", samples.size());
  bytes += kPosition;
  bytes += kNormal;
  bytes += kEnd;
  for (const SurfacePoint& sample : samples) {
    Put(sample.position, &bytes);
    Put(sample.normal, &bytes);
  }
  return WriteFileBytes(file, bytes);
}

Result<std::vector<SurfacePoint>> ReadSamplesPly(const std::filesystem::path& file) {
  const Result<std::string> bytes = ReadFileBytes(file, kLargestFile);
  if (!bytes) return bytes.error();
  Cursor cursor(*bytes);
  const bool starts = cursor.Skip(kStart);
  const std::optional<size_t> count = cursor.Element("vertex");
  if (!starts || !count || !cursor.Skip(kPosition) || !cursor.Skip(kNormal) || !cursor.Skip(kEnd)) {
    return Corrupt(file, "is no samples as vantage-model writes them (binary little-endian PLY)");
  }
  if (*count > cursor.left() || *count * kSampleBytes != cursor.left()) {
    return WrongSize(file, cursor.left(), Format("%zu samples", *count));
  }
  std::vector<SurfacePoint> samples(*count);
  for (size_t i = 0; i < *count; ++i) {
    samples[i].position = cursor.TakeVector();
    samples[i].normal = cursor.TakeVector();
    if (!samples[i].position.allFinite()) {
      return Corrupt(file, Format("sample %zu is not finite", i));
    }
    if (!(std::abs(samples[i].normal.norm() - 1.0F) < 0.01F)) {
      return Corrupt(file, Format("the normal of sample %zu has not unit length", i));
    }
  }
  return samples;
}

}  // namespace vantage
