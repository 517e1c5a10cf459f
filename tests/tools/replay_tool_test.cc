// Runs vantage-replay as its users do, on a rendered scene and on recorded views.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/event_log.h"
#include "perception/model/file_bytes.h"
#include "tests/tools/rendered_run.h"
#include "tests/tools/run_program.h"
#include "tools/log/log_import.h"
#include "tools/support/recorded_run.h"
#include "tools/support/run_metrics.h"
#include "tools/support/view_folder.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

class Replay : public ToolTest {
 protected:
  Replay() : ToolTest("vantage-replay") {}
  [[nodiscard]] std::string Bytes(const std::string& name) const {
    const Result<std::string> bytes = ReadFileBytes(scratch() / name, size_t{1} << 28U);
    EXPECT_TRUE(bytes.ok()) << bytes.error().message;
    return bytes.ok() ? *bytes : "";
  }
  [[nodiscard]] std::map<std::string, int> CountChannels(const std::string& name) const {
    std::map<std::string, int> counts;
    auto reader = EventLogReader::Open(scratch() / name);
    EXPECT_TRUE(reader.ok()) << reader.error().message;
    while (const std::optional<LogEvent> event = (*reader)->Next()) ++counts[event->channel];
    return counts;
  }
};

TEST_F(Replay, FindsTheRenderedObjectTheSameEveryTime) {
  const RenderedRun rendered(scratch());
  rendered.WriteInputs(scratch() / "in.lcm", "");
  const ProgramOutput first = Run("in.lcm --config setup.toml --output a.lcm");
  ASSERT_EQ(first.exit_code, 0) << first.text;
  EXPECT_NE(first.text.find("bracket"), std::string::npos) << first.text;
  EXPECT_NE(first.text.find(" events of "), std::string::npos) << first.text;
  ASSERT_EQ(Run("in.lcm --config setup.toml --output b.lcm").exit_code, 0);
  EXPECT_TRUE(Bytes("a.lcm") == Bytes("b.lcm")) << "not the same, byte by byte";

  const Result<RecordedRun> run = ReadRun(scratch() / "a.lcm", "TEST");
  ASSERT_TRUE(run.ok()) << run.error().message;
  ASSERT_EQ(run->views.size(), 3U);
  EXPECT_EQ(run->views.back().utime, RenderedRun::UtimeOf(2));
  EXPECT_EQ(run->views.back().depth.width, 0) << "inputs are not copied unasked";
  const Result<ReportSetup> setup = LoadReportSetup(rendered.config());
  ASSERT_TRUE(setup.ok());
  EXPECT_TRUE(MeasureRun(*run, *setup).Within(2.0 * kDegree, 0.003)) << first.text;
  const std::map<std::string, int> channels = CountChannels("a.lcm");
  EXPECT_EQ(channels.at("DETECTIONS_PPF"), 3);
  EXPECT_EQ(channels.at("LOG_HEADER"), 1);
  EXPECT_FALSE(channels.contains("CAMERA_TEST"));
}

TEST_F(Replay, OutputWithInputsCanBeReplayedByItself) {
  const RenderedRun rendered(scratch());
  rendered.WriteInputs(scratch() / "in.lcm", "");
  ASSERT_EQ(Run("in.lcm --config setup.toml --with-inputs --output a.lcm").exit_code, 0);
  const std::map<std::string, int> channels = CountChannels("a.lcm");
  EXPECT_EQ(channels.at("CAMERA_TEST"), 3);
  EXPECT_EQ(channels.at("CAMERA_TEST_INFO"), 3);
  EXPECT_EQ(channels.at("CAMERA_TEST_TO_WORLD"), 3 * 81);
  EXPECT_EQ(channels.at("LOG_HEADER"), 1);
  // Its header has the set-up now, and what was recomputed is computed anew, not taken twice.
  fs::remove(scratch() / "setup.toml");
  const ProgramOutput again = Run("a.lcm --with-inputs --output b.lcm");
  ASSERT_EQ(again.exit_code, 0) << again.text;
  EXPECT_NE(again.text.find("LOG_HEADER"), std::string::npos) << again.text;
  EXPECT_TRUE(Bytes("a.lcm") == Bytes("b.lcm"));
}

TEST_F(Replay, ConfigOfTheLogsHeader) {
  const RenderedRun rendered(scratch());
  rendered.WriteInputs(scratch() / "in.lcm", RenderedRun::Config());
  const ProgramOutput output = Run("in.lcm");
  EXPECT_EQ(output.exit_code, 0) << output.text;
  EXPECT_NE(output.text.find("configuration from the log's LOG_HEADER"), std::string::npos);
  EXPECT_NE(output.text.find("bracket"), std::string::npos) << output.text;
  // --config goes before it.
  ASSERT_TRUE(WriteFileBytes(scratch() / "bad.toml", "[ppf]\nnonsense = 1\n").ok());
  ExpectRefused("in.lcm --config bad.toml", "bad.toml");
}

