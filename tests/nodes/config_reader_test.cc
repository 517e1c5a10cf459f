#include "nodes/config_reader.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

namespace vantage {
namespace {

ConfigReader Parse(const std::string& text) {
  Result<ConfigReader> reader = ConfigReader::Parse(text, "test.toml");
  EXPECT_TRUE(reader.ok());
  return *reader;
}

std::string FinishError(ConfigReader& reader) {
  const Result<void> finished = reader.Finish();
  return finished ? "" : finished.error().message;
}

TEST(ConfigReader, ReadsEveryKindOfValueAndKeepsDefaults) {
  ConfigReader reader = Parse(
      "[a]\nnumber = 2.5\nwhole = 3\nbig = 5000000000\nflag = true\ntext = 'x'\nlist = ['p', 'q']\n"
      "numbers = [1, 2.5]\n");
  ConfigReader::Table a = reader.Root().Sub("a");
  double number = 0.0;
  double absent = 7.0;
  int whole = 0;
  int64_t big = 0;
  bool flag = false;
  std::string text;
  std::vector<std::string> list;
  std::vector<double> numbers;
  a.Read("number", &number, 0.0, 10.0);
  a.Read("absent", &absent, 0.0, 10.0);
  a.Read("whole", &whole, 0, 10);
  a.Read("big", &big, int64_t{0}, int64_t{6000000000});
  a.Read("flag", &flag);
  a.Read("text", &text);
  a.Read("list", &list);
  a.ReadNumbers("numbers", 2, 0.0, 3.0, &numbers);
  EXPECT_EQ(FinishError(reader), "");
  EXPECT_EQ(number, 2.5);
  EXPECT_EQ(absent, 7.0);
  EXPECT_EQ(whole, 3);
  EXPECT_EQ(big, 5000000000);
  EXPECT_TRUE(flag);
  EXPECT_EQ(text, "x");
  EXPECT_EQ(list, (std::vector<std::string>{"p", "q"}));
  EXPECT_EQ(numbers, (std::vector<double>{1.0, 2.5}));
}

TEST(ConfigReader, UnknownKeyNamesFileLineAndKnownKeys) {
  ConfigReader reader = Parse("[fusion]\nsigma_deg = 4\nsigma_dge = 5\n");
  double sigma = 0.0;
  reader.Root().Sub("fusion").Read("sigma_deg", &sigma, 0.0, 90.0);
  EXPECT_EQ(FinishError(reader),
            "test.toml:3: fusion.sigma_dge = 5: unknown key; known here: sigma_deg; "
            "did you mean sigma_deg?");
}

TEST(ConfigReader, TellsTheNearestKeyWhereOneIsNear) {
  const auto hint = [](const std::string& key) {
    ConfigReader reader = Parse("[fusion]\n" + key + " = 5\n");
    ConfigReader::Table fusion = reader.Root().Sub("fusion");
    double value = 0.0;
    for (const char* known : {"gate_m", "sigma_deg", "motion_sigma_deg", "k"}) {
      fusion.Read(known, &value, 0.0, 90.0);
    }
    const std::string error = FinishError(reader);
    const size_t at = error.find("; did you mean ");
    return at == std::string::npos ? "" : error.substr(at + 15);
  };
  EXPECT_EQ(hint("sigma_dge"), "sigma_deg?");
  EXPECT_EQ(hint("sgma_deg"), "sigma_deg?");
  EXPECT_EQ(hint("gate_mm"), "gate_m?");
  EXPECT_EQ(hint("motion_sigma"), "motion_sigma_deg?");
  EXPECT_EQ(hint("temperature"), "");
  EXPECT_EQ(hint("z"), "");
  EXPECT_EQ(hint(std::string(5000, 'a')), "");
}

TEST(ConfigReader, UnknownTableIsAnError) {
  ConfigReader reader = Parse("[fuson]\nsigma_deg = 4\n");
  reader.Root().Sub("fusion");
  EXPECT_NE(FinishError(reader).find("fuson: unknown key"), std::string::npos);
}

TEST(ConfigReader, OutOfRangeNamesValueAndBounds) {
  ConfigReader reader = Parse("[fusion]\nk = 500\n");
  int k = 32;
  reader.Root().Sub("fusion").Read("k", &k, 2, 128);
  EXPECT_EQ(k, 32);
  EXPECT_EQ(FinishError(reader),
            "test.toml:2: fusion.k = 500: expected a number from 2 to 128, whole");
}

TEST(ConfigReader, WrongKindsAreErrors) {
  for (const char* text : {"x = 'a'", "x = [1]", "x = nan", "x = inf", "x = true", "[x]"}) {
    ConfigReader reader = Parse(text);
    double value = 1.0;
    reader.Root().Read("x", &value, -1e300, 1e300);
    EXPECT_NE(FinishError(reader), "") << text;
    EXPECT_EQ(value, 1.0);
  }
  ConfigReader reader = Parse("x = 2.5");
  int whole = 0;
  reader.Root().Read("x", &whole, 0, 10);
  EXPECT_NE(FinishError(reader), "");
}

TEST(ConfigReader, ChoiceListsWhatIsAllowed) {
  ConfigReader reader = Parse("compression = 'lzma'\n");
  std::string compression = "zlib";
  reader.Root().ReadChoice("compression", &compression, {"zlib", "none"});
  EXPECT_NE(FinishError(reader).find("expected one of \"zlib\" \"none\""), std::string::npos);
}

TEST(ConfigReader, PoseFromEulerAngles) {
  ConfigReader reader = Parse("position_m = [1, 2, 3]\nrpy_deg = [0, 0, 90]\n");
  Pose pose = Pose::Identity();
  reader.Root().ReadPose(&pose);
  EXPECT_EQ(FinishError(reader), "");
  EXPECT_LT((pose * Eigen::Vector3d::UnitX() - Eigen::Vector3d(1, 3, 3)).norm(), 1e-12);
}

TEST(ConfigReader, PoseRefusesAQuaternionWithoutUnitNorm) {
  ConfigReader reader = Parse("quaternion_wxyz = [1, 1, 0, 0]\n");
  Pose pose = Pose::Identity();
  reader.Root().ReadPose(&pose);
  EXPECT_NE(FinishError(reader).find("norm"), std::string::npos);
}

TEST(ConfigReader, ArraysOfTablesAreStrictToo) {
  ConfigReader reader = Parse("[[object]]\nmodel = 'a'\n[[object]]\nmodle = 'b'\n");
  for (ConfigReader::Table& table : reader.Root().SubTables("object")) {
    std::string model;
    table.Read("model", &model);
  }
  EXPECT_NE(FinishError(reader).find("object[1].modle"), std::string::npos);
}

TEST(ConfigReader, RequiredKeyMissing) {
  ConfigReader reader = Parse("[models]\n");
  reader.Root().Sub("models").Require("folder");
  EXPECT_NE(FinishError(reader).find("models.folder: missing"), std::string::npos);
}

TEST(ConfigReader, EffectiveIsTheFilesValueOrTheDefault) {
  ConfigReader reader = Parse("[a]\nk = 3\nuse = ['p']\n[[a.object]]\n[[a.object]]\nx = 2.5\n");
  ConfigReader::Table a = reader.Root().Sub("a");
  int k = 64;
  double sigma = 4.0;
  bool color = false;
  std::string name = "XTION";
  std::vector<std::string> use;
  std::vector<double> target = {0.0, 0.5};
  a.Read("k", &k, 0, 10);
  a.Read("sigma", &sigma, 0.0, 10.0);
  a.Read("color", &color);
  a.Read("name", &name);
  a.Read("use", &use);
  a.ReadNumbers("target", 2, 0.0, 1.0, &target);
  std::optional<double> height;
  a.Read("height", &height, 0.0, 1.0);
  EXPECT_FALSE(height.has_value());
  for (ConfigReader::Table& table : a.SubTables("object")) {
    double x = 1.0;
    table.Read("x", &x, 0.0, 10.0);
  }
  EXPECT_EQ(reader.Effective(),
            "a.color = false\na.height = none\na.k = 3\na.name = 'XTION'\na.object[0].x = 1\n"
            "a.object[1].x = 2.5\na.sigma = 4\na.target = [0, 0.5]\na.use = ['p']\n");
}

TEST(ConfigReader, AMisspeltTableIsToldBeforeWhatIsMissingForIt) {
  ConfigReader reader = Parse("[modles]\nfolder = 'x'\n");
  reader.Root().Sub("models").Require("folder");
  EXPECT_EQ(FinishError(reader),
            "test.toml:1: modles: unknown key; known here: models; did you mean models?");
}

TEST(ConfigReader, ValuesAreToldAsTheyWereWritten) {
  ConfigReader reader = Parse("share = 0.95\n");
  double share = 0.0;
  reader.Root().Read("share", &share, 0.0, 0.1);
  EXPECT_EQ(FinishError(reader), "test.toml:1: share = 0.95: expected a number from 0 to 0.1");
}

TEST(ConfigReader, AFolderIsNoFile) {
  const Result<ConfigReader> reader = ConfigReader::Open(testing::TempDir());
  ASSERT_FALSE(reader.ok());
  EXPECT_NE(reader.error().message.find(" is no file; expected"), std::string::npos);
}

TEST(ConfigReader, BrokenTomlNamesLineAndColumn) {
  const Result<ConfigReader> reader = ConfigReader::Parse("a = \n", "broken.toml");
  ASSERT_FALSE(reader.ok());
  EXPECT_EQ(reader.error().message.rfind("broken.toml:1:", 0), 0U) << reader.error().message;
}

TEST(ConfigReader, AbsentFileIsNamed) {
  const Result<ConfigReader> reader = ConfigReader::Open("no/such.toml");
  ASSERT_FALSE(reader.ok());
  EXPECT_EQ(reader.error().code, ErrorCode::kNotFound);
  EXPECT_NE(reader.error().message.find("no/such.toml"), std::string::npos);
}

TEST(ConfigReader, PathsStartAtTheFilesFolder) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / "vantage_config_test";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "x.toml") << "folder = '../models'\n";
  Result<ConfigReader> reader = ConfigReader::Open(folder / "x.toml");
  ASSERT_TRUE(reader.ok());
  std::filesystem::path path;
  reader->Root().ReadPath("folder", &path);
  EXPECT_EQ(path, std::filesystem::temp_directory_path() / "models");
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace vantage
