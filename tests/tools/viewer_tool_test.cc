// vantage-viewer as its users run it: pictures without a screen, and what it refuses.

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "bus/event_log.h"
#include "bus/message_check.h"
#include "common/format.h"
#include "tests/tools/run_fixtures.h"
#include "tests/tools/run_program.h"
#include "tools/support/rgb_canvas.h"
#include "tools/viewer/viewer_scene.h"
#include "tools/viewer/vtk/viewer_window.h"
#include "tools/viewer/vtk/virtual_display.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

bool IsInstalled(const std::string& program) {
  return std::system(Format("command -v %s > /dev/null", program.c_str()).c_str()) == 0;
}

class ViewerTool : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_);
    unsetenv("DISPLAY");
    auto writer = EventLogWriter::Create(folder_ / "run.lcm");
    ASSERT_TRUE(writer.ok());
    for (int i = 0; i < 20; ++i) {
      const int64_t utime = kRunStart + 100'000 * i;
      const auto objects = ObjectsOf({EstimateAt(1, "mug", Pose::Identity())}, i / 5 + 1, utime);
      ASSERT_TRUE((*writer)->Write(utime, "OBJECTS", Encode(objects)).ok());
    }
    ASSERT_TRUE((*writer)->Close().ok());
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] ProgramOutput View(const std::string& arguments) const {
    return RunProgram("vantage-viewer", arguments, folder_);
  }
  // Refused by one sentence that names `what`, and nothing is left.
  void ExpectRefused(const std::string& arguments, const std::string& what) const {
    const size_t before = ListTree(folder_).size();
    const ProgramOutput output = View(arguments);
    EXPECT_EQ(output.exit_code, 2) << arguments << '\n' << output.text;
    EXPECT_NE(output.text.find(what), std::string::npos) << output.text;
    EXPECT_EQ(ListTree(folder_).size(), before) << arguments;
  }

  fs::path folder_ = fs::temp_directory_path() / ("viewer_tool_" + std::to_string(getpid()));
};

TEST_F(ViewerTool, RefusesCommandLinesThatMeanNothing) {
  ExpectRefused("", "nothing to show");
  ExpectRefused("--offscreen -o a.png", "nothing to show");
  ExpectRefused("run.lcm -o a.png", "--offscreen");
  ExpectRefused("run.lcm --offscreen", "nothing to write");
  ExpectRefused("run.lcm --offscreen -o a.png --size 16x9", "--size 16x9");
  ExpectRefused("run.lcm --offscreen -o a.png --size 1600x900x3", "--size");
  ExpectRefused("run.lcm --offscreen -o a.png --at soon", "--at soon");
  ExpectRefused("run.lcm --offscreen -o a.png --at nan", "--at nan");
  ExpectRefused("run.lcm --offscreen -o a.png --at -1", "--at");
  ExpectRefused("run.lcm --offscreen -o a.png --vector 0 0 0", "--vector");
  ExpectRefused("run.lcm --offscreen -o a.png --speed 0", "--speed");
  ExpectRefused("run.lcm --offscreen --video a.mp4 --size 1601x901", "odd");
  ExpectRefused("run.lcm --offscreen -o a.png --config absent.toml", "absent.toml");
  ExpectRefused("run.lcm", "DISPLAY is not set");
}

TEST_F(ViewerTool, RefusesLogsThatShowNothing) {
  ExpectRefused("absent.lcm --offscreen -o a.png", "absent.lcm");
  std::ofstream(folder_ / "empty.lcm").close();
  ExpectRefused("empty.lcm --offscreen -o a.png", "empty.lcm");
  std::ofstream(folder_ / "text.lcm") << std::string(5000, 'a');
  ExpectRefused("text.lcm --offscreen -o a.png", "text.lcm");
  auto writer = EventLogWriter::Create(folder_ / "foreign.lcm");
  const std::vector<std::byte> bytes(100, std::byte{7});
  ASSERT_TRUE((*writer)->Write(kRunStart, "DRAKE_VIEWER_DRAW", bytes).ok());
  ASSERT_TRUE((*writer)->Close().ok());
  ExpectRefused("foreign.lcm --offscreen -o a.png", "no message that can be shown");
}

TEST_F(ViewerTool, RefusesToWriteWhereItCannot) {
  if (!IsInstalled("Xvfb")) GTEST_SKIP() << "Xvfb is not installed: apt-get install xvfb";
  ExpectRefused("run.lcm --offscreen -o absent/a.png", "absent/a.png");
  ExpectRefused("run.lcm --offscreen --video a.avi", "a.avi");
  ExpectRefused("run.lcm --offscreen -o a.png --at 100", "after the log's end");
  if (!IsInstalled("ffmpeg")) GTEST_SKIP() << "ffmpeg is not installed: apt-get install ffmpeg";
  ExpectRefused("run.lcm --offscreen --video absent/a.mp4", "absent/a.mp4");
}

