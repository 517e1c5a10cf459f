#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <new>
#include <sstream>
#include <string>

#include "common/format.h"
#include "common/rng.h"
#include "perception/model/file_bytes.h"
#include "perception/model/isolated_work.h"
#include "perception/model/mesh_check.h"
#include "perception/model/mesh_import.h"
#include "perception/model/mesh_primitives.h"
#include "perception/model/model_builder.h"
#include "perception/model/model_generator.h"
#include "tests/perception/model_test_support.h"

namespace vantage {
namespace {

using namespace std::string_literals;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

TriangleMesh Box() { return BeveledBox({0.04, 0.06, 0.1}, 0.004); }

// Why a mesh is refused; empty when it is not.
std::string Refusal(TriangleMesh mesh) {
  const Result<MeshMending> mending = CheckAndMendMesh(&mesh);
  return mending.ok() ? "" : mending.error().message;
}

void ExpectHas(const std::string& message, const std::string& part) {
  EXPECT_NE(message.find(part), std::string::npos) << message;
}

TEST(MeshCheck, RefusesWithTheReason) {
  EXPECT_EQ(Refusal(Box()), "");
  ExpectHas(Refusal({}), "is empty");
  TriangleMesh mesh = Box();
  mesh.triangles.clear();
  ExpectHas(Refusal(mesh), "is empty");
  mesh = Box();
  mesh.triangles[5][1] = 1000;
  ExpectHas(Refusal(mesh), "triangle (5) with vertex 1000");
  for (const float bad : {kNan, std::numeric_limits<float>::infinity()}) {
    mesh = Box();
    mesh.vertices[3].y() = bad;
    ExpectHas(Refusal(mesh), "vertex (3)");
  }
}

TEST(MeshCheck, SizesThatLookLikeAWrongUnitSaySo) {
  for (const float factor : {1000.0F, 0.001F, 1e20F, 1e-20F, 0.0F}) {
    TriangleMesh mesh = Box();
    for (Eigen::Vector3f& vertex : mesh.vertices) vertex *= factor;
    const std::string message = Refusal(mesh);
    if (factor == 0.0F) {
      ExpectHas(message, "degenerate");
    } else {
      ExpectHas(message, "--unit");
    }
  }
  // Just inside the limits.
  for (const float factor : {39.0F, 0.045F}) {
    TriangleMesh mesh = Box();
    for (Eigen::Vector3f& vertex : mesh.vertices) vertex *= factor;
    EXPECT_EQ(Refusal(mesh), "");
  }
}

TEST(MeshCheck, RefusesFlatAndThinMeshes) {
  TriangleMesh mesh = Box();
  const Eigen::Vector3f normal = Eigen::Vector3f(1.0F, 2.0F, -0.5F).normalized();
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex -= normal * normal.dot(vertex);
  ExpectHas(Refusal(mesh), "flat");
  mesh = Box();
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex = normal * normal.dot(vertex);
  ExpectHas(Refusal(mesh), "degenerate");
}

TEST(MeshCheck, MergesVerticesAndLeavesOutWhatCollapses) {
  const TriangleMesh box = Box();
  // Every triangle with corners of its own, as STL has it, one unused vertex and one sliver.
  TriangleMesh soup;
  for (const auto& triangle : box.triangles) {
    const auto first = static_cast<uint32_t>(soup.vertices.size());
    for (const uint32_t index : triangle) soup.vertices.push_back(box.vertices[index]);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  soup.vertices.emplace_back(9.0F, 9.0F, 9.0F);
  soup.triangles.push_back({0, 0, 1});
  const Result<MeshMending> mending = CheckAndMendMesh(&soup);
  ASSERT_TRUE(mending.ok()) << mending.error().message;
  EXPECT_EQ(soup.vertices.size(), box.vertices.size());
  EXPECT_EQ(soup.triangles.size(), box.triangles.size());
  EXPECT_EQ(mending->merged_vertices, 3 * box.triangles.size() + 1 - box.vertices.size());
  EXPECT_EQ(mending->removed_triangles, 1U);
  EXPECT_EQ(mending->open_edges, 0U);
  EXPECT_NEAR(SignedVolume(soup), SignedVolume(box), 1e-9);
}

TEST(MeshCheck, TurnsWhatIsInsideOut) {
  TriangleMesh mesh = Box();
  for (auto& triangle : mesh.triangles) std::swap(triangle[0], triangle[1]);
  ASSERT_LT(SignedVolume(mesh), 0.0);
  const Result<MeshMending> mending = CheckAndMendMesh(&mesh);
  ASSERT_TRUE(mending.ok());
  EXPECT_TRUE(mending->flipped);
  EXPECT_NEAR(SignedVolume(mesh), SignedVolume(Box()), 1e-12);
}

TEST(MeshCheck, CountsHolesAndDisagreement) {
  TriangleMesh mesh = Ellipsoid({0.05, 0.05, 0.05}, 48);
  mesh.triangles.erase(mesh.triangles.begin() + 500);
  std::swap(mesh.triangles[200][0], mesh.triangles[200][1]);
  const Result<MeshMending> mending = CheckAndMendMesh(&mesh);
  ASSERT_TRUE(mending.ok());
  EXPECT_EQ(mending->open_edges, 3U);
  EXPECT_EQ(mending->odd_edges, 3U);
  EXPECT_FALSE(mending->flipped);
}

// The same tetrahedron, 20 mm, in each format.
constexpr const char* kObj =
    "v 0 0 0\nv 20 0 0\nv 0 20 0\nv 0 0 20\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
constexpr const char* kPly =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float "
    "z\n"
    "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n20 0 0\n0 20 0\n0 0 20\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

std::string StlText() {
  std::ostringstream stl;
  stl << "solid t\n";
  for (const char* corners : {"0 0 0;0 20 0;20 0 0",
                              "0 0 0;20 0 0;0 0 20",
                              "0 0 0;0 0 20;0 20 0",
                              "20 0 0;0 20 0;0 0 20"}) {
    stl << "facet normal 0 0 0\nouter loop\n";
    std::istringstream list(corners);
    for (std::string corner; std::getline(list, corner, ';');) stl << "vertex " << corner << "\n";
    stl << "endloop\nendfacet\n";
  }
  stl << "endsolid t\n";
  return stl.str();
}

TEST(MeshImport, ReadsEachFormatToTheSameBody) {
  const ScratchFolder scratch;
  for (const auto& [name, text] : {std::pair<std::string, std::string>("a.obj", kObj),
                                   {"a.ply", kPly},
                                   {"a.STL", StlText()}}) {
    SCOPED_TRACE(name);
    ASSERT_TRUE(WriteFileBytes(scratch.path() / name, text).ok());
    Result<TriangleMesh> mesh = ImportMesh(scratch.path() / name, 1e-3);
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    const Result<MeshMending> mending = CheckAndMendMesh(&*mesh);
    ASSERT_TRUE(mending.ok()) << mending.error().message;
    EXPECT_EQ(mesh->vertices.size(), 4U);
    EXPECT_EQ(mesh->triangles.size(), 4U);
    EXPECT_EQ(mending->open_edges, 0U);
    EXPECT_NEAR(SignedVolume(*mesh), 8e-6 / 6.0, 1e-10);
  }
}

TEST(MeshImport, SplitsPolygonsAndLeavesOutLines) {
  const ScratchFolder scratch;
  const std::filesystem::path file = scratch.path() / "quad.obj";
  ASSERT_TRUE(WriteFileBytes(file, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nl 1 2\n").ok());
  const Result<TriangleMesh> mesh = ImportMesh(file, 1.0);
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_EQ(mesh->triangles.size(), 2U);
  EXPECT_NEAR(mesh->Area(), 1.0, 1e-6);
}

TEST(MeshImport, NamesWhatIsWrong) {
  const ScratchFolder scratch;
  const auto refusal = [&scratch](const std::string& name, const std::string& bytes) {
    const std::filesystem::path file = scratch.path() / name;
    VANTAGE_CHECK(WriteFileBytes(file, bytes).ok(), name);
    const Result<TriangleMesh> mesh = ImportMesh(file, 1.0);
    return mesh.ok() ? std::string() : mesh.error().message;
  };
  ExpectHas(ImportMesh(scratch.path() / "none.ply", 1.0).error().message, "none.ply: no such file");
  ExpectHas(refusal("mesh.txt", "x"), "expected .ply, .obj or .stl");
  ExpectHas(refusal("folder", "x"), "suffix");
  for (const char* name : {"void.ply", "void.obj", "void.stl"}) {
    ExpectHas(refusal(name, ""), "it is empty");
  }
  ExpectHas(refusal("text.ply", "hello\n"), "text.ply can't be read as a mesh");
  ExpectHas(refusal("points.obj", "v 0 0 0\nv 1 0 0\n"), "points.obj can't be read as a mesh");
  std::string hostile = kPly;
  hostile.replace(hostile.find("vertex 4"), 8, "vertex 4000000000");
  ExpectHas(refusal("hostile.ply", hostile), "expected a count that fits");
  hostile = kPly;
  hostile.replace(hostile.find("face 4"), 6, "face 120");
  ExpectHas(refusal("many.ply", hostile), "bytes follow the PLY header");
  hostile = kPly;
  hostile.replace(hostile.find("face 4"), 6, "face -1");
  ExpectHas(refusal("negative.ply", hostile), "expected a count that fits");
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

TEST(IsolatedWork, MemoryIsRefusedBeyondTheLimit) {
  const auto take = [](size_t bytes) {
    const IsolationLimits limits{.memory = size_t{64} << 20U};
    return *RunIsolated(
        [bytes] {
          try {
            return Format("took %zu", std::string(bytes, 'x').size());
          } catch (const std::bad_alloc&) {
            return std::string("refused");
          }
        },
        limits);
  };
  EXPECT_EQ(take(size_t{32} << 20U), "took 33554432");
  EXPECT_EQ(take(size_t{128} << 20U), "refused");
}

// Of 4 kB and with sound counts of elements, but a face that claims 300 million corners.
TEST(MeshImport, ListsThatTheFileCannotHoldTakeLittleMemory) {
  const ScratchFolder scratch;
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float "
      "y\nproperty float z\nelement face 4\nproperty list uint int vertex_indices\nend_header\n";
  bytes += std::string(48, '\0') + "\x00\xa3\xe1\x11"s + std::string(3900, '\0');
  const std::filesystem::path file = scratch.path() / "list.ply";
  ASSERT_TRUE(WriteFileBytes(file, bytes).ok());
  const Result<TriangleMesh> mesh = ImportMesh(file, 1.0);
  ASSERT_FALSE(mesh.ok());
  ExpectHas(mesh.error().message, "too much memory");
}

#endif

// Whatever is cut off or changed: a mesh or an error, never a crash, and what is a mesh passes or
// fails the check.
TEST(MeshImport, SurvivesCutAndFlippedFiles) {
  const ScratchFolder scratch;
  Rng rng(1);
  const auto feed = [&scratch](const std::string& name, const std::string& bytes) {
    const std::filesystem::path file = scratch.path() / name;
    VANTAGE_CHECK(WriteFileBytes(file, bytes).ok(), name);
    Result<TriangleMesh> mesh = ImportMesh(file, 1.0);
    if (mesh.ok()) static_cast<void>(CheckAndMendMesh(&*mesh).ok());
    return mesh.ok();
  };
  int read = 0;
  for (const auto& [name, text] : {std::pair<std::string, std::string>("a.obj", kObj),
                                   {"a.ply", kPly},
                                   {"a.stl", StlText()}}) {
    for (size_t length = 0; length < text.size(); length += 3) {
      read += feed(name, text.substr(0, length)) ? 1 : 0;
    }
    for (int i = 0; i < 100; ++i) {
      std::string changed = text;
      changed[rng.Below(static_cast<uint32_t>(text.size()))] = static_cast<char>(rng.Below(256));
      read += feed(name, changed) ? 1 : 0;
    }
  }
  EXPECT_GT(read, 50);
}

// Every mesh of the shared data makes a model with the unit that its table gives.
TEST(MeshImport, SharedMeshesMakeModels) {
  const std::filesystem::path folder =
      std::filesystem::path(VANTAGE_SOURCE_DIR) / ".." / "shared" / "data" / "meshes";
  std::ifstream table(folder / "meshes.csv");
  if (!table) GTEST_SKIP() << folder << " is absent";
  std::string line;
  std::getline(table, line);
  int count = 0;
  while (std::getline(table, line)) {
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    ASSERT_GT(cells.size(), 8U) << line;
    SCOPED_TRACE(cells[0]);
    const double scale = cells[7] == "mm" ? 1e-3 : 1.0;
    Result<TriangleMesh> mesh = ImportMesh(folder / cells[0], scale);
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    const Result<MeshMending> mending = CheckAndMendMesh(&*mesh);
    ASSERT_TRUE(mending.ok()) << mending.error().message;
    EXPECT_EQ(mesh->triangles.size() + mending->removed_triangles, std::stoul(cells[2]));
    EXPECT_EQ(std::to_string(mending->open_edges), cells[8]);
    EXPECT_NEAR(static_cast<double>(mesh->Bounds().sizes().norm()),
                scale * std::stod(cells[6]),
                2e-3 * scale * std::stod(cells[6]));
    EXPECT_GT(SignedVolume(*mesh), 0.0);
    ++count;
  }
  EXPECT_EQ(count, 26);
}

}  // namespace
}  // namespace vantage
