#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/tools/run_program.h"
#include "tools/supervise/process_plan.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCameras =
    "[camera.LEFT]\ndevice = \"index:0\"\n[camera.RIGHT]\ndevice = \"index:1\"\n"
    "[camera.WEB]\ndriver = \"v4l2\"\ndevice = \"path:/dev/video0\"\n";

class ProcessPlanTest : public ScratchTest {
 protected:
  void SetUp() override {
    ScratchTest::SetUp();
    fs::create_directory(scratch() / "bin");
    for (const char* name :
         {"log", "sim-arm", "openni2", "v4l2", "extrinsics", "ppf", "shot", "fusion"}) {
      MakeProgram(scratch() / "bin" / (std::string("vantage-") + name));
    }
  }

  static void MakeProgram(const fs::path& file) {
    std::ofstream(file) << "#!/bin/sh\n";
    fs::permissions(file, fs::perms::owner_all);
  }

  Result<ProcessPlan> Plan(const std::string& text) const {
    const std::string models =
        std::string("[models]\nfolder = \"") + VANTAGE_SOURCE_DIR + "/models\"\n";
    const fs::path file = scratch() / "set up.toml";
    std::ofstream(file) << models << text;
    return MakeProcessPlan(file, scratch() / "bin");
  }

  // Names in the order of starting, or the error.
  std::string Names(const std::string& text) const {
    const Result<ProcessPlan> plan = Plan(text);
    if (!plan) return plan.error().message;
    std::string names;
    for (const PlannedProcess& process : plan->processes) names += process.name + " ";
    return names;
  }

  void ExpectRefused(const std::string& text, const std::string& part) const {
    const std::string error = Names(text);
    EXPECT_NE(error.find(part), std::string::npos) << error;
  }

  // The only process of a plan.
  PlannedProcess Only(const std::string& text) const {
    const Result<ProcessPlan> plan = Plan(text);
    EXPECT_TRUE(plan.ok()) << plan.error().message;
    EXPECT_EQ(plan->processes.size(), 1U);
    return plan->processes.front();
  }
};

TEST_F(ProcessPlanTest, TablesImplyProcessesInTheOrderOfStarting) {
  EXPECT_EQ(Names("[ppf]\ncamera = \"X\"\n"), "ppf ");
  EXPECT_EQ(Names(std::string(kCameras) + "[up]\nrecord = \"r\"\n[sim]\n[fusion]\n[shot]\n"
                                          "camera = \"LEFT\"\n[ppf]\ncamera = \"LEFT\"\n"),
            "recorder sim-arm openni2-left openni2-right v4l2 ppf shot fusion ");
}

TEST_F(ProcessPlanTest, ProcessesOfCamerasHaveNamesByWhichTheyFindThem) {
  const Result<ProcessPlan> plan = Plan(kCameras);
  ASSERT_TRUE(plan.ok()) << plan.error().message;
  const std::string config = (scratch() / "set up.toml").string();
  const std::string bin = (scratch() / "bin").string();
  EXPECT_EQ(plan->processes[0].command,
            (std::vector<std::string>{
                bin + "/vantage-openni2", "--name", "openni2-left", "--config", config}));
  EXPECT_EQ(plan->processes[2].command,
            (std::vector<std::string>{bin + "/vantage-v4l2", "--config", config}));
}

TEST_F(ProcessPlanTest, TheSimulatedCameraAloneHasItsDevice) {
  const Result<ProcessPlan> plan = Plan(std::string(kCameras) + "[sim]\ncamera = \"RIGHT\"\n");
  ASSERT_TRUE(plan.ok()) << plan.error().message;
  for (const PlannedProcess& process : plan->processes) {
    EXPECT_EQ(process.environment.size(), process.name == "openni2-right" ? 2U : 0U)
        << process.name;
  }
}

TEST_F(ProcessPlanTest, WishesAreFollowed) {
  const std::string ppf = "[ppf]\ncamera = \"X\"\n[fusion]\n[[up.process]]\nname = \"fusion\"\n";
  EXPECT_EQ(Names(ppf + "start = false\n"), "ppf ");
  EXPECT_EQ(Names(ppf + "[[up.process]]\nname = \"gone\"\nstart = false\n"), "ppf fusion ");
  EXPECT_EQ(Names(ppf + "[[up.process]]\nname = \"robot\"\ncommand = [\"sh\"]\n"),
            "robot ppf fusion ");
  const PlannedProcess own =
      Only("[fusion]\n[[up.process]]\nname = \"fusion\"\narguments = [\"--fresh\"]\nnice = 3\n");
  EXPECT_EQ(own.command.back(), "--fresh");
  EXPECT_EQ(own.command.size(), 4U);
  EXPECT_EQ(own.nice, 3);
  MakeProgram(scratch() / "mine");
  const PlannedProcess replaced = Only(
      "[sim]\n[[up.process]]\nname = \"sim-arm\"\ncommand = [\"./mine\", \"a b\"]\narguments = "
      "[\"c\"]\n");
  EXPECT_EQ(replaced.command,
            (std::vector<std::string>{(scratch() / "mine").string(), "a b", "c"}));
  EXPECT_EQ(replaced.stage, UpStage::kRobot);
}

TEST_F(ProcessPlanTest, WhatAProcessWouldRefuseIsRefusedBeforeAnyStarts) {
  ExpectRefused("[fusion]\nsigma_dge = 1\n", "fusion.sigma_dge");
  ExpectRefused("[ppf]\n", "camera");
  ExpectRefused("[ppf]\ncamera = \"X\"\n[segmentation]\nmax_planes = 0\n", "max_planes = 0");
  ExpectRefused("[camera.X]\n", "camera.X.device: missing");
  ExpectRefused("[camera.X]\ndriver = \"usb\"\ndevice = \"index:0\"\n", "\"openni2\" \"v4l2\"");
  ExpectRefused("[camera.x]\ndevice = \"index:0\"\n", "expected a name of 1 to 32 capitals");
  ExpectRefused("[sim.arm]\nspeed_m_per_s = -1\n", "speed_m_per_s = -1");
  ExpectRefused("[extrinsics]\ncalibration = \"none.toml\"\n", "vantage-handeye makes one");
  ExpectRefused("[fusion]\n[bus]\nurl = \"nonsense\"\n", "nonsense");
  ExpectRefused("[fussion]\n", "fussion: unknown key");
  ExpectRefused("[up]\nstart_s = 1\n", "start_s = 1: expected a number from 2");
}

TEST_F(ProcessPlanTest, WhatCantBeStartedIsRefused) {
  ExpectRefused("", "asks for no process");
  ExpectRefused("[fusion]\n[[up.process]]\nname = \"fusoin\"\n",
                "none of the set-up's processes ( fusion )");
  ExpectRefused("[[up.process]]\nname = \"a\"\ncommand = [\"no-such-program-here\"]\n",
                "no-such-program-here of process a is not there");
  std::ofstream(scratch() / "text") << "no program\n";
  ExpectRefused("[[up.process]]\nname = \"a\"\ncommand = [\"./text\"]\n", "can't be executed");
  ExpectRefused("[[up.process]]\nname = \"a\"\ncommand = [\"./bin\"]\n", "can't be executed");
  ExpectRefused("[[up.process]]\nname = \"a\"\ncommand = [\"sh\", \"a\\nb\"]\n", "line break");
  fs::remove(scratch() / "bin/vantage-fusion");
  ExpectRefused("[fusion]\n", "vantage-fusion of process fusion is not there");
}

}  // namespace
}  // namespace vantage
