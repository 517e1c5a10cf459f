#include "tools/support/report_setup.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "common/rng.h"
#include "tests/tools/run_program.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

const fs::path kSource = VANTAGE_SOURCE_DIR;

TEST(ReportSetup, DemoLoads) {
  const Result<ReportSetup> setup = LoadReportSetup(kSource / "config" / "demo.toml");
  ASSERT_TRUE(setup.ok()) << setup.error().message;
  EXPECT_EQ(setup->camera, "XTION");
  ASSERT_TRUE(setup->table.has_value());
  EXPECT_DOUBLE_EQ(setup->table->height, 0.0);
  ASSERT_EQ(setup->truth.size(), 3U);
  for (const TruthObject& truth : setup->truth) {
    ASSERT_TRUE(setup->models.contains(truth.model_id)) << truth.model_id;
    EXPECT_GT(setup->models.at(truth.model_id).mesh.triangles.size(), 10U);
    // It stands on the table: turned about the vertical alone, and within the table's sides.
    EXPECT_NEAR(truth.T_world_object.linear()(2, 2), 1.0, 1e-9);
    EXPECT_NEAR(truth.T_world_object.translation().z(), 0.0, 1e-9);
    EXPECT_LT(truth.T_world_object.translation().norm(), 0.5 * setup->table->size.norm());
  }
}

class ReportSetupFiles : public ScratchTest {
 protected:
  fs::path Write(const std::string& name, const std::string& text) {
    const fs::path file = scratch() / name;
    std::ofstream(file) << text;
    return file;
  }
  Result<ReportSetup> Load(const std::string& text) {
    return LoadReportSetup(Write("setup.toml", text));
  }
  [[nodiscard]] static std::string Models(const std::string& use) {
    return "[models]\nfolder = \"" + (kSource / "models").string() + "\"\n" + use + "\n";
  }
  void ExpectRefused(const std::string& matrix, const std::string& part) {
    const Result<TruthObject> truth = ReadTruthMatrix(Write("truth.txt", matrix), "part");
    ASSERT_FALSE(truth.ok()) << matrix;
    EXPECT_NE(truth.error().message.find(part), std::string::npos) << truth.error().message;
    EXPECT_NE(truth.error().message.find("truth.txt"), std::string::npos) << truth.error().message;
  }
};

TEST_F(ReportSetupFiles, SimulatedObjectsAreTheTruth) {
  const Result<ReportSetup> setup = Load(Models("use = [\"gear\"]") + R"(
[ppf]
camera = "A"
[sim]
camera = "A"
[[sim.object]]
model = "mug"
position_m = [0.1, -0.2, 0.3]
rpy_deg = [0.0, 0.0, 90.0]
)");
  ASSERT_TRUE(setup.ok()) << setup.error().message;
  EXPECT_EQ(setup->camera, "A");
  // Models that only the truth names are there too, and no others.
  EXPECT_EQ(setup->models.size(), 2U);
  EXPECT_TRUE(setup->models.contains("gear"));
  EXPECT_TRUE(setup->models.contains("mug"));
  EXPECT_FALSE(setup->table.has_value());
  ASSERT_EQ(setup->truth.size(), 1U);
  Pose expected = Pose::Identity();
  expected.linear() << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  expected.translation() << 0.1, -0.2, 0.3;
  EXPECT_LT((setup->truth[0].T_world_object.matrix() - expected.matrix()).norm(), 1e-12);
}

TEST_F(ReportSetupFiles, WithoutSimulationNothingIsKnown) {
  const Result<ReportSetup> setup = Load(Models("") + "[ppf]\ncamera = \"A\"\n");
  ASSERT_TRUE(setup.ok()) << setup.error().message;
  EXPECT_TRUE(setup->truth.empty());
  EXPECT_FALSE(setup->table.has_value());
  size_t folders = 0;
  for (const auto& entry : fs::directory_iterator(kSource / "models")) {
    folders += entry.is_directory() ? 1 : 0;
  }
  EXPECT_EQ(setup->models.size(), folders);
}

