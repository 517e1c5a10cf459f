// Runs vantage-report as its users do, on a run whose errors are known.

#include <gtest/gtest.h>
#include <png.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "perception/model/file_bytes.h"
#include "tests/tools/base64.h"
#include "tests/tools/rendered_run.h"
#include "tests/tools/run_program.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

// A whole PNG, by libpng's own simplified reader.
Result<RgbImage> DecodePng(const std::vector<uint8_t>& bytes) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()) == 0) {
    return Error{ErrorCode::kCorrupt, png.message};
  }
  png.format = PNG_FORMAT_RGB;
  RgbImage image;
  image.width = static_cast<int>(png.width);
  image.height = static_cast<int>(png.height);
  image.rgb.resize(size_t{3} * png.width * png.height);
  if (png_image_finish_read(&png, nullptr, image.rgb.data(), 0, nullptr) == 0) {
    return Error{ErrorCode::kCorrupt, png.message};
  }
  return image;
}

// To tell a picture from a blank.
size_t CountColors(const RgbImage& image) {
  std::set<std::vector<uint8_t>> colors;
  for (size_t i = 0; i + 2 < image.rgb.size(); i += 3) {
    colors.insert({image.rgb[i], image.rgb[i + 1], image.rgb[i + 2]});
  }
  return colors.size();
}

class ReportTool : public ToolTest {
 protected:
  ReportTool() : ToolTest("vantage-report") {}
  [[nodiscard]] std::string Text(const std::string& name) const {
    const Result<std::string> text = ReadFileBytes(scratch() / name, size_t{1} << 26U);
    EXPECT_TRUE(text.ok()) << text.error().message;
    return text.ok() ? *text : "";
  }
  [[nodiscard]] nlohmann::json Json(const std::string& name) const {
    return nlohmann::json::parse(Text(name));
  }
};

TEST_F(ReportTool, WritesPageTablesAndPicture) {
  const RenderedRun run(scratch());
  run.WriteRun(scratch() / "run.lcm", 1.0 * kDegree, 0.002);
  const ProgramOutput output = Run("run.lcm --config setup.toml --output out/report --per-view");
  ASSERT_EQ(output.exit_code, 0) << output.text;
  const fs::path folder = scratch() / "out" / "report";
  EXPECT_EQ(ListTree(folder),
            (std::vector<std::string>{(folder / "report.html").string(),
                                      (folder / "report.json").string(),
                                      (folder / "report_errors.csv").string(),
                                      (folder / "report_scene.png").string()}));

  const nlohmann::json report = Json("out/report/report.json");
  EXPECT_EQ(report["met"], true);
  ASSERT_EQ(report["objects"].size(), 1U);
  EXPECT_NEAR(report["objects"][0]["error"]["rotation_deg"], 1.0, 1e-5);
  EXPECT_NEAR(report["objects"][0]["error"]["position_mm"], 2.0, 1e-5);
  EXPECT_NEAR(report["objects"][0]["median_detection_deg"], 5.0, 1e-5);
  EXPECT_EQ(report["objects"][0]["views"].size(), 3U);

  const std::string csv = Text("out/report/report_errors.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  EXPECT_NE(output.text.find("bracket: fused 1.00 deg, median single detection 5.00 deg"),
            std::string::npos)
      << output.text;

  const std::string scene = Text("out/report/report_scene.png");
  const Result<RgbImage> picture = DecodePng({scene.begin(), scene.end()});
  ASSERT_TRUE(picture.ok()) << picture.error().message;
  EXPECT_GT(CountColors(*picture), 100U);
}

