// --config, --set, --compare and --sweep of vantage-replay, as its users run it.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "perception/model/file_bytes.h"
#include "tests/tools/rendered_run.h"
#include "tests/tools/run_program.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

class ReplayConfigTool : public ToolTest {
 protected:
  ReplayConfigTool() : ToolTest("vantage-replay") {}
  [[nodiscard]] std::string Bytes(const std::string& name) const {
    const Result<std::string> bytes = ReadFileBytes(scratch() / name, size_t{1} << 28U);
    EXPECT_TRUE(bytes.ok()) << bytes.error().message;
    return bytes.ok() ? *bytes : "";
  }
  void ExpectSays(const std::string& arguments, int code, const std::string& part) const {
    const ProgramOutput output = Run(arguments);
    EXPECT_EQ(output.exit_code, code) << arguments << "\n" << output.text;
    EXPECT_NE(output.text.find(part), std::string::npos) << arguments << "\n" << output.text;
  }
};

TEST_F(ReplayConfigTool, SetIsToldAndKeptInTheOutput) {
  const RenderedRun rendered(scratch());
  rendered.WriteInputs(scratch() / "in.lcm", RenderedRun::Config());
  const std::string set = " --set fusion.sigma_deg=6 --set fusion.min_views=2 ";
  const ProgramOutput first = Run("in.lcm --with-inputs --output a.lcm" + set);
  ASSERT_EQ(first.exit_code, 0) << first.text;
  EXPECT_NE(first.text.find("other than in the log's LOG_HEADER"), std::string::npos);
  EXPECT_NE(first.text.find("fusion.sigma_deg: 4 -> 6"), std::string::npos) << first.text;
  EXPECT_NE(first.text.find("fusion.min_views: "), std::string::npos) << "a default before";
  // The output says by itself what it was made with, wherever it is read.
  fs::create_directory(scratch() / "elsewhere");
  const ProgramOutput again = Run("a.lcm --with-inputs --output elsewhere/b.lcm --compare");
  ASSERT_EQ(again.exit_code, 0) << again.text;
  EXPECT_EQ(again.text.find("other than"), std::string::npos) << again.text;
  EXPECT_TRUE(Bytes("a.lcm") == Bytes("elsewhere/b.lcm"));
  ExpectSays("a.lcm --set fusion.sigma_deg=6", 0, "configuration from the log's LOG_HEADER");
  EXPECT_EQ(Run("a.lcm --set fusion.sigma_deg=6").text.find("->"), std::string::npos);
  // And a file is compared with it, in values, not in text.
  ExpectSays("a.lcm --config setup.toml", 0, "fusion.sigma_deg: 6 -> 4");
}

TEST_F(ReplayConfigTool, BadSettingsAreRefused) {
  const RenderedRun rendered(scratch());
  rendered.WriteInputs(scratch() / "in.lcm", "");
  const auto refused = [&](const std::string& setting, const std::string& part) {
    ExpectRefused("in.lcm -c setup.toml -o o.lcm --set '" + setting + "'", part);
  };
  refused("fusion.sigma_dge=4", "did you mean sigma_deg?");
  refused("fuson.sigma_deg=4", "did you mean fusion?");
  refused("fusion.sigma_deg=-4", "fusion.sigma_deg = -4: expected a number from 0.1 to 90");
  refused("fusion.sigma_deg=wide", "expected a number");
  refused("fusion.sigma_deg=nan", "expected a number");
  refused("fusion.sigma_deg", "expected table.key=value");
  refused("fusion.sigma_deg=", "the value is missing");
  refused("models.use=[\"teapot\"]", "teapot");
  refused("models.folder=none", "none");
  refused("fusion.sigma_deg.x=3", "sigma_deg is no table");
  refused("sim.seed=2", "nothing in this rerun reads it");
  refused("shot.seed=2", "nothing in this rerun reads it");
  refused("fusion.state_file=x", "nothing in this rerun reads it");
  refused("camera.TEST.fps=3", "nothing in this rerun reads it");
}

