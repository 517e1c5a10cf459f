// Runs vantage-model as its users do.

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <utility>

#include "common/format.h"
#include "common/so3.h"
#include "fusion/confusion/contingency_file.h"
#include "perception/model/file_bytes.h"
#include "perception/model/model_generator.h"
#include "perception/model/object_model.h"
#include "tests/tools/run_program.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTetrahedron =
    "v 0 0 0\nv 60 0 0\nv 0 60 0\nv 0 0 60\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

class ModelTool : public ToolTest {
 protected:
  ModelTool() : ToolTest("vantage-model") {}
};

TEST_F(ModelTool, GeneratesWhatLoads) {
  const ProgramOutput output = Run("generate mug gear --output m");
  ASSERT_EQ(output.exit_code, 0) << output.text;
  for (const char* name : {"mug", "gear"}) {
    const Result<ObjectModel> model = LoadObjectModel(scratch() / "m" / name);
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_TRUE(fs::exists(scratch() / "m" / name / "ppf.bin"));
  }
  EXPECT_FALSE(fs::exists(scratch() / "m" / "filter"));
  const ProgramOutput info = Run("info m/gear");
  EXPECT_EQ(info.exit_code, 0);
  EXPECT_NE(info.text.find("6-fold about (0, 0, 1)"), std::string::npos) << info.text;
  EXPECT_NE(info.text.find("pairs"), std::string::npos) << info.text;
}

TEST_F(ModelTool, BuildsFromAMeshInItsUnit) {
  std::ofstream(scratch() / "part.obj") << kTetrahedron;
  const ProgramOutput output =
      Run("build part.obj --unit mm --symmetry cyclic:3:1,1,1 --output models/wedge");
  ASSERT_EQ(output.exit_code, 0) << output.text;
  const Result<ObjectModel> model = LoadObjectModel(scratch() / "models" / "wedge");
  ASSERT_TRUE(model.ok()) << model.error().message;
  EXPECT_EQ(model->id, "wedge");
  EXPECT_NEAR(model->diameter, 0.06 * std::sqrt(2.0), 0.001);
  EXPECT_EQ(model->symmetry.elements.size(), 3U);
  EXPECT_EQ(model->source, "part.obj, unit mm");
  const ProgramOutput measured =
      Run("build part.obj --unit mm --symmetry measured --output models/wedge");
  ASSERT_EQ(measured.exit_code, 0) << measured.text;
  EXPECT_NE(measured.text.find("3-fold about (0.5774, 0.5774, 0.5774)"), std::string::npos)
      << measured.text;
  // Again in the same place.
  EXPECT_EQ(Run("build part.obj --unit mm --output models/wedge").exit_code, 0);
  EXPECT_EQ(LoadObjectModel(scratch() / "models" / "wedge")->symmetry.elements.size(), 1U);
}

constexpr int kSide = 12;  // rings and half the segments of a sphere

// Of radius 40 mm, in meters.
std::string SphereObj() {
  std::string text;
  for (int ring = 0; ring <= kSide; ++ring) {
    for (int segment = 0; segment < 2 * kSide; ++segment) {
      const double theta = std::numbers::pi * ring / kSide;
      const double phi = std::numbers::pi * segment / kSide;
      text += Format("v %.9f %.9f %.9f\n",
                     0.04 * std::sin(theta) * std::cos(phi),
                     0.04 * std::sin(theta) * std::sin(phi),
                     0.04 * std::cos(theta));
    }
  }
  for (int ring = 0; ring < kSide; ++ring) {
    for (int segment = 0; segment < 2 * kSide; ++segment) {
      const int a = ring * 2 * kSide + segment + 1;
      const int b = ring * 2 * kSide + (segment + 1) % (2 * kSide) + 1;
      if (ring > 0) text += Format("f %d %d %d\n", a, a + 2 * kSide, b);
      if (ring + 1 < kSide) text += Format("f %d %d %d\n", b, a + 2 * kSide, b + 2 * kSide);
    }
  }
  return text;
}

// A table of a model in which every trial's detection was a half turn about z off.
ContingencyTable HalfTurnTable(const ObjectModel& model) {
  ContingencyTable table;
  table.key.model_id = model.id;
  table.key.mesh_hash = Format("%016jx", uintmax_t{model.mesh_hash});
  table.key.estimator = "ppf";
  table.key.num_directions = 20;
  DirectionTrials direction;
  direction.trials = 40;
  const Eigen::Quaterniond turn = ExpSo3(Eigen::Vector3d(0.0, 0.0, std::numbers::pi));
  direction.differences = {{DifferenceCount::StepsOf(Eigen::Quaterniond::Identity()), 20},
                           {DifferenceCount::StepsOf(turn), 20}};
  std::ranges::sort(direction.differences, {}, &DifferenceCount::steps);
  table.directions.assign(20, direction);
  return table;
}