TEST_F(Replay, BadInputIsOneSentenceAndLeavesNothing) {
  const RenderedRun rendered(scratch());
  rendered.WriteInputs(scratch() / "in.lcm", "");
  std::ofstream(scratch() / "text.lcm") << "this is no log, however long it may be; not at all";
  std::ofstream(scratch() / "empty.lcm");
  ExpectRefused("", "log is required");
  ExpectRefused("none.lcm --config setup.toml --output o.lcm", "none.lcm");
  ExpectRefused("text.lcm --config setup.toml --output o.lcm", "text.lcm");
  ExpectRefused("empty.lcm --config setup.toml --output o.lcm", "empty.lcm");
  ExpectRefused("in.lcm --output o.lcm", "no LOG_HEADER with a configuration");
  ExpectRefused("in.lcm --output o.lcm", "--config FILE");
  ExpectRefused("in.lcm --config none.toml --output o.lcm", "none.toml");
  ExpectRefused("in.lcm --config setup.toml --output none/o.lcm", "none/o.lcm");
  ExpectRefused("in.lcm --config setup.toml --nonsense", "nonsense");

  const auto with = [&](const std::string& from, const std::string& to, const std::string& part) {
    std::string text = RenderedRun::Config();
    const size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    ASSERT_TRUE(WriteFileBytes(rendered.config(), text.replace(at, from.size(), to)).ok());
    ExpectRefused("in.lcm --config setup.toml --output o.lcm", part);
  };
  with("use = [\"bracket\"]", "use = [\"teapot\"]", "teapot");
  with("seed = 1", "sede = 1", "sede");
  with("sigma_deg = 4.0", "sigma_deg = -4.0", "sigma_deg");
  with("k = 64", "k = 1", "k = 1");
}

TEST_F(Replay, DamagedLogIsReadAroundAndTold) {
  const RenderedRun rendered(scratch());
  rendered.WriteInputs(scratch() / "in.lcm", "");
  std::string bytes = Bytes("in.lcm");
  bytes.resize(bytes.size() - 10);
  ASSERT_TRUE(WriteFileBytes(scratch() / "in.lcm", bytes).ok());
  const ProgramOutput output = Run("in.lcm --config setup.toml");
  EXPECT_EQ(output.exit_code, 0);
  EXPECT_NE(output.text.find("damage: "), std::string::npos) << output.text;
  EXPECT_NE(output.text.find("bracket"), std::string::npos) << output.text;
}

TEST_F(Replay, RecordedViewsOfABunny) {
  const fs::path data = fs::path(VANTAGE_SOURCE_DIR) / ".." / "shared" / "data";
  const fs::path folder = data / "bunny_turntable_36views";
  fs::path mesh;
  std::error_code absent;
  for (const auto& entry : fs::directory_iterator(data / "meshes", absent)) {
    if (entry.path().filename().string().find("bunny") != std::string::npos) mesh = entry.path();
  }
  if (!fs::exists(folder) || mesh.empty()) GTEST_SKIP() << folder << " is absent";
  const ProgramOutput built = RunProgram(
      "vantage-model", "build '" + mesh.string() + "' --unit m --output models/object", scratch());
  ASSERT_EQ(built.exit_code, 0) << built.text;
  const Result<std::vector<RecordedView>> views = ListViewFolder(folder, 1.0);
  ASSERT_TRUE(views.ok()) << views.error().message;
  const std::vector<RecordedView> few = {(*views)[0], (*views)[9], (*views)[18]};
  LogImportParameters parameters;
  parameters.camera = "TEST";
  ASSERT_TRUE(ImportViews(few, parameters, scratch() / "in.lcm").ok());
  ASSERT_TRUE(
      WriteFileBytes(
          scratch() / "setup.toml",
          "[camera.TEST]\n[models]\nfolder = \"models\"\nuse = [\"object\"]\n[ppf]\nseed = 1\n"
          "[planner]\nmax_views = 3\n")
          .ok());
  const ProgramOutput output = Run("in.lcm --config setup.toml --output a.lcm");
  ASSERT_EQ(output.exit_code, 0) << output.text;

  Result<ReportSetup> setup = LoadReportSetup(scratch() / "setup.toml");
  ASSERT_TRUE(setup.ok()) << setup.error().message;
  const Result<TruthObject> truth = ReadTruthMatrix(folder / "world_T_model.txt", "object");
  ASSERT_TRUE(truth.ok()) << truth.error().message;
  setup->truth = {*truth};
  const Result<RecordedRun> run = ReadRun(scratch() / "a.lcm", "TEST");
  ASSERT_TRUE(run.ok()) << run.error().message;
  // The truth itself is good to 1.3 degrees.
  EXPECT_TRUE(MeasureRun(*run, *setup).Within(4.0 * kDegree, 0.005)) << output.text;
}

}  // namespace
}  // namespace vantage
