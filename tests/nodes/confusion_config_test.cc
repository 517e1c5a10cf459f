#include "nodes/confusion_config.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "fusion/confusion/contingency_file.h"
#include "nodes/fusion_config.h"
#include "perception/model/file_bytes.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

const std::string kModels = VANTAGE_SOURCE_DIR "/models";

// A set-up with the mug, whose table is in its folder; `more` comes first.
Result<FusionConfig> ReadWith(const std::string& more) {
  Result<ConfigReader> reader = ConfigReader::Parse(
      more + "[models]\nfolder = \"" + kModels + "\"\nuse = [\"mug\", \"duck\"]\n",
      VANTAGE_SOURCE_DIR "/config/confusion_test.toml");
  if (!reader) return reader.error();
  return ReadFusionConfig(*reader);
}

class TableFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("vantage-confusion-" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  // Config lines that name a file as the mug's table.
  [[nodiscard]] std::string Named(const std::string& file) const {
    return "[confusion.tables]\nmug = \"" + (folder_ / file).string() + "\"\n";
  }
  [[nodiscard]] static ContingencyTable Bundled() {
    const Result<ContingencyTable> table =
        ReadContingencyTable(fs::path(kModels) / "mug" / ConfusionFileName("ppf"));
    EXPECT_TRUE(table.ok()) << table.error().message;
    return *table;
  }
  void Write(const ContingencyTable& table) const {
    ASSERT_TRUE(WriteContingencyTable(table, folder_ / "mug.bin").ok());
  }
  // Why the mug's table is refused.
  static std::string Refusal(const std::string& more) {
    const Result<FusionConfig> config = ReadWith(more);
    EXPECT_TRUE(config.ok()) << config.error().message;
    if (!config || !config->refused_tables.contains("mug")) return "not refused";
    EXPECT_EQ(config->models.at("mug").confusion, nullptr);
    return config->refused_tables.at("mug");
  }

  fs::path folder_;
};

TEST(ConfusionConfig, TheDemosModelsHaveTablesThatFit) {
  Result<ConfigReader> reader = ConfigReader::Open(VANTAGE_SOURCE_DIR "/config/demo.toml");
  ASSERT_TRUE(reader.ok());
  const Result<FusionConfig> config = ReadFusionConfig(*reader);
  ASSERT_TRUE(config.ok()) << config.error().message;
  EXPECT_EQ(config->criterion, "information_gain");
  EXPECT_EQ(config->views.candidates.count, 500);
  for (const auto& [id, why] : config->refused_tables) ADD_FAILURE() << id << ": " << why;
  for (const auto& [id, model] : config->models) EXPECT_NE(model.confusion, nullptr) << id;
}

TEST(ConfusionConfig, TablesCanBeLeftOut) {
  const Result<FusionConfig> with = ReadWith("");
  ASSERT_TRUE(with.ok()) << with.error().message;
  EXPECT_NE(with->models.at("mug").confusion, nullptr);
  EXPECT_EQ(with->models.at("duck").confusion, nullptr);  // It has none: no reason to complain.
  EXPECT_TRUE(with->refused_tables.empty());
  for (const char* text : {"[confusion]\nuse = false\n", "[confusion.tables]\nmug = \"none\"\n"}) {
    const Result<FusionConfig> without = ReadWith(text);
    ASSERT_TRUE(without.ok()) << without.error().message;
    EXPECT_EQ(without->models.at("mug").confusion, nullptr) << text;
    EXPECT_TRUE(without->refused_tables.empty()) << text;
  }
}

TEST_F(TableFile, OfAnotherEstimatorOrParametersIsRefused) {
  EXPECT_NE(Refusal("[ppf]\nturn_bins = 12\n").find("estimator"), std::string::npos);
  EXPECT_NE(Refusal("[verification]\nmin_score = 0.7\n").find("estimator"), std::string::npos);
  EXPECT_NE(Refusal("[sim]\n[[sim.object]]\nmodel = \"mug\"\n[sim.sensor]\nnoise = false\n")
                .find("sensor"),
            std::string::npos);
  EXPECT_EQ(Refusal("[sim]\n[[sim.object]]\nmodel = \"mug\"\n"), "not refused");
  ContingencyTable table = Bundled();
  table.key.estimator = "shot";
  Write(table);
  EXPECT_NE(Refusal(Named("mug.bin")).find("shot"), std::string::npos);
}

