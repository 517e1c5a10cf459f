// Runs vantage-stages as its users do, on a rendered scene.

#include <gtest/gtest.h>
#include <png.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "bus/event_log.h"
#include "bus/image_conversion.h"
#include "bus/message_check.h"
#include "perception/model/file_bytes.h"
#include "tests/tools/rendered_run.h"
#include "tests/tools/run_program.h"
#include "tools/support/stage_page.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

class StagesTool : public ToolTest {
 protected:
  StagesTool() : ToolTest("vantage-stages") {}

  // A whole PNG, by libpng's own simplified reader.
  [[nodiscard]] RgbImage Picture(const std::string& name) const {
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    RgbImage image;
    EXPECT_NE(png_image_begin_read_from_file(&png, (scratch() / name).c_str()), 0) << png.message;
    png.format = PNG_FORMAT_RGB;
    image.width = static_cast<int>(png.width);
    image.height = static_cast<int>(png.height);
    image.rgb.resize(size_t{3} * png.width * png.height);
    EXPECT_NE(png_image_finish_read(&png, nullptr, image.rgb.data(), 0, nullptr), 0) << png.message;
    return image;
  }

  // Copies the messages of a log that a test lets through.
  template <class Keep>
  void CopyLog(const std::string& from, const std::string& to, Keep keep) const {
    auto reader = EventLogReader::Open(scratch() / from);
    ASSERT_TRUE(reader.ok());
    auto writer = EventLogWriter::Create(scratch() / to);
    ASSERT_TRUE(writer.ok());
    while (std::optional<LogEvent> event = (*reader)->Next()) {
      if (!keep(&*event)) continue;
      ASSERT_TRUE((*writer)->Write(event->utime, event->channel, event->data).ok());
    }
    ASSERT_TRUE((*writer)->Close().ok());
  }
};

// Colors of a part of a picture, without its outermost pixels.
size_t CountColors(const RgbImage& image, int left, int top, int width, int height) {
  std::set<uint32_t> colors;
  for (int v = top + 2; v < top + height - 2; ++v) {
    for (int u = left + 2; u < left + width - 2; ++u) {
      const auto at =
          3 * (static_cast<size_t>(v) * static_cast<size_t>(image.width) + static_cast<size_t>(u));
      colors.insert((uint32_t{image.rgb[at]} << 16U) | (uint32_t{image.rgb[at + 1]} << 8U) |
                    image.rgb[at + 2]);
    }
  }
  return colors.size();
}

TEST_F(StagesTool, DrawsSixPanelsAndTellsWhatBecameOfTheModel) {
  const RenderedRun rendered(scratch());
  rendered.WriteInputs(scratch() / "in.lcm", RenderedRun::Config());
  const ProgramOutput output = Run("--log in.lcm --output stages.png");
  ASSERT_EQ(output.exit_code, 0) << output.text;
  for (const char* part : {"image 1 of 3 taken at rest",
                           "cluster 0: ",
                           "inside the image",
                           "  bracket: ",
                           "final score",
                           "accepted",
                           "detected bracket in cluster 0, score "}) {
    EXPECT_NE(output.text.find(part), std::string::npos) << part << " in " << output.text;
  }
  const RgbImage page = Picture("stages.png");
  ASSERT_EQ(page.width, StageLayout::Width());
  ASSERT_EQ(page.height, StageLayout::Height(6));
  for (int panel = 0; panel < 6; ++panel) {
    SCOPED_TRACE(panel);
    const int left = StageLayout::Left(panel);
    const int top = StageLayout::Top(panel);
    EXPECT_GE(CountColors(page, left, top, StageLayout::kPanelWidth, StageLayout::kPanelHeight),
              4U);
    const int title = StageLayout::kTitle - 2;
    EXPECT_GE(CountColors(page, left, top - title, StageLayout::kPanelWidth, title), 4U);
  }
  EXPECT_LT(fs::file_size(scratch() / "stages.png"), 1'000'000U);
}

TEST_F(StagesTool, TheSameEveryTimeAndOfTheImageThatWasAskedFor) {
  const RenderedRun rendered(scratch());
  rendered.WriteInputs(scratch() / "in.lcm", "");
  const std::string arguments = "--log in.lcm --config setup.toml --image ";
  const ProgramOutput first = Run(arguments + "2 --output a.png");
  ASSERT_EQ(first.exit_code, 0) << first.text;
  const ProgramOutput second = Run(arguments + "2 --output b.png");
  EXPECT_EQ(first.text, second.text);
  EXPECT_TRUE(Picture("a.png").rgb == Picture("b.png").rgb);
  const ProgramOutput other = Run(arguments + "3 --output c.png");
  EXPECT_NE(other.text.find("image 3 of 3"), std::string::npos) << other.text;
  EXPECT_FALSE(Picture("a.png").rgb == Picture("c.png").rgb);
}