TEST_F(ReportTool, PageIsWholeByItself) {
  const RenderedRun run(scratch());
  run.WriteRun(scratch() / "run.lcm", 1.0 * kDegree, 0.002);
  const ProgramOutput output = Run("run.lcm --config setup.toml --output out --title 'a <b> & c'");
  ASSERT_EQ(output.exit_code, 0) << output.text;
  const std::string page = Text("out/report.html");
  EXPECT_TRUE(page.starts_with("<!doctype html>"));
  EXPECT_NE(page.find("</html>"), std::string::npos);
  EXPECT_NE(page.find("<title>a &lt;b&gt; &amp; c</title>"), std::string::npos);
  EXPECT_NE(page.find("because &lt;it&gt; is far"), std::string::npos);
  EXPECT_EQ(page.find("<it>"), std::string::npos);
  EXPECT_NE(page.find("bracket"), std::string::npos);
  EXPECT_EQ(page.find("http://"), std::string::npos) << "nothing that it would have to fetch";
  EXPECT_EQ(page.find("https://"), std::string::npos);

  // The scene, three views, three histograms at least; all of them pictures with something on them.
  const std::string mark = "data:image/png;base64,";
  int pictures = 0;
  for (size_t at = page.find(mark); at != std::string::npos; at = page.find(mark, at + 1)) {
    const size_t begin = at + mark.size();
    const Result<RgbImage> picture = DecodePng(
        DecodeBase64(std::string_view(page).substr(begin, page.find('"', begin) - begin)));
    ASSERT_TRUE(picture.ok()) << picture.error().message;
    EXPECT_GT(CountColors(*picture), 20U);
    ++pictures;
  }
  EXPECT_GE(pictures, 1 + 3 + 3);
  const std::string figure_mark = "data:image/svg+xml;base64,";
  const size_t figure = page.find(figure_mark);
  ASSERT_NE(figure, std::string::npos) << "the error by view";
  const std::vector<uint8_t> svg =
      DecodeBase64(std::string_view(page).substr(figure + figure_mark.size()));
  const std::string svg_text(svg.begin(), svg.end());
  EXPECT_NE(svg_text.find("</svg>"), std::string::npos);
  EXPECT_NE(svg_text.find("bracket"), std::string::npos);
}

TEST_F(ReportTool, CheckTellsByItsExitCode) {
  const RenderedRun run(scratch());
  run.WriteRun(scratch() / "run.lcm", 1.0 * kDegree, 0.002);
  const std::string report = "run.lcm --config setup.toml --output out";
  EXPECT_EQ(Run(report + " --check --max-rotation-deg 1.1 --max-position-mm 2.1").exit_code, 0);
  EXPECT_EQ(Json("out/report.json")["met"], true);
  EXPECT_EQ(Run(report + " --check --max-rotation-deg 0.9").exit_code, 1);
  EXPECT_EQ(Json("out/report.json")["met"], false);
  EXPECT_EQ(Run(report + " --max-position-mm 1.9").exit_code, 0) << "only --check fails";
  EXPECT_EQ(Json("out/report.json")["met"], false);
}

TEST_F(ReportTool, OneObjectTooManyFailsTheCheck) {
  const RenderedRun run(scratch());
  run.WriteRun(scratch() / "run.lcm", 1.0 * kDegree, 0.002, 2);
  const ProgramOutput output = Run("run.lcm --config setup.toml --output out --check");
  EXPECT_EQ(output.exit_code, 1);
  EXPECT_NE(output.text.find("bracket 1"), std::string::npos) << output.text;
  EXPECT_NE(output.text.find("not in the truth"), std::string::npos) << output.text;
}

TEST_F(ReportTool, RunThatFoundNothingHasAPageToo) {
  const RenderedRun run(scratch());
  run.WriteRun(scratch() / "run.lcm", 0.0, 0.0, 0);
  const ProgramOutput none = Run("run.lcm --config setup.toml --output out --check");
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_NE(none.text.find("(not found)"), std::string::npos) << none.text;
  EXPECT_NE(Text("out/report.html").find("not found"), std::string::npos);
  EXPECT_TRUE(Json("out/report.json")["objects"][0]["error"].is_null());
}

TEST_F(ReportTool, TruthOfAFileGoesBeforeTheConfigs) {
  const RenderedRun run(scratch());
  run.WriteRun(scratch() / "run.lcm", 1.0 * kDegree, 0.002);
  std::ofstream stream(scratch() / "truth.txt");
  stream.precision(17);
  stream << OffBy(run.T_world_object(), run.model(), 3.0 * kDegree, {0, 0, 0}).matrix();
  stream.close();
  const std::string check = "run.lcm --config setup.toml --output out --check --truth truth.txt ";
  ExpectRefused(check, "--truth-model");
  ExpectRefused(check + "--truth-model mug", "mug");
  EXPECT_EQ(Run(check + "--truth-model bracket --max-rotation-deg 1.9").exit_code, 1);
  EXPECT_NEAR(Json("out/report.json")["objects"][0]["error"]["rotation_deg"], 2.0, 1e-5);
}

