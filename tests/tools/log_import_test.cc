// vantage-log import and info, and the PNG files that they read.

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/conversions.h"
#include "bus/event_log.h"
#include "bus/image_conversion.h"
#include "bus/message_check.h"
#include "common/format.h"
#include "common/pose_buffer.h"
#include "common/rng.h"
#include "perception/model/file_bytes.h"
#include "tests/tools/run_program.h"
#include "tools/support/bop_folder.h"
#include "tools/log/log_import.h"
#include "tools/support/png_image.h"
#include "tools/support/view_folder.h"
#include "vantage/images_t.hpp"
#include "vantage/log_header_t.hpp"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 20;
constexpr int kHeight = 14;
constexpr const char* kIntrinsics = "30 0 9.5\n0 31 6.5\n0 0 1\n";

Gray16Image Depth(int seed, int width = kWidth, int height = kHeight) {
  Gray16Image image{width, height, {}};
  Rng rng(static_cast<uint64_t>(seed));
  for (int i = 0; i < width * height; ++i) {
    image.gray.push_back(static_cast<uint16_t>(rng.Below(4) == 0 ? 0 : rng.Below(65536)));
  }
  return image;
}

Pose ViewPose(int seed) {
  Rng rng(static_cast<uint64_t>(seed) + 100);
  Pose pose = Pose::Identity();
  pose.linear() = rng.Rotation().toRotationMatrix();
  pose.translation() = rng.UnitVector();
  return pose;
}

std::string MatrixText(const Eigen::MatrixXd& matrix) {
  std::string text;
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) {
      text += Format("%.12e ", matrix(row, column));
    }
    text += "\n";
  }
  return text;
}

void WriteText(const fs::path& file, const std::string& text) {
  ASSERT_TRUE(WriteFileBytes(file, text).ok()) << file;
}

// depth_N.png and world_T_camera_N.txt, not numbered from 0 and with a tenth view after the ninth.
void WriteViewFolder(const fs::path& folder, int count) {
  fs::create_directories(folder);
  WriteText(folder / "Intrinsic.txt", kIntrinsics);
  for (int i = 0; i < count; ++i) {
    ASSERT_TRUE(WritePng(folder / Format("depth_%d.png", i + 5), Depth(i)).ok());
    WriteText(folder / Format("world_T_camera_%d.txt", i + 5), MatrixText(ViewPose(i).matrix()));
  }
}

std::string BopEntry(const Pose& T_world_camera, double depth_scale) {
  const Pose T_camera_world = T_world_camera.inverse();
  std::string R;
  for (Eigen::Index i = 0; i < 9; ++i) {
    R += Format("%s%.15g", i == 0 ? "" : ", ", T_camera_world.linear()(i / 3, i % 3));
  }
  const Eigen::Vector3d t = 1e3 * T_camera_world.translation();
  return Format(
      "{\"cam_K\": [30, 0, 9.5, 0, 31, 6.5, 0, 0, 1], \"depth_scale\": %g, "
      "\"cam_R_w2c\": [%s], \"cam_t_w2c\": [%.15g, %.15g, %.15g]}",
      depth_scale,
      R.c_str(),
      t.x(),
      t.y(),
      t.z());
}

void WriteBopScene(const fs::path& scene, int count) {
  fs::create_directories(scene / "depth");
  std::string text = "{";
  for (int i = 0; i < count; ++i) {
    ASSERT_TRUE(WritePng(scene / "depth" / Format("%06d.png", i + 1), Depth(i)).ok());
    text += Format("%s\"%d\": ", i == 0 ? "" : ",\n", i + 1) + BopEntry(ViewPose(i), 0.1);
  }
  WriteText(scene / "scene_camera.json", text + "}");
}

std::vector<LogEvent> ReadLog(const fs::path& file) {
  std::vector<LogEvent> events;
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(file);
  EXPECT_TRUE(reader.ok()) << reader.error().message;
  while (std::optional<LogEvent> event = (*reader)->Next()) events.push_back(*std::move(event));
  EXPECT_FALSE((*reader)->damage().any());
  return events;
}