TEST_F(ViewerTool, DrawsPicturesAndVideos) {
  if (!IsInstalled("Xvfb")) GTEST_SKIP() << "Xvfb is not installed: apt-get install xvfb";
  const ProgramOutput output = View("run.lcm --offscreen -o a.png --at 0.5 --size 960x600");
  ASSERT_EQ(output.exit_code, 0) << output.text;
  EXPECT_NE(output.text.find("no LOG_HEADER"), std::string::npos) << output.text;
  const auto size = fs::file_size(folder_ / "a.png");
  EXPECT_GT(size, 10'000U);
  if (!IsInstalled("ffmpeg")) GTEST_SKIP() << "ffmpeg is not installed: apt-get install ffmpeg";
  const ProgramOutput video =
      View("run.lcm --offscreen --video a.gif --fps 1 --speed 1 --size 960x600");
  ASSERT_EQ(video.exit_code, 0) << video.text;
  EXPECT_GT(fs::file_size(folder_ / "a.gif"), 1'000U);
  EXPECT_EQ(ListTree(folder_).size(), 3U);  // With the log, and nothing else.
}

// An octahedron of one meter.
TriangleMesh Octahedron() {
  TriangleMesh mesh;
  mesh.vertices = {{.5F, 0, 0}, {-.5F, 0, 0}, {0, .5F, 0}, {0, -.5F, 0}, {0, 0, .5F}, {0, 0, -.5F}};
  mesh.triangles = {
      {0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  return mesh;
}

TEST_F(ViewerTool, AMeshIsDrawnWhereItLiesAndInItsColor) {
  if (!IsInstalled("Xvfb")) GTEST_SKIP() << "Xvfb is not installed: apt-get install xvfb";
  const Result<VirtualDisplay> display = VirtualDisplay::Start(1000, 640);
  ASSERT_TRUE(display.ok()) << display.error().message;
  ASSERT_TRUE(CheckDisplay().ok());
  constexpr int kWidth = 1000;
  constexpr int kHeight = 640;
  const WindowLayout layout = LayOut(kWidth, kHeight);
  Page page;
  page.image = FilledImage(kWidth, kHeight, {10, 20, 30});
  ViewerScene scene;
  scene.meshes.push_back(
      {std::make_shared<const TriangleMesh>(Octahedron()), Pose::Identity(), {220, 30, 30}});
  const std::vector<Eigen::Vector3d> corners = {{-1, -1, -1}, {1, 1, 1}, {-1, 1, 1}, {1, -1, -1}};
  ViewerWindow window(kWidth, kHeight, true);
  window.LookAtOverview(corners);
  window.LookAtCloseup(corners);
  window.Show(scene, page);
  const RgbImage image = window.Grab();
  ASSERT_EQ(image.width, kWidth);
  ASSERT_EQ(image.height, kHeight);
  // The middle of the scene is the origin, and the mesh is there.
  const Rgb middle = PixelAt(
      image, layout.scene.x + layout.scene.width / 2, layout.scene.y + layout.scene.height / 2);
  EXPECT_GT(middle.r, 2 * middle.g);
  EXPECT_GT(middle.r, 80);
  // Beside the mesh and below the scene the page is seen as it is.
  EXPECT_EQ(PixelAt(image, layout.scene.x + 5, layout.scene.bottom() - 5), (Rgb{10, 20, 30}));
  EXPECT_EQ(PixelAt(image, layout.steps.x + 5, layout.steps.bottom() - 5), (Rgb{10, 20, 30}));
  EXPECT_EQ(PixelAt(image, kWidth - 5, kHeight - 5), (Rgb{10, 20, 30}));
  // Moved 10 m away, it is gone from there.
  scene.meshes[0].T_world_mesh.translation() = Eigen::Vector3d(100.0, 0.0, 0.0);
  window.Show(scene, page);
  const RgbImage without = window.Grab();
  EXPECT_EQ(PixelAt(without,
                    layout.scene.x + layout.scene.width / 2,
                    layout.scene.y + layout.scene.height / 2),
            (Rgb{10, 20, 30}));
}

TEST_F(ViewerTool, ForeignLogOfOthers) {
  const fs::path shared = fs::path(VANTAGE_SOURCE_DIR).parent_path() / "shared/data/lcm_log_drake";
  if (!fs::exists(shared)) GTEST_SKIP() << shared << " is not there";
  for (const auto& entry : fs::directory_iterator(shared)) {
    if (entry.is_regular_file()) {
      ExpectRefused(Format("'%s' --offscreen -o a.png", entry.path().c_str()),
                    entry.path().filename().string());
    }
  }
}

}  // namespace
}  // namespace vantage