TEST_F(ReportSetupFiles, BadSetupsAreRefused) {
  const auto refused = [&](const std::string& text, const std::string& part) {
    const Result<ReportSetup> setup = Load(text);
    ASSERT_FALSE(setup.ok()) << text;
    EXPECT_NE(setup.error().message.find(part), std::string::npos) << setup.error().message;
  };
  EXPECT_FALSE(LoadReportSetup(scratch() / "none.toml").ok());
  refused("[ppf", "setup.toml");
  refused(Models("use = [\"teapot\"]") + "[ppf]\ncamera = \"A\"\n", "teapot");
  refused(Models("") + "[ppf]\ncamera = \"A\"\nnonsense = 1\n", "nonsense");
  refused(Models("") + "[ppf]\ncamera = \"A\"\n[sim]\nnonsense = 1\n", "nonsense");
  refused(Models("use = [\"mug\"]") +
              "[ppf]\ncamera = \"A\"\n[sim]\n[[sim.object]]\nmodel = \"teapot\"\n"
              "position_m = [0.0, 0.0, 0.0]\n",
          "teapot");
}

TEST_F(ReportSetupFiles, TruthMatrixComesBack) {
  Rng rng(1);
  Pose pose = Pose::Identity();
  pose.linear() = rng.Rotation().toRotationMatrix();
  pose.translation() << 0.1, -2.0, 3.5;
  std::ostringstream text;
  text.precision(17);
  text << pose.matrix() << "\n";
  const Result<TruthObject> truth = ReadTruthMatrix(Write("truth.txt", text.str()), "part");
  ASSERT_TRUE(truth.ok()) << truth.error().message;
  EXPECT_EQ(truth->model_id, "part");
  EXPECT_LT((truth->T_world_object.matrix() - pose.matrix()).norm(), 1e-12);
}

TEST_F(ReportSetupFiles, NearlyARotationBecomesOne) {
  const Result<TruthObject> truth = ReadTruthMatrix(
      Write("truth.txt", "1.001 0 0 1\n0 0.999 0 2\n0 0 1.002 3\n0 0 0 1\n"), "part");
  ASSERT_TRUE(truth.ok()) << truth.error().message;
  EXPECT_LT((truth->T_world_object.linear() - Eigen::Matrix3d::Identity()).norm(), 1e-9);
  EXPECT_EQ(truth->T_world_object.translation(), Eigen::Vector3d(1, 2, 3));
}

TEST_F(ReportSetupFiles, BadTruthMatricesAreRefused) {
  const Result<TruthObject> absent = ReadTruthMatrix(scratch() / "none.txt", "part");
  ASSERT_FALSE(absent.ok());
  EXPECT_EQ(absent.error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(ReadTruthMatrix(scratch(), "part").ok()) << "a folder";
  ExpectRefused("", "0 numbers");
  ExpectRefused("1 0 0 0  0 1 0 0  0 0 1 0  0 0 0", "15 numbers");
  ExpectRefused("1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 1  5", "more than");
  ExpectRefused("1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 1  x", "more than");
  ExpectRefused("1 0 0 0  0 nan 0 0  0 0 1 0  0 0 0 1", "5 numbers");
  ExpectRefused("1 0 0 inf  0 1 0 0  0 0 1 0  0 0 0 1", "3 numbers");
  ExpectRefused("1 0 0 1e999  0 1 0 0  0 0 1 0  0 0 0 1", "3 numbers");
  ExpectRefused("1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1", "1 numbers");
  ExpectRefused("2 0 0 0  0 2 0 0  0 0 2 0  0 0 0 1", "rotation");
  ExpectRefused("1 0 0 0  0 1 0 0  0 0 -1 0  0 0 0 1", "rotation");
  ExpectRefused("1 0 0 0  0 1 0 0  0 0 1 0  0 0 0.5 1", "0 0 0 1");
  ExpectRefused("1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 2", "0 0 0 1");
}

}  // namespace
}  // namespace vantage