class Import : public ToolTest {
 protected:
  Import() : ToolTest("vantage-log") {}
};

// Depth, pose and intrinsics of each view come back from the log, and the camera rests there.
void ExpectViews(const fs::path& log, int count, double depth_scale) {
  const std::vector<LogEvent> events = ReadLog(log);
  ASSERT_FALSE(events.empty());
  EXPECT_EQ(events.front().channel, "LOG_HEADER");
  const Result<log_header_t> header = DecodeChecked<log_header_t>(events.front().data);
  ASSERT_TRUE(header.ok());
  EXPECT_GT(header->num_schemas, 10);
  PoseBuffer poses({.horizon_us = 1'000'000'000});
  std::vector<DepthFrame> frames;
  int64_t previous = 0;
  for (const LogEvent& event : events) {
    EXPECT_GE(event.utime, previous);
    previous = event.utime;
    if (event.channel == "CAMERA_A") {
      const Result<images_t> images = DecodeChecked<images_t>(event.data);
      ASSERT_TRUE(images.ok());
      Result<DepthFrame> frame = DepthFrameFromMessage(*images);
      ASSERT_TRUE(frame.ok()) << frame.error().message;
      EXPECT_EQ(frame->utime, event.utime);
      frames.push_back(std::move(frame).value());
    } else if (event.channel == "CAMERA_A_TO_WORLD") {
      const Result<rigid_transform_t> message = DecodeChecked<rigid_transform_t>(event.data);
      ASSERT_TRUE(message.ok());
      EXPECT_EQ(message->utime, event.utime);
      poses.Add(message->utime, *PoseFromMessage(*message));
    } else if (event.channel == "CAMERA_A_INFO") {
      const Result<camera_info_t> info = DecodeChecked<camera_info_t>(event.data);
      ASSERT_TRUE(info.ok());
      EXPECT_EQ(info->seq, static_cast<int64_t>(frames.size()));
      const CameraModel expected{kWidth, kHeight, 30.0, 31.0, 9.5, 6.5};
      EXPECT_EQ(*CameraFromMessage(*info), expected);
    }
  }
  ASSERT_EQ(frames.size(), static_cast<size_t>(count));
  for (int i = 0; i < count; ++i) {
    const DepthFrame& frame = frames[static_cast<size_t>(i)];
    EXPECT_EQ(frame.seq, i);
    EXPECT_TRUE(poses.RestsAt(frame.utime, 390'000));
    EXPECT_LE((poses.At(frame.utime)->matrix() - ViewPose(i).matrix()).norm(), 1e-9);
    const Gray16Image expected = Depth(i);
    const std::vector<uint16_t> found = DepthToMillimetres(frame.image);
    for (size_t pixel = 0; pixel < found.size(); ++pixel) {
      ASSERT_EQ(found[pixel], std::lround(depth_scale * expected.gray[pixel]));
    }
  }
}

TEST_F(Import, ViewFolderComesBackFromTheLog) {
  WriteViewFolder(scratch() / "v", 7);
  const ProgramOutput output = Run("import v --camera A --output a.lcm");
  ASSERT_EQ(output.exit_code, 0) << output.text;
  ExpectViews(scratch() / "a.lcm", 7, 1.0);
  ASSERT_EQ(Run("import v --camera A --output b.lcm").exit_code, 0);
  EXPECT_TRUE(*ReadFileBytes(scratch() / "a.lcm", 1U << 24U) ==
              *ReadFileBytes(scratch() / "b.lcm", 1U << 24U));
  ASSERT_EQ(Run("import v --camera A --depth-scale 0.5 --output c.lcm").exit_code, 0);
  ExpectViews(scratch() / "c.lcm", 7, 0.5);
}

TEST_F(Import, FramesInAFolderInside) {
  fs::create_directories(scratch() / "v" / "rgbd-frames");
  WriteText(scratch() / "v" / "camera-intrinsics.txt", kIntrinsics);
  for (int i = 0; i < 3; ++i) {
    const fs::path base = scratch() / "v" / "rgbd-frames" / Format("frame-%06d", 100 + i);
    ASSERT_TRUE(WritePng(base.string() + ".depth.png", Depth(i)).ok());
    // A little off a rotation, as text rounds it.
    Eigen::Matrix4d matrix = ViewPose(i).matrix();
    matrix.topLeftCorner<3, 3>() *= 0.9995;
    WriteText(base.string() + ".pose.txt", MatrixText(matrix));
  }
  const ProgramOutput output = Run("import v --camera A --output a.lcm");
  ASSERT_EQ(output.exit_code, 0) << output.text;
  ExpectViews(scratch() / "a.lcm", 3, 1.0);
}

TEST_F(Import, BopSceneComesBackFromTheLog) {
  WriteBopScene(scratch() / "test" / "000003", 12);
  const ProgramOutput output = Run("import test --camera A --output a.lcm");
  ASSERT_EQ(output.exit_code, 0) << output.text;
  ExpectViews(scratch() / "a.lcm", 12, 0.1);
  WriteBopScene(scratch() / "test" / "000007", 2);
  ExpectRefused("import test --camera A --output b.lcm", "--scene");
  ExpectRefused("import test --camera A --scene 5 --output b.lcm", "instead of 5");
  ASSERT_EQ(Run("import test --camera A --scene 7 --output b.lcm").exit_code, 0);
  ExpectViews(scratch() / "b.lcm", 2, 0.1);
}

TEST_F(Import, BadViewFoldersAreRefused) {
  const fs::path folder = scratch() / "v";
  const std::string import = "import v --camera A --output a.lcm";
  ExpectRefused(import, "no folder v");
  fs::create_directories(folder);
  ExpectRefused(import, "no depth images");
  WriteViewFolder(folder, 3);
  ExpectRefused("import v --camera 'A B' --output a.lcm", "camera name \"A B\"");
  ExpectRefused("import v --output a.lcm", "--camera");
  ExpectRefused("import v --camera A --output none/a.lcm", "none/a.lcm");
  ExpectRefused("import v --camera A --view-interval 0.5 --output a.lcm", "view interval 0.5");
  ExpectRefused("import v --camera A --depth-scale -1 --output a.lcm", "depth scale -1");
  ExpectRefused("import v --camera A --scene 1 --output a.lcm", "--scene 1");
  ExpectRefused("import v --camera A --format bop --output a.lcm", "no BOP scene");

  const auto with = [&](const std::string& name, const std::string& text, const std::string& part) {
    const std::string good = *ReadFileBytes(folder / name, 1U << 20U);
    WriteText(folder / name, text);
    ExpectRefused(import, part);
    WriteText(folder / name, good);
  };
  with("Intrinsic.txt", "30 0 9.5 0 31 6.5", "6 numbers");
  with("Intrinsic.txt", "30 0 9.5 0 x 6.5 0 0 1", "4 numbers and then something else");
  with("Intrinsic.txt", "30 0 9.5 0 -31 6.5 0 0 1", "fy = -31");
  with("Intrinsic.txt", "1 0 0 0 0 1 0 0 0", "no matrix of intrinsics");
  with("world_T_camera_6.txt", "", "0 numbers");
  with("world_T_camera_6.txt", "1 0 0 0 0 1 0 0 0 0 1 nan 0 0 0 1", "world_T_camera_6.txt");
  with("world_T_camera_6.txt", "1 0 0 0 0 1 0 0 0 0 -1 0 0 0 0 1", "from a rotation");
  with("world_T_camera_6.txt", "2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1", "from a rotation");
  with("world_T_camera_6.txt", "1 0 0 0 0 1 0 0 0 0 1 0 1 1 1 1", "expected 0 0 0 1");
  with("world_T_camera_6.txt", "1 0 0 1e9 0 1 0 0 0 0 1 0 0 0 0 1", "expected metres");
  with("depth_6.png", "no picture", "depth_6.png is no PNG");

  const std::vector<uint8_t> rgb = *EncodePng(RgbImage{2, 1, {1, 2, 3, 4, 5, 6}});
  with("depth_6.png", std::string(rgb.begin(), rgb.end()), "expected a 16-bit grey PNG");
  const std::vector<uint8_t> small = *EncodePng(Depth(1, 10, 7));
  with("depth_6.png", std::string(small.begin(), small.end()), "expected 20 x 14 px");
  // All views of one size, but larger than a receiver takes.
  for (const auto& [width, height] : {std::pair{4097, 2}, {2, 4097}}) {
    WriteViewFolder(scratch() / "large", 1);
    ASSERT_TRUE(WritePng(scratch() / "large" / "depth_5.png", Depth(1, width, height)).ok());
    ExpectRefused("import large --camera A --output a.lcm", "at most 4096 px");
  }
  const std::vector<uint8_t> whole = *EncodePng(Depth(1));
  with("depth_6.png", std::string(whole.begin(), whole.end() - 40), "no sound PNG");
  fs::remove(folder / "world_T_camera_6.txt");
  ExpectRefused(import, "depth_6.png has no pose");
  fs::remove(folder / "Intrinsic.txt");
  ExpectRefused(import, "no intrinsics");
}

TEST_F(Import, BadBopScenesAreRefused) {
  const fs::path scene = scratch() / "s";
  const std::string import = "import s --camera A --output a.lcm";
  WriteBopScene(scene, 2);
  const std::string good = *ReadFileBytes(scene / "scene_camera.json", 1U << 20U);
  const auto replaced =
      [&](const std::string& from, const std::string& to, const std::string& part) {
        std::string text = good;
        const size_t at = text.find(from);
        ASSERT_NE(at, std::string::npos);
        text.replace(at, from.size(), to);
        WriteText(scene / "scene_camera.json", text);
        ExpectRefused(import, part);
      };
  replaced("{", "", "expected a JSON object");
  replaced("\"1\"", "\"one\"", "entry \"one\"");
  replaced("\"1\"", "\"3\"", "000003.png: no such file");
  replaced("cam_K", "cam_k", "image 1 has no cam_K");
  replaced("cam_R_w2c", "cam_R", "image 1 has no cam_R_w2c");
  replaced("cam_t_w2c", "cam_t", "image 1 has no cam_t_w2c");
  replaced("[30, ", "[", "bad cam_K");
  replaced("[30, ", "[null, ", "bad cam_K");
  replaced("[30, ", "[-30, ", "fx = -30");
  replaced("\"depth_scale\": 0.1", "\"depth_scale\": 0", "bad depth_scale");
  replaced(
      "\"cam_R_w2c\": [", "\"cam_R_w2c\": [2.0, 0, 0, 0, 2, 0, 0, 0, 2], \"x\": [", "rotation");
  for (const char* far : {"1.1e7", "-1e300"}) {
    replaced("\"cam_t_w2c\": [",
             Format("\"cam_t_w2c\": [0, %s, 0], \"x\": [", far),
             "expected millimetres");
  }
  WriteText(scene / "scene_camera.json", "[]");
  ExpectRefused(import, "expected a JSON object");
  WriteText(scene / "scene_camera.json", "{\"1\": 5}");
  ExpectRefused(import, "expected an object");
  WriteText(scene / "scene_camera.json", std::string(100'000, '['));
  ExpectRefused(import, "expected a JSON object");
}

TEST_F(Import, InfoTellsChannelsAndDamage) {
  WriteViewFolder(scratch() / "v", 3);
  ASSERT_EQ(Run("import v --camera A --output a.lcm").exit_code, 0);
  ProgramOutput output = Run("info a.lcm");
  EXPECT_EQ(output.exit_code, 0);
  for (const char* part : {"CAMERA_A ",
                           "images_t",
                           "CAMERA_A_TO_WORLD",
                           "rigid_transform_t",
                           "LOG_HEADER",
                           "damage: none"}) {
    EXPECT_NE(output.text.find(part), std::string::npos) << output.text;
  }
  std::string bytes = *ReadFileBytes(scratch() / "a.lcm", 1U << 24U);
  WriteText(scratch() / "cut.lcm", bytes.substr(0, bytes.size() - 10));
  output = Run("info cut.lcm");
  EXPECT_EQ(output.exit_code, 0);
  EXPECT_EQ(output.text.find("damage: none"), std::string::npos) << output.text;
  WriteText(scratch() / "no.lcm", "hello, this is no log at all, though it is long enough");
  ExpectRefused("info no.lcm", "no.lcm");
  ExpectRefused("info none.lcm", "none.lcm");
}

TEST_F(Import, SharedViewsImport) {
  const fs::path data = fs::path(VANTAGE_SOURCE_DIR) / ".." / "shared" / "data";
  if (!fs::exists(data)) GTEST_SKIP() << data << " is absent";
  const fs::path bunny = data / "bunny_turntable_36views";
  const Result<std::vector<RecordedView>> views = ListViewFolder(bunny, 1.0);
  ASSERT_TRUE(views.ok()) << views.error().message;
  EXPECT_EQ(views->size(), 36U);
  EXPECT_EQ((*views)[10].camera.fx, 542.0);
  const Result<LogImportSummary> summary =
      ImportViews(*views, {.camera = "A"}, scratch() / "bunny.lcm");
  ASSERT_TRUE(summary.ok()) << summary.error().message;
  EXPECT_EQ(summary->num_events, 1 + 36 * (1 + 81 + 1));
  const Result<std::vector<RecordedView>> room =
      ListViewFolder(data / "tsdf_fusion_rgbd_50frames", 1.0);
  ASSERT_TRUE(room.ok()) << room.error().message;
  EXPECT_EQ(room->size(), 50U);
  EXPECT_FALSE(ListViewFolder(data / "apc_shelf_binE_15views", 1.0).ok());
}

TEST_F(Import, PngComesBackAndFlippedBytesAreSurvived) {
  const fs::path file = scratch() / "x.png";
  const Gray16Image image = Depth(3, 33, 21);
  ASSERT_TRUE(WritePng(file, image).ok());
  const Result<Gray16Image> back = ReadPng16(file);
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(back->width, 33);
  EXPECT_EQ(back->height, 21);
  EXPECT_EQ(back->gray, image.gray);
  EXPECT_FALSE(EncodePng(Gray16Image{33, 21, {1, 2}}).ok());
  EXPECT_FALSE(EncodePng(RgbImage{0, 21, {}}).ok());
  EXPECT_FALSE(WritePng(scratch() / "none" / "x.png", image).ok());

  const std::string sound = *ReadFileBytes(file, 1U << 20U);
  Rng rng(4);
  for (size_t length = 0; length < sound.size(); length += 23) {
    WriteText(file, sound.substr(0, length));
    EXPECT_FALSE(ReadPng16(file).ok()) << length;
  }
  for (int i = 0; i < 200; ++i) {
    std::string flipped = sound;
    char& byte = flipped[rng.Below(static_cast<uint32_t>(sound.size()))];
    byte = static_cast<char>(byte ^ (1 << rng.Below(8)));
    WriteText(file, flipped);
    // Checksums find the flip in data that was read; what is found is never half a picture.
    const Result<Gray16Image> read = ReadPng16(file);
    if (read.ok()) {
      EXPECT_EQ(read->gray.size(), image.gray.size());
    }
  }
  EXPECT_EQ(ListTree(scratch()).size(), 1U);
}

}  // namespace
}  // namespace vantage
