#include "nodes/models_config.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "common/format.h"
#include "nodes/fusion_config.h"
#include "nodes/ppf_config.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

// The table of a text, or the sentence that says why not.
struct Outcome {
  ModelsConfig models;
  std::string error;
};

Outcome Read(const std::string& text) {
  Result<ConfigReader> config = ConfigReader::Parse(text, "/somewhere/x.toml");
  if (!config) return {{}, config.error().message};
  const ModelsConfig models = ReadModelsConfig(*config);
  const Result<void> finished = config->Finish();
  return {models, finished ? "" : finished.error().message};
}

TEST(ModelsConfig, ReadsFolderAndNames) {
  const Outcome read = Read("[models]\nfolder = '../models'\nuse = ['mug', 'filter']\n");
  EXPECT_EQ(read.error, "");
  EXPECT_EQ(read.models.folder.filename(), "models");
  EXPECT_EQ(read.models.use, (Names{"mug", "filter"}));
}

TEST(ModelsConfig, WhatCantBeIsRefused) {
  const std::string folder = "[models]\nfolder = 'models'\n";
  for (const auto& [text, expected] : std::vector<std::pair<std::string, std::string>>{
           {"", "models.folder: missing"},
           {folder + "use = []\n", "expected at least one model, or no such key"},
           {folder + "use = ['../mug']\n", "model id \"../mug\", expected"},
           {folder + "use = ['a/b']\n", "model id \"a/b\", expected"},
           {folder + "use = ['']\n", "model id \"\", expected"},
           {folder + "use = ['mug', 'cup', 'mug']\n", "\"mug\" is there twice"},
           {folder + "used = ['mug']\n", "models.used"}}) {
    EXPECT_NE(Read(text).error.find(expected), std::string::npos)
        << text << " gave: " << Read(text).error;
  }
}

class FindModelsTest : public testing::Test {
 protected:
  FindModelsTest() {
    for (const char* name : {"mug", "bracket", "no_model"}) fs::create_directories(folder_ / name);
    std::ofstream(folder_ / "mug" / "model.toml") << "x";
    std::ofstream(folder_ / "bracket" / "model.toml") << "x";
    std::ofstream(folder_ / "file") << "x";
  }
  ~FindModelsTest() override { fs::remove_all(folder_); }

  std::string Error(const ModelsConfig& models) const {
    const Result<Names> names = FindModels(models);
    return names ? "" : names.error().message;
  }

  fs::path folder_ = fs::path(testing::TempDir()) / Format("models_config_test.%d", getpid());
};

TEST_F(FindModelsTest, AreThoseListedOrAll) {
  EXPECT_EQ(*FindModels({folder_, {"mug", "bracket"}}), (Names{"mug", "bracket"}));
  EXPECT_EQ(*FindModels({folder_, {}}), (Names{"bracket", "mug"}));
}

TEST_F(FindModelsTest, WhatIsNotThereIsNamed) {
  EXPECT_NE(Error({folder_, {"teapot"}}).find("\"teapot\", which is not in"), std::string::npos);
  EXPECT_NE(Error({folder_, {"teapot"}}).find("there are: bracket, mug"), std::string::npos);
  EXPECT_NE(Error({folder_ / "none", {}}).find("can't be read"), std::string::npos);
  EXPECT_NE(Error({folder_ / "no_model", {}}).find("holds no model"), std::string::npos);
}

// One table, one meaning: without `use` the estimator looks for all models and fusion knows them.
TEST(ModelsTable, MeansTheSameToEstimatorAndFusion) {
  const std::string models = std::string("[models]\nfolder = '") + VANTAGE_SOURCE_DIR "/models'\n";
  Result<ConfigReader> for_ppf = ConfigReader::Parse("[ppf]\ncamera = 'A'\n" + models, "x.toml");
  Result<ConfigReader> for_fusion = ConfigReader::Parse(models, "x.toml");
  ASSERT_TRUE(for_ppf.ok() && for_fusion.ok());
  const Result<PpfConfig> ppf = ReadPpfConfig(*for_ppf);
  const Result<FusionConfig> fusion = ReadFusionConfig(*for_fusion);
  ASSERT_TRUE(ppf.ok()) << ppf.error().message;
  ASSERT_TRUE(fusion.ok()) << fusion.error().message;
  const Result<Names> names = FindModels(ppf->models);
  ASSERT_TRUE(names.ok()) << names.error().message;
  ASSERT_GE(names->size(), 8U);
  Names fused;
  for (const auto& [name, model] : fusion->models) fused.push_back(name);
  EXPECT_EQ(fused, *names);
}

}  // namespace
}  // namespace vantage