TEST_F(StagesTool, TheFirstImageWithDetectionsUnlessAsked) {
  const RenderedRun rendered(scratch());
  rendered.WriteRun(scratch() / "run.lcm", 0.0, 0.0);
  CopyLog("run.lcm", "late.lcm", [](LogEvent* event) {
    return event->channel != "DETECTIONS_PPF" || event->utime > RenderedRun::UtimeOf(2);
  });
  const ProgramOutput output = Run("--log late.lcm --config setup.toml --output stages.png");
  EXPECT_EQ(output.exit_code, 0) << output.text;
  EXPECT_NE(output.text.find("image 3 of 3"), std::string::npos) << output.text;
}

TEST_F(StagesTool, WhatIsNotThereIsSaidAndDrawnAll) {
  const RenderedRun rendered(scratch());
  rendered.WriteInputs(scratch() / "in.lcm", "");
  // Nothing measured at all.
  CopyLog("in.lcm", "blind.lcm", [](LogEvent* event) {
    if (event->channel != "CAMERA_TEST") return true;
    const auto message = DecodeChecked<images_t>(event->data);
    EXPECT_TRUE(message.ok());
    const auto& image = message->images.front();
    const std::vector<uint16_t> none(
        static_cast<size_t>(image.width) * static_cast<size_t>(image.height), 0);
    event->data = Encode(DepthToMessage(
        image.width, image.height, none, message->utime, 0, "", DepthCompression::kNone));
    return true;
  });
  const ProgramOutput blind = Run("--log blind.lcm --config setup.toml --output blind.png");
  EXPECT_EQ(blind.exit_code, 0) << blind.text;
  EXPECT_NE(blind.text.find("no cluster"), std::string::npos) << blind.text;
  EXPECT_NE(blind.text.find("nothing detected"), std::string::npos) << blind.text;
  EXPECT_EQ(Picture("blind.png").width, StageLayout::Width());
  // A model of which there is none.
  std::string text = RenderedRun::Config();
  const std::string use = "use = [\"bracket\"]";
  ASSERT_NE(text.find(use), std::string::npos);
  ASSERT_TRUE(
      WriteFileBytes(rendered.config(), text.replace(text.find(use), use.size(), "use = [\"mug\"]"))
          .ok());
  const ProgramOutput other = Run("--log in.lcm --config setup.toml --output other.png");
  EXPECT_EQ(other.exit_code, 0) << other.text;
  EXPECT_NE(other.text.find("below min_score 0.80"), std::string::npos) << other.text;
  EXPECT_NE(other.text.find("nothing detected"), std::string::npos) << other.text;
}

TEST_F(StagesTool, BadInputIsOneSentenceAndLeavesNothing) {
  const RenderedRun rendered(scratch());
  rendered.WriteInputs(scratch() / "in.lcm", "");
  const auto without = [&](const std::string& channel, const std::string& to) {
    CopyLog("in.lcm", to, [&](LogEvent* event) { return event->channel != channel; });
  };
  without("CAMERA_TEST", "no_images.lcm");
  without("CAMERA_TEST_INFO", "no_info.lcm");
  CopyLog("in.lcm", "moving.lcm", [n = 0](LogEvent* event) mutable {
    return event->channel != "CAMERA_TEST_TO_WORLD" || n++ % 40 == 0;
  });
  std::ofstream(scratch() / "text.lcm") << "this is no log, however long it may be; not at all";
  const std::string rest = " --config setup.toml --output o.png";
  ExpectRefused("--config setup.toml --output o.png", "--log");
  ExpectRefused("--log in.lcm --config setup.toml", "--output");
  ExpectRefused("--log none.lcm" + rest, "none.lcm");
  ExpectRefused("--log text.lcm" + rest, "text.lcm");
  ExpectRefused("--log no_images.lcm" + rest, "no images on CAMERA_TEST");
  ExpectRefused("--log no_info.lcm" + rest, "CAMERA_TEST_INFO");
  ExpectRefused("--log moving.lcm" + rest, "taken at rest");
  ExpectRefused("--log in.lcm --image 4" + rest, "--image 4, expected 1 to 3");
  ExpectRefused("--log in.lcm --image 0" + rest, "--image 0, expected 1 to 3");
  ExpectRefused("--log in.lcm --image two" + rest, "--image");
  ExpectRefused("--log in.lcm --cluster 99" + rest, "--cluster 99");
  ExpectRefused("--log in.lcm --output o.png", "--config FILE");
  ExpectRefused("--log in.lcm --config none.toml --output o.png", "none.toml");
  ExpectRefused("--log in.lcm --config setup.toml --output none/o.png", "none/o.png");

  fs::create_directory(scratch() / "empty");
  std::string text = RenderedRun::Config();
  const std::string folder = "folder = \"" VANTAGE_SOURCE_DIR "/models\"\nuse = [\"bracket\"]";
  const size_t at = text.find(folder);
  ASSERT_NE(at, std::string::npos);
  text.replace(at, folder.size(), "folder = \"empty\"");
  ASSERT_TRUE(WriteFileBytes(rendered.config(), text).ok());
  ExpectRefused("--log in.lcm" + rest, "no model");
}

}  // namespace
}  // namespace vantage
