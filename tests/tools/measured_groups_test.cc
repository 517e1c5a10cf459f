// The measured symmetry of every bundled object and of scans, against what the objects are.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "fusion/symmetry/measured_symmetry.h"
#include "perception/model/mesh_check.h"
#include "perception/model/mesh_import.h"
#include "perception/model/model_generator.h"
#include "perception/model/symmetry_text.h"
#include "tests/tools/expected_groups.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

void ExpectGroup(const ExpectedGroup& expected, const TriangleMesh& mesh) {
  SCOPED_TRACE(std::string(expected.name) + ": " + expected.why);
  const Result<FoundSymmetry> found = MeasureSymmetry(mesh);
  ASSERT_TRUE(found.ok()) << found.error().message;
  const std::string text = SymmetryText(found->group);
  EXPECT_GE(found->confidence, 0.5) << text;
  EXPECT_LT(found->center_offset, 0.01 * mesh.Diameter()) << text;
  EXPECT_FALSE(found->is_sphere);
  if (expected.order == 0) {
    EXPECT_EQ(found->group.kind, SymmetryGroup::Kind::kContinuous) << text;
    EXPECT_EQ(found->group.flips, expected.flips) << text;
    return;
  }
  EXPECT_EQ(found->group.kind, SymmetryGroup::Kind::kFinite) << text;
  const size_t size = static_cast<size_t>(expected.order) * (expected.flips ? 2 : 1);
  EXPECT_EQ(found->group.elements.size(), size) << text;
}

// "ycb_Banana" of "ycb_Banana.obj".
std::string TestName(const testing::TestParamInfo<ExpectedGroup>& info) {
  return fs::path(info.param.name).stem().string();
}

class MeasuredGroupsOfObjects : public testing::TestWithParam<ExpectedGroup> {};

TEST_P(MeasuredGroupsOfObjects, AreWhatTheObjectsAre) {
  const Result<GeneratedObject> object = GenerateObject(GetParam().name);
  ASSERT_TRUE(object.ok()) << object.error().message;
  ExpectGroup(GetParam(), object->mesh);
}

INSTANTIATE_TEST_SUITE_P(All,
                         MeasuredGroupsOfObjects,
                         testing::ValuesIn(kGeneratedGroups),
                         TestName);

class MeasuredGroupsOfScans : public testing::TestWithParam<ExpectedGroup> {};

TEST_P(MeasuredGroupsOfScans, AreWhatTheObjectsAre) {
  const fs::path file = fs::path(VANTAGE_SOURCE_DIR) / "../shared/data/meshes" / GetParam().name;
  if (!fs::exists(file)) GTEST_SKIP() << file << " is not there";
  Result<TriangleMesh> mesh = ImportMesh(file, 1.0);
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  const float scale = 0.2F / static_cast<float>(mesh->Diameter());  // Their units differ.
  for (Eigen::Vector3f& vertex : mesh->vertices) vertex *= scale;
  ASSERT_TRUE(CheckAndMendMesh(&*mesh).ok());
  ExpectGroup(GetParam(), *mesh);
}

INSTANTIATE_TEST_SUITE_P(All, MeasuredGroupsOfScans, testing::ValuesIn(kScanGroups), TestName);

}  // namespace
}  // namespace vantage