TEST_F(ReplayConfigTool, CompareWithWhatIsRecorded) {
  const RenderedRun rendered(scratch());
  rendered.WriteInputs(scratch() / "in.lcm", "");
  ExpectRefused("in.lcm --config none.toml --compare", "none.toml");
  ExpectSays("in.lcm --config setup.toml --compare", 2, "holds nothing of what a rerun makes");
  ASSERT_EQ(Run("in.lcm --config setup.toml --with-inputs --output a.lcm").exit_code, 0);
  ExpectSays("a.lcm --compare", 0, "No difference.");
  ExpectSays("in.lcm --config setup.toml --compare-with a.lcm", 0, "No difference.");
  ExpectSays("a.lcm --compare --set fusion.sigma_deg=9", 1, "First difference: ");
  ExpectSays("a.lcm --compare --set ppf.seed=2", 1, "DETECTIONS_PPF");
  ExpectRefused("a.lcm --compare --from 1", "--from");
  ExpectRefused("a.lcm --compare --output ./a.lcm", "is a log that is read");
  ExpectRefused("a.lcm --compare --angle-tolerance-deg -1", "angle-tolerance");
}

TEST_F(ReplayConfigTool, SweepIsTheSameForAnyNumberOfThreads) {
  const RenderedRun rendered(scratch());
  rendered.WriteInputs(scratch() / "in.lcm", "");
  fs::copy_file(scratch() / "in.lcm", scratch() / "two.lcm");
  ASSERT_TRUE(WriteFileBytes(scratch() / "grid.toml",
                             "[grid]\n\"fusion.sigma_deg\" = [2, 8]\nfusion.final_orientation = "
                             "[\"density_mode\", \"voting\"]\n")
                  .ok());
  const ProgramOutput probe = Run("in.lcm two.lcm -c setup.toml --sweep grid.toml -o one");
  ASSERT_EQ(probe.exit_code, 0) << probe.text;
  ASSERT_EQ(Run("in.lcm two.lcm -c setup.toml --sweep grid.toml -o more --threads 3").exit_code, 0);
  for (const char* name : {"sweep.csv", "sweep.json", "sweep.svg"}) {
    EXPECT_TRUE(Bytes(std::string("one/") + name) == Bytes(std::string("more/") + name)) << name;
  }
  EXPECT_NE(Bytes("one/sweep.csv").find("8,"), std::string::npos);
  EXPECT_NE(probe.text.find("2 of 2"), std::string::npos) << probe.text;
}

TEST_F(ReplayConfigTool, BadSweepsAreRefusedBeforeAnythingRuns) {
  const RenderedRun rendered(scratch());
  rendered.WriteInputs(scratch() / "in.lcm", "");
  const auto refused = [&](const std::string& text, const std::string& part) {
    ASSERT_TRUE(WriteFileBytes(scratch() / "grid.toml", text).ok());
    ExpectRefused("in.lcm -c setup.toml --sweep grid.toml -o folder", part);
  };
  refused("", "expected a table [grid]");
  refused("[grid]\n", "expected a table [grid]");
  refused("grid = 3\n", "expected a table [grid]");
  refused("[grid]\nfusion.sigma_deg = 3\n", "expected a list");
  refused("[grid]\nfusion.sigma_deg = []\n", "expected a list");
  refused("[grid]\nfusion.sigma_deg = [2, -3]\n", "fusion.sigma_deg = -3");
  refused("[grid]\nfusion.sigma_dge = [2, 3]\n", "did you mean sigma_deg?");
  refused("[grid]\nsim.seed = [2, 3]\n", "nothing in this rerun reads it");
  refused("[grid]\nfusion.sigma_deg = [2]\n[other]\n", "other: unknown key");
  refused("[grid\n", "no valid TOML");
  ExpectRefused("in.lcm -c setup.toml --sweep none.toml -o folder", "none.toml");
  ExpectRefused("in.lcm two.lcm -c setup.toml", "--sweep");
}

}  // namespace
}  // namespace vantage
