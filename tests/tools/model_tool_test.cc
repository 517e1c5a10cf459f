// Runs vantage-model as its users do.

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>

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
