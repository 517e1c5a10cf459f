#include "nodes/fusion_config.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "common/so3.h"
#include "nodes/config_reader.h"
#include "tests/bus/support/temporary_folder.h"

namespace vantage {
namespace {

Result<FusionConfig> ReadText(const std::string& text) {
  Result<ConfigReader> reader =
      ConfigReader::Parse(text, VANTAGE_SOURCE_DIR "/config/fusion_node_test.toml");
  if (!reader) return reader.error();
  return ReadFusionConfig(*reader);
}

TEST(FusionConfig, ReadsTheDemosTables) {
  Result<ConfigReader> reader = ConfigReader::Open(VANTAGE_SOURCE_DIR "/config/demo.toml");
  ASSERT_TRUE(reader.ok());
  const Result<FusionConfig> config = ReadFusionConfig(*reader);
  ASSERT_TRUE(config.ok()) << config.error().message;
  EXPECT_EQ(config->models.size(), 3U);
  EXPECT_NEAR(config->views.candidates.radius, 0.75, 1e-12);
  EXPECT_GT(config->models.at("mug").diameter, 0.02);
}

TEST(FusionConfig, WrongKeysAreNamed) {
  const std::string folder = "[models]\nfolder = \"" VANTAGE_SOURCE_DIR "/models\"\n";
  const std::string models = folder + "use = [\"mug\"]\n";
  for (const auto& [text, word] : std::vector<std::pair<std::string, std::string>>{
           {"[fusion]\nsigma = 4.0\n" + models, "fusion.sigma = 4"},
           {"[fusion]\nk = 500\n" + models, "fusion.k = 500"},
           {"[planner]\nradius_m = -1.0\n" + models, "planner.radius_m = -1"},
           {"[fusion]\n", "models.folder: missing"},
           {"[fusion]\nfinal_orientation = \"mean\"\n" + models,
            "fusion.final_orientation = 'mean': expected one of \"voting\" \"vw_voting\" "
            "\"cw_clustering\" \"cw_vw_clustering\" \"density_mode\""},
           {"[fusion]\nmotion_sigma_deg = -1\n" + models, "fusion.motion_sigma_deg = -1"},
           {"[fusion]\nmode_bandwidth = nan\n" + models, "fusion.mode_bandwidth = nan"},
           {"[fusion]\nprior_uniform_share = 1.1\n" + models, "fusion.prior_uniform_share = 1.1"},
           {"[fusion]\nlikely_pose = 3\n" + models, "expected tables [[fusion.likely_pose]]"},
           {folder + "use = []\n", "models.use: expected at least one model"},
           {folder + "use = [\"teapot\"]\n", "use names \"teapot\", which is not in"}}) {
    const Result<FusionConfig> config = ReadText(text);
    ASSERT_FALSE(config.ok()) << text;
    EXPECT_NE(config.error().message.find(word), std::string::npos) << config.error().message;
  }
}

// One table [[fusion.likely_pose]]; `more` may repeat none of its keys.
std::string LikelyPoseText(const std::string& model,
                           const std::string& q,
                           const std::string& spread_deg,
                           const std::string& more = "") {
  return "[[fusion.likely_pose]]\nmodel = \"" + model + "\"\nq_world_object = " + q +
         "\nspread_deg = " + spread_deg + "\n" + more;
}

std::string ModelsText() {
  return "[models]\nfolder = \"" VANTAGE_SOURCE_DIR "/models\"\nuse = [\"mug\", \"filter\"]\n";
}

TEST(FusionConfig, ReadsHowOrientationsAreFused) {
  const Result<FusionConfig> config = ReadText(
      "[fusion]\nsigma_deg = 3.0\nfinal_orientation = \"vw_voting\"\nmotion_sigma_deg = 0.5\n"
      "mode_bandwidth = 2.0\nprior_uniform_share = 0.4\n" +
      LikelyPoseText("mug", "[1, 0, 0, 0]", "10") +
      LikelyPoseText("filter", "[0.6, 0.8, 0, 0]", "5.0", "weight = 3\n") +
      LikelyPoseText("mug", "[0, 0, 1, 0]", "2.0", "weight = 0\n") + ModelsText());
  ASSERT_TRUE(config.ok()) << config.error().message;
  const OrientationFilterParameters& orientation = config->tracker.orientation;
  EXPECT_EQ(orientation.final_orientation, FinalOrientation::kVwVoting);
  EXPECT_NEAR(orientation.sigma_motion, 0.5 * kDegree, 1e-12);
  EXPECT_NEAR(orientation.mode.sigma, 3.0 * kDegree, 1e-12);
  EXPECT_EQ(orientation.mode.bandwidth, 2.0);
  EXPECT_EQ(config->tracker.prior_uniform_share, 0.4);
  const std::vector<LikelyPose>& mug = config->models.at("mug").likely_poses;
  const std::vector<LikelyPose>& filter = config->models.at("filter").likely_poses;
  ASSERT_EQ(mug.size(), 2U);
  ASSERT_EQ(filter.size(), 1U);
  EXPECT_NEAR(mug[0].spread, 10.0 * kDegree, 1e-12);
  EXPECT_EQ(mug[0].weight, 1.0);
  EXPECT_EQ(mug[1].weight, 0.0);
  EXPECT_EQ(filter[0].weight, 3.0);
  EXPECT_NEAR(filter[0].q_world_object.x(), 0.8, 1e-12);
  EXPECT_NEAR(filter[0].q_world_object.w(), 0.6, 1e-12);
}

TEST(FusionConfig, TheModelsSymmetriesAreTaken) {
  const Result<FusionConfig> config =
      ReadText("[models]\nfolder = \"" VANTAGE_SOURCE_DIR "/models\"\n");
  ASSERT_TRUE(config.ok()) << config.error().message;
  EXPECT_EQ(config->models.at("mug").symmetry.elements.size(), 1U);
  EXPECT_EQ(config->models.at("carton").symmetry.elements.size(), 4U);
  EXPECT_EQ(config->models.at("bottle").symmetry.kind, SymmetryGroup::Kind::kContinuous);
}

TEST(FusionConfig, WrongLikelyPosesAreNamed) {
  const std::string good = LikelyPoseText("mug", "[1, 0, 0, 0]", "10");
  std::string many;
  for (int i = 0; i < 21; ++i) many += good;
  for (const auto& [text, word] : std::vector<std::pair<std::string, std::string>>{
           {good + LikelyPoseText("teapot", "[1, 0, 0, 0]", "10"),
            ":6: fusion.likely_pose[1].model = 'teapot': expected one of the models in use: "
            "filter, mug"},
           {LikelyPoseText("bracket", "[1, 0, 0, 0]", "10"), "model = 'bracket': expected one of"},
           {LikelyPoseText("mug", "[0, 0, 0, 0]", "10"), "q_world_object: quaternion"},
           {LikelyPoseText("mug", "[1, 0.5, 0, 0]", "10"), "norm"},
           {LikelyPoseText("mug", "[1, 0, 0]", "10"), "expected a list of 4 numbers from -1 to 1"},
           {LikelyPoseText("mug", "[1, 0, 0, nan]", "10"), "expected a list of 4 numbers"},
           {LikelyPoseText("mug", "[1, 0, 0, 0]", "0"), "spread_deg = 0: expected a number from"},
           {LikelyPoseText("mug", "[1, 0, 0, 0]", "31"), "spread_deg = 31: expected a number from"},
           {LikelyPoseText("mug", "[1, 0, 0, 0]", "9", "weight = -1\n"), "weight = -1: expected"},
           {LikelyPoseText("mug", "[1, 0, 0, 0]", "9", "weight = inf\n"), "weight = inf: expected"},
           {LikelyPoseText("mug", "[1, 0, 0, 0]", "9", "wieght = 1\n"), "wieght = 1: unknown key"},
           {"[[fusion.likely_pose]]\nmodel = \"mug\"\nspread_deg = 3\n",
            "likely_pose[0].q_world_object: missing"},
           {LikelyPoseText("filter", "[1, 0, 0, 0]", "9") +
                LikelyPoseText("mug", "[1, 0, 0, 0]", "9", "weight = 0\n"),
            "likely_pose[1].weight = 0: expected more than 0 for at least one likely pose of "
            "\"mug\""},
           {many, "likely_pose[20].model = 'mug': expected at most 20 likely poses"}}) {
    const Result<FusionConfig> config = ReadText(text + ModelsText());
    ASSERT_FALSE(config.ok()) << text;
    EXPECT_NE(config.error().message.find(word), std::string::npos) << config.error().message;
  }
}

// What a saved state belongs to: models and what is known of them, not how views are fused.
TEST(FusionConfig, ASetUpIsAnotherOnceItsKnowledgeIs) {
  const auto setup = [](const std::string& text) { return ReadText(text + ModelsText())->setup; };
  const std::string none = setup("");
  const std::string mug = LikelyPoseText("mug", "[1, 0, 0, 0]", "10");
  EXPECT_EQ(setup("[fusion]\nsigma_deg = 5\nfinal_orientation = \"voting\"\n"), none);
  EXPECT_EQ(setup("[fusion]\nprior_uniform_share = 0.5\n"), none);  // There is no prior.
  std::set<std::string> setups = {none};
  for (const std::string& text : {mug,
                                  "[fusion]\nprior_uniform_share = 0.5\n" + mug,
                                  mug + mug,
                                  LikelyPoseText("filter", "[1, 0, 0, 0]", "10"),
                                  LikelyPoseText("mug", "[0, 1, 0, 0]", "10"),
                                  LikelyPoseText("mug", "[1, 0, 0, 0]", "11"),
                                  mug + "weight = 2\n"}) {
    EXPECT_TRUE(setups.insert(setup(text)).second) << text;
  }
}

// What only several keys together make wrong is told of the table and the values.
TEST(FusionConfig, WhatDoesNotGoTogetherIsToldAsItIs) {
  const std::string models =
      "[models]\nfolder = \"" VANTAGE_SOURCE_DIR "/models\"\nuse = [\"mug\"]\n";
  for (const auto& [text, start] : std::vector<std::pair<std::string, std::string>>{
           {"[fusion]\nw_min = 0.95\n" + models, "[fusion] w_min = 0.95 and w_max = 0.9"},
           {"[planner]\nelevation_deg = [70.0, 30.0]\n" + models,
            "[planner] elevations from 70 to 30 degrees"}}) {
    const Result<FusionConfig> config = ReadText(text);
    ASSERT_FALSE(config.ok()) << text;
    EXPECT_TRUE(config.error().message.starts_with(start)) << config.error().message;
  }
}

TEST(FusionConfig, ReadsWhatThePlannerMayDo) {
  const std::string models =
      "[models]\nfolder = \"" VANTAGE_SOURCE_DIR "/models\"\nuse = [\"mug\"]\n";
  const Result<FusionConfig> defaults = ReadText(models);
  ASSERT_TRUE(defaults.ok()) << defaults.error().message;
  EXPECT_EQ(defaults->criterion, "information_gain");
  EXPECT_EQ(defaults->views.candidates.count, 500);
  EXPECT_FALSE(defaults->views.occlusion.table_height.has_value());
  EXPECT_TRUE(defaults->views.reach.boxes.empty());
  // A ball about the center that is no larger than one about a corner of the mesh.
  const PlannedShape& mug = defaults->shapes.at("mug");
  EXPECT_FALSE(mug.mesh.triangles.empty());
  EXPECT_GE(mug.radius, 0.5 * defaults->models.at("mug").diameter - 1e-9);
  EXPECT_LE(mug.radius, defaults->models.at("mug").diameter);

  const Result<FusionConfig> config =
      ReadText(models +
               "[planner]\ncriterion = \"confusion_heuristic\"\ntable_height_m = -0.25\n"
               "arm_reach_m = [0.2, 0.9]\n"
               "[[planner.keep_out]]\nname = \"wall\"\nlowest_m = [0, 0, 0]\n"
               "highest_m = [1, 2, 3]\n"
               "[[planner.keep_out]]\nname = \"lamp\"\ncenter_m = [4, 5, 6]\nradius_m = 0.5\n");
  ASSERT_TRUE(config.ok()) << config.error().message;
  EXPECT_EQ(config->criterion, "confusion_heuristic");
  EXPECT_EQ(config->views.occlusion.table_height, -0.25);
  const ReachabilityParameters& reach = config->views.reach;
  EXPECT_EQ(reach.nearest, 0.2);
  EXPECT_EQ(reach.farthest, 0.9);
  ASSERT_EQ(reach.boxes.size(), 1U);
  EXPECT_EQ(reach.boxes[0].name, "wall");
  EXPECT_EQ(reach.boxes[0].highest, Eigen::Vector3d(1.0, 2.0, 3.0));
  ASSERT_EQ(reach.spheres.size(), 1U);
  EXPECT_EQ(reach.spheres[0].center, Eigen::Vector3d(4.0, 5.0, 6.0));
  EXPECT_EQ(reach.spheres[0].radius, 0.5);
}

TEST(FusionConfig, WrongKeepOutsAreNamed) {
  const std::string start = "[models]\nfolder = \"" VANTAGE_SOURCE_DIR
                            "/models\"\nuse = [\"mug\"]\n[[planner.keep_out]]\n";
  for (const auto& [text, word] : std::vector<std::pair<std::string, std::string>>{
           {"", "name: missing"},
           {"name = \"a\"\n", "lowest_m: missing"},
           {"name = \"a\"\nlowest_m = [0, 0, 0]\n", "highest_m: missing"},
           {"name = \"a\"\ncenter_m = [0, 0, 0]\n", "radius_m: missing"},
           {"name = \"a\"\nradius_m = 1\n", "center_m: missing"},
           {"name = \"a\"\ncenter_m = [0, 0, 0]\nradius_m = 0\n", "radius_m = 0: expected"},
           {"name = \"a\"\ncenter_m = [0, 0, 0]\nradius_m = 1\nlowest_m = [0, 0, 0]\n",
            "not some of both"},
           {"name = \"a\"\nlowest_m = [0, 0, 0]\nhighest_m = [1, 1, -1]\n",
            "the lowest corner below the highest"},
           {"name = \"a\"\ncentre_m = [0, 0, 0]\n", "unknown key; known here: center_m, high"}}) {
    const Result<FusionConfig> config = ReadText(start + text);
    ASSERT_FALSE(config.ok()) << text;
    EXPECT_NE(config.error().message.find(word), std::string::npos) << config.error().message;
  }
}

// The robot can go on without a table, so one that is of no use is told, not an error.
TEST(FusionConfig, TablesOfNoUseAreToldAndLeftOut) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "foreign.bin") << "not a table at all";
  const std::string models =
      "[models]\nfolder = \"" VANTAGE_SOURCE_DIR "/models\"\nuse = [\"mug\"]\n";
  for (const auto& [file, word] : std::vector<std::pair<std::string, std::string>>{
           {"foreign.bin", "foreign.bin"}, {"absent.bin", "absent.bin"}, {"none", ""}}) {
    std::string path = file;
    if (file != "none") path = (folder.path() / file).string();
    const Result<FusionConfig> config =
        ReadText(models + "[confusion.tables]\nmug = \"" + path + "\"\n");
    ASSERT_TRUE(config.ok()) << config.error().message;
    EXPECT_EQ(config->models.at("mug").confusion, nullptr);
    ASSERT_EQ(config->refused_tables.contains("mug"), !word.empty()) << file;
    if (word.empty()) continue;
    EXPECT_NE(config->refused_tables.at("mug").find(word), std::string::npos)
        << config->refused_tables.at("mug");
  }
  const Result<FusionConfig> off =
      ReadText(models + "[confusion]\nuse = false\n[confusion.tables]\nmug = \"absent.bin\"\n");
  ASSERT_TRUE(off.ok()) << off.error().message;
  EXPECT_EQ(off->models.at("mug").confusion, nullptr);
  EXPECT_TRUE(off->refused_tables.empty());
  for (const auto& [text, word] : std::vector<std::pair<std::string, std::string>>{
           {"mug = \"\"\n", "expected a file or \"none\""},
           {"teapot = \"none\"\n", "\"teapot\", expected one of the models in use: mug"}}) {
    const Result<FusionConfig> config = ReadText(models + "[confusion.tables]\n" + text);
    ASSERT_FALSE(config.ok()) << text;
    EXPECT_NE(config.error().message.find(word), std::string::npos) << config.error().message;
  }
}

}  // namespace
}  // namespace vantage