TEST_F(ModelTool, MeasuresASphere) {
  std::ofstream(scratch() / "ball.obj") << SphereObj();
  const ProgramOutput built =
      Run("build ball.obj --unit m --symmetry measured --no-tables --output ball");
  ASSERT_EQ(built.exit_code, 0) << built.text;
  EXPECT_NE(built.text.find("use its position, not its orientation"), std::string::npos)
      << built.text;
  const Result<ObjectModel> model = LoadObjectModel(scratch() / "ball");
  ASSERT_TRUE(model.ok()) << model.error().message;
  EXPECT_EQ(model->symmetry.kind, SymmetryGroup::Kind::kContinuous);
  EXPECT_TRUE(model->symmetry.flips);
  const ProgramOutput symmetry = Run("symmetry ball");
  EXPECT_EQ(symmetry.exit_code, 0);
  EXPECT_NE(symmetry.text.find("from the mesh: a sphere"), std::string::npos) << symmetry.text;
}

TEST_F(ModelTool, MeasuresSymmetryOfMeshAndTable) {
  ASSERT_EQ(Run("generate carton bracket --no-tables --output m").exit_code, 0);
  const ProgramOutput mesh = Run("symmetry m/carton/mesh.ply --unit m --weights mesh.csv");
  ASSERT_EQ(mesh.exit_code, 0) << mesh.text;
  EXPECT_TRUE(mesh.text.starts_with("from the mesh: 2-fold about ")) << mesh.text;
  EXPECT_NE(mesh.text.find(" with half turns about "), std::string::npos) << mesh.text;
  EXPECT_EQ(mesh.text.find("e-"), std::string::npos) << mesh.text;
  EXPECT_NE(mesh.text.find("wrote mesh.csv"), std::string::npos) << mesh.text;

  // The bracket has no symmetry, but its table says that it is taken for its half turn.
  const Result<ObjectModel> bracket = LoadObjectModel(scratch() / "m/bracket");
  ASSERT_TRUE(bracket.ok());
  ASSERT_TRUE(WriteContingencyTable(HalfTurnTable(*bracket), scratch() / "half.bin").ok());
  const ProgramOutput both = Run("symmetry m/bracket --table half.bin --weights table.csv");
  ASSERT_EQ(both.exit_code, 0) << both.text;
  EXPECT_NE(both.text.find("from the mesh: none"), std::string::npos) << both.text;
  EXPECT_NE(both.text.find("from the table of bracket and ppf: 2-fold about (0, 0, 1)"),
            std::string::npos)
      << both.text;

  // At least a line for each rotation that is a symmetry.
  for (const auto& [file, size] : {std::pair("mesh.csv", 4), std::pair("table.csv", 2)}) {
    std::ifstream stream(scratch() / file);
    std::string line;
    ASSERT_TRUE(std::getline(stream, line));
    EXPECT_EQ(line, "source,x,y,z,w,angle_deg,weight");
    double largest = 0.0;
    int num_lines = 0;
    for (; std::getline(stream, line); ++num_lines) {
      EXPECT_TRUE(line.starts_with(fs::path(file).stem().string() + ",")) << line;
      largest = std::max(largest, std::stod(line.substr(line.rfind(',') + 1)));
    }
    EXPECT_GE(num_lines, size) << file;
    EXPECT_GT(largest, 0.0) << file;
    EXPECT_LE(largest, 1.0) << file;
  }
}