TEST_F(TableFile, OfAnotherModelIsRefused) {
  ContingencyTable table = Bundled();
  table.key.mesh_hash = "0123456789abcdef";
  Write(table);
  EXPECT_NE(Refusal(Named("mug.bin")).find("0123456789abcdef"), std::string::npos);
}

TEST_F(TableFile, ThatIsDamagedForeignOrAbsentIsRefused) {
  EXPECT_NE(Refusal(Named("absent.bin")).find("absent.bin"), std::string::npos);
  const std::string bytes = EncodeContingencyTable(Bundled());
  ASSERT_TRUE(WriteFileBytes(folder_ / "mug.bin", bytes.substr(0, bytes.size() / 2)).ok());
  EXPECT_NE(Refusal(Named("mug.bin")).find("mug.bin"), std::string::npos);
  ASSERT_TRUE(WriteFileBytes(folder_ / "mug.bin", "ply\nformat ascii 1.0\n").ok());
  EXPECT_NE(Refusal(Named("mug.bin")).find("mug.bin"), std::string::npos);
}

TEST(ConfusionConfig, WrongKeysAreNamed) {
  for (const auto& [text, word] : std::vector<std::pair<std::string, std::string>>{
           {"[confusion]\nestimator = \"icp\"\n", "confusion.estimator = 'icp'"},
           {"[confusion]\nmode_radius_deg = 0\n", "confusion.mode_radius_deg = 0"},
           {"[confusion]\noutlier_share = nan\n", "confusion.outlier_share = nan"},
           {"[confusion.tables]\nmug = \"\"\n", "expected a file or \"none\""},
           {"[confusion.tables]\nteapot = \"none\"\n", "\"teapot\", expected one of the models"},
           {"[planner]\ncriterion = \"best\"\n", "planner.criterion = 'best'"},
           {"[planner]\nviews = -1\n", "planner.views = -1"},
           {"[planner]\nsure = 1.0\n", "planner.sure = 1"},
           {"[planner]\narm_reach_m = [0.9, 0.2]\n", "expected 0 <= nearest < farthest"},
           {"[[planner.keep_out]]\nlowest_m = [0, 0, 0]\nhighest_m = [1, 1, 1]\n", "name"},
           {"[[planner.keep_out]]\nname = \"post\"\ncenter_m = [0, 0, 0]\n", "radius_m"},
           {"[[planner.keep_out]]\nname = \"rack\"\nlowest_m = [0, 0, 0]\nhighest_m = [1, 1, 0]\n",
            "keep-out box \"rack\""}}) {
    const Result<FusionConfig> config = ReadWith(text);
    ASSERT_FALSE(config.ok()) << text;
    EXPECT_NE(config.error().message.find(word), std::string::npos) << config.error().message;
  }
}

TEST(PlannerConfig, ReadsReachAndKeepOutVolumes) {
  const Result<FusionConfig> config = ReadWith(
      "[planner]\narm_base_m = [0.5, 0, 0]\narm_reach_m = [0.2, 0.9]\ntable_height_m = 0.1\n"
      "[[planner.keep_out]]\nname = \"rack\"\nlowest_m = [0, 0, 0]\nhighest_m = [1, 1, 1]\n"
      "[[planner.keep_out]]\nname = \"lamp\"\ncenter_m = [0, 0, 1]\nradius_m = 0.2\n");
  ASSERT_TRUE(config.ok()) << config.error().message;
  const ReachabilityParameters& reach = config->views.reach;
  EXPECT_EQ(reach.farthest, 0.9);
  ASSERT_EQ(reach.boxes.size(), 1U);
  ASSERT_EQ(reach.spheres.size(), 1U);
  EXPECT_EQ(reach.spheres[0].name, "lamp");
  EXPECT_EQ(config->views.occlusion.table_height, 0.1);
}

}  // namespace
}  // namespace vantage
