// Runs vantage-evaluate --dataset as its users do, on a made-up dataset.

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "perception/model/file_bytes.h"
#include "tests/tools/made_up_dataset.h"
#include "tests/tools/run_program.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class DatasetTool : public ToolTest {
 protected:
  DatasetTool() : ToolTest("vantage-evaluate") {}
};

TEST_F(DatasetTool, EvaluatesAFolderOfDatasets) {
  made_up::WriteTurntable(scratch() / "sets" / "box", scratch() / "sets" / "meshes");
  made_up::WriteText(scratch() / "sets" / "shelf" / "cam.info.txt", "");
  made_up::WriteText(scratch() / "sets" / "shelf" / "final_pose.txt", "");
  const ProgramOutput output = Run("--dataset sets --estimator ppf --output out");
  ASSERT_EQ(output.exit_code, 0) << output.text;
  EXPECT_NE(output.text.find("shelf has no exact ground truth"), std::string::npos) << output.text;
  EXPECT_NE(output.text.find("out/dataset/report.html"), std::string::npos) << output.text;
  const fs::path out = scratch() / "out" / "dataset";
  EXPECT_TRUE(fs::exists(out / "report.html"));
  const Json first = Json::parse(*ReadFileBytes(out / "results.json", 1U << 20U));
  ASSERT_EQ(first["outcomes"].size(), 1U);
  EXPECT_EQ(first["outcomes"][0]["dataset"], "box");
  // Again, to another place: the same but for times.
  ASSERT_EQ(Run("--dataset sets --estimator ppf --output out --name again").exit_code, 0);
  const Json second =
      Json::parse(*ReadFileBytes(scratch() / "out" / "again" / "results.json", 1U << 20U));
  for (const char* key : {"is_found", "T_camera_object", "score", "discrepancy"}) {
    EXPECT_EQ(first["outcomes"][0][key], second["outcomes"][0][key]) << key;
  }
}

TEST_F(DatasetTool, RefusesInOneSentence) {
  made_up::WriteText(scratch() / "shelf" / "cam.info.txt", "");
  made_up::WriteText(scratch() / "shelf" / "final_pose.txt", "");
  made_up::WriteTurntable(scratch() / "box", scratch() / "meshes");
  ExpectRefused("--dataset absent", "absent is no folder");
  ExpectRefused("--dataset meshes", "meshes is no dataset");
  ExpectRefused("--dataset shelf", "shelf has no exact ground truth");
  ExpectRefused("--dataset box --estimator sift", "estimator \"sift\"");
  ExpectRefused("--dataset box --meshes absent", "stanford_bunny.ply");
  ExpectRefused("--dataset box --paper", "");
}

}  // namespace
}  // namespace vantage