TEST_F(ModelTool, BadInputToSymmetryIsOneSentence) {
  ASSERT_EQ(Run("generate carton bracket --no-tables --output m").exit_code, 0);
  const Result<ObjectModel> bracket = LoadObjectModel(scratch() / "m/bracket");
  ASSERT_TRUE(bracket.ok());
  ContingencyTable table = HalfTurnTable(*bracket);
  ASSERT_TRUE(WriteContingencyTable(table, scratch() / "bracket.bin").ok());
  table.key.mesh_hash = "0123456789abcdef";
  ASSERT_TRUE(WriteContingencyTable(table, scratch() / "other_mesh.bin").ok());
  const std::string bytes = EncodeContingencyTable(HalfTurnTable(*bracket));
  std::ofstream(scratch() / "cut.bin") << bytes.substr(0, bytes.size() / 2);
  std::ofstream(scratch() / "foreign.bin") << "no table, though long enough to be one of some kind";
  std::ofstream(scratch() / "line.obj") << "v 0 0 0\nv 60 0 0\nv 120 0 0\nf 1 2 3\n";
  ExpectRefused("symmetry", "mesh is required");
  ExpectRefused("symmetry none", "none: no such model folder or mesh");
  ExpectRefused("symmetry m", "m");
  ExpectRefused("symmetry line.obj", "line.obj is a mesh, expected --unit");
  ExpectRefused("symmetry line.obj --unit mm", "line.obj: the mesh has a surface of 0 m^2");
  ExpectRefused("symmetry line.obj --unit inch", "inch");
  ExpectRefused("symmetry line.obj --unit mm --table bracket.bin", "expected a model folder");
  ExpectRefused("symmetry m/bracket --table none.bin", "none.bin: no such file");
  ExpectRefused("symmetry m/bracket --table cut.bin", "cut.bin is damaged or cut off");
  ExpectRefused("symmetry m/bracket --table foreign.bin", "foreign.bin");
  ExpectRefused("symmetry m/carton --table bracket.bin", "bracket");
  ExpectRefused("symmetry m/bracket --table other_mesh.bin", "0123456789abcdef");
  ExpectRefused("symmetry m/bracket --weights none/w.csv", "none/w.csv");
}

// Files beyond a size are refused, as on a full disk: the table is the only one that is larger.
TEST_F(ModelTool, AModelWhoseTableCannotBeWrittenIsNotLeftWithoutIt) {
  ASSERT_EQ(Run("generate bracket --output m").exit_code, 0);
  const uintmax_t table = fs::file_size(scratch() / "m" / "bracket" / "ppf.bin");
  uintmax_t others = 0;
  for (const char* name : {"mesh.ply", "samples.ply", "model.toml"}) {
    others = std::max(others, fs::file_size(scratch() / "m" / "bracket" / name));
  }
  ASSERT_LT(others, table);
  fs::create_directory(scratch() / "n");
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto previous = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{table - 1, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  ExpectRefused("generate bracket --output n", "ppf.bin can't be written");
  ExpectRefused("generate bracket --output m", "ppf.bin can't be written");
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, previous);
  EXPECT_EQ(Run("info m/bracket").exit_code, 0);
}

TEST_F(ModelTool, DrawsAPicture) {
  ASSERT_EQ(Run("generate bracket --output m --no-tables").exit_code, 0);
  const ProgramOutput output = Run("picture m/bracket --output bracket.png");
  ASSERT_EQ(output.exit_code, 0) << output.text;
  EXPECT_GT(fs::file_size(scratch() / "bracket.png"), 10'000U);
}

TEST_F(ModelTool, BadInputIsOneSentenceAndExitCodeTwo) {
  std::ofstream(scratch() / "part.obj") << kTetrahedron;
  std::ofstream(scratch() / "empty.ply");
  std::ofstream(scratch() / "part.step") << "ISO-10303-21;";
  std::ofstream(scratch() / "flat.obj") << "v 0 0 0\nv 60 0 0\nv 0 60 0\nf 1 2 3\n";
  ExpectRefused("", "subcommand");
  ExpectRefused("melt", "subcommand");
  ExpectRefused("generate teapot --output m", "teapot");
  ExpectRefused("generate mug teapot --output m", "teapot");
  ExpectRefused("generate mug", "--output");
  ExpectRefused("build part.obj --output m/part", "--unit");
  ExpectRefused("build part.obj --unit inch --output m/part", "inch");
  ExpectRefused("build part.obj --unit m --output m/part", "looks like a wrong --unit");
  ExpectRefused("build none.obj --unit mm --output m/part", "none.obj: no such file");
  ExpectRefused("build empty.ply --unit mm --output m/part", "empty.ply");
  ExpectRefused("build part.step --unit mm --output m/part", "expected .ply, .obj or .stl");
  ExpectRefused("build flat.obj --unit mm --output m/part", "flat.obj: the mesh is flat");
  ExpectRefused("build part.obj --unit mm --output 'm/a b'", "model id \"a b\"");
  ExpectRefused("build part.obj --unit mm --id x --output m/part", "expected the folder's name");
  ExpectRefused("build part.obj --unit mm --symmetry 2-fold --output m/part",
                "symmetry \"2-fold\"");
  ExpectRefused("build part.obj --unit mm --output /proc/part", "/proc/part");
  ExpectRefused("info none", "no model folder none");
  ExpectRefused("picture none --output x.png", "no model folder none");
}

}  // namespace
}  // namespace vantage