TEST_F(ReportTool, BadInputIsOneSentenceAndLeavesNothing) {
  const RenderedRun run(scratch());
  run.WriteRun(scratch() / "run.lcm", 0.0, 0.0);
  run.WriteInputs(scratch() / "inputs.lcm", "");
  std::ofstream(scratch() / "text.lcm") << "this is no log, however long it may be; not at all";
  std::ofstream(scratch() / "bad.toml") << "[ppf]\nnonsense = 1\n";
  std::ofstream(scratch() / "truth.txt") << "1 2 3";
  std::ofstream(scratch() / "file") << "no folder";
  ExpectRefused("", "required");
  ExpectRefused("run.lcm --config setup.toml", "--output");
  ExpectRefused("run.lcm --output out", "--config");
  ExpectRefused("none.lcm --config setup.toml --output out", "none.lcm");
  ExpectRefused("text.lcm --config setup.toml --output out", "text.lcm");
  ExpectRefused("inputs.lcm --config setup.toml --output out", "inputs.lcm has no OBJECTS");
  ExpectRefused("run.lcm --config none.toml --output out", "none.toml");
  ExpectRefused("run.lcm --config bad.toml --output out", "bad.toml");
  ExpectRefused("run.lcm --config setup.toml --output out --truth truth.txt --truth-model bracket",
                "3 numbers");
  ExpectRefused("run.lcm --config setup.toml --output out --max-rotation-deg -1",
                "max-rotation-deg");
  ExpectRefused("run.lcm --config setup.toml --output file", "file");
}

TEST_F(ReportTool, HostileMessagesAreDrawnAround) {
  const RenderedRun run(scratch());
  run.WriteRun(scratch() / "run.lcm", 1.0 * kDegree, 0.002);
  auto writer = EventLogWriter::Create(scratch() / "more.lcm");
  ASSERT_TRUE(writer.ok());
  const int64_t at = RenderedRun::UtimeOf(9);
  const Pose far_away(Eigen::Translation3d(1e5, -1e5, 3.0));
  const auto objects = ObjectsOf({EstimateAt(0, "bracket", run.T_world_object()),
                                  EstimateAt(1, "teapot", run.T_world_object()),
                                  EstimateAt(2, "\xff\xfe</script>", run.T_world_object()),
                                  EstimateAt(3, "bracket", far_away)},
                                 3,
                                 RenderedRun::UtimeOf(2));
  ASSERT_TRUE((*writer)->Write(at, "OBJECTS", Encode(objects)).ok());
  int32_t instance = 0;
  for (const int32_t k : {-1, 0, 1 << 30, 128, 8}) {
    orientation_histogram_t histogram{};
    histogram.instance_id = instance++ % 2 * 3;
    histogram.k = k;
    histogram.cell = {-5, 0, INT32_MAX, INT32_MIN, 2000};
    histogram.weight = {1.0F, NAN, INFINITY, -1.0F, 3e38F};
    histogram.num_cells = 5;
    ASSERT_TRUE((*writer)->Write(at, "ORIENTATION_HISTOGRAM", Encode(histogram)).ok());
  }
  ASSERT_TRUE((*writer)->Close().ok());
  // Behind the run, in one file.
  ASSERT_TRUE(WriteFileBytes(scratch() / "run.lcm", Text("run.lcm") + Text("more.lcm")).ok());
  const ProgramOutput output = Run("run.lcm --config setup.toml --output out --check");
  EXPECT_EQ(output.exit_code, 1) << output.text;
  EXPECT_NE(output.text.find("teapot 1"), std::string::npos) << output.text;
  EXPECT_EQ(Json("out/report.json")["extra"].size(), 2U);
}

}  // namespace
}  // namespace vantage
