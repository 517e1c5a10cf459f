// vantage-log export, run as its users do, on a log made here: what comes out is what went in.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/conversions.h"
#include "bus/event_log.h"
#include "bus/image_conversion.h"
#include "bus/message_check.h"
#include "common/format.h"
#include "common/rng.h"
#include "perception/model/file_bytes.h"
#include "tests/tools/run_program.h"
#include "tools/support/log_config.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 24;
constexpr int kHeight = 18;
constexpr int kViews = 4;
constexpr int64_t kStart = 1'700'000'000'000'000;  // us

std::vector<uint16_t> Depth(int view) {
  Rng rng(static_cast<uint64_t>(view));
  std::vector<uint16_t> depth;
  for (int i = 0; i < kWidth * kHeight; ++i) {
    depth.push_back(static_cast<uint16_t>(rng.Below(5) == 0 ? 0 : 1 + rng.Below(65535)));
  }
  return depth;
}

Pose ViewPose(int view) {
  Rng rng(static_cast<uint64_t>(view) + 50);
  Pose pose = Pose::Identity();
  pose.linear() = rng.Rotation().toRotationMatrix();
  pose.translation() = rng.UnitVector();
  return pose;
}

std::string Text(const fs::path& file) {
  const Result<std::string> text = ReadFileBytes(file, 1U << 26U);
  EXPECT_TRUE(text.ok()) << file;
  return text ? *text : "";
}

size_t Lines(const fs::path& file) {
  const std::string text = Text(file);
  return static_cast<size_t>(std::count(text.begin(), text.end(), '\n'));
}

class Export : public ToolTest {
 protected:
  Export() : ToolTest("vantage-log") {}

  // Views with registered color, one of which has no pose; a foreign and a malformed message.
  void SetUp() override {
    ToolTest::SetUp();
    auto made = EventLogWriter::Create(scratch() / "run.lcm");
    ASSERT_TRUE(made.ok());
    writer_ = std::move(made).value();
    const CameraModel camera{
        .width = kWidth, .height = kHeight, .fx = 30.0, .fy = 31.0, .cx = 11.5, .cy = 8.5};
    Put(0,
        "CAMERA_A_INFO",
        Encode(CameraToMessage(
            camera,
            {.name = "A", .serial = "", .frame = "A", .registered = true, .calibration_id = "x"},
            kStart,
            0)));
    for (int i = 0; i < kViews; ++i) WriteView(i, true);
    WriteView(kViews, false);
    Put(9'000'000, "FOREIGN", std::vector<std::byte>(20, std::byte{7}));
    Put(9'000'001,
        "CAMERA_A",
        std::vector<std::byte>(images_bytes_.begin(), images_bytes_.end() - 9));
    ASSERT_TRUE(writer_->Close().ok());
  }

 private:
  void Put(int64_t after, const std::string& channel, const std::vector<std::byte>& bytes) {
    ASSERT_TRUE(writer_->Write(kStart + after, channel, bytes).ok());
  }
  void WriteView(int view, bool has_pose) {
    const int64_t after = 1'000'000 * (view + 1);
    images_t images = DepthToMessage(
        kWidth, kHeight, Depth(view), kStart + after, view, "", DepthCompression::kVdc);
    image_t color{};
    color.utime = images.utime;
    color.width = kWidth;
    color.height = kHeight;
    color.row_stride = 3 * kWidth;
    color.pixelformat = image_t::PIXEL_FORMAT_RGB;
    color.data.assign(size_t{3} * kWidth * kHeight, static_cast<uint8_t>(10 * view + 1));
    AppendImage(images_t::LEFT, color, &images);
    images_bytes_ = Encode(images);
    // The pose comes before and behind the image, which is recorded late.
    if (has_pose) Put(after - 10'000, "CAMERA_A_TO_WORLD", PoseAt(view, after - 10'000));
    if (has_pose) Put(after + 10'000, "CAMERA_A_TO_WORLD", PoseAt(view, after + 10'000));
    Put(after + 20'000, "CAMERA_A", images_bytes_);
  }
  static std::vector<std::byte> PoseAt(int view, int64_t after) {
    return Encode(PoseToMessage(ViewPose(view), kStart + after));
  }

  std::unique_ptr<EventLogWriter> writer_;
  std::vector<std::byte> images_bytes_;
};

TEST_F(Export, ImagesAreReadBackByImport) {
  const ProgramOutput exported = Run("export run.lcm --output out --format images");
  ASSERT_EQ(exported.exit_code, 0) << exported.text;
  EXPECT_NE(exported.text.find("1 depth images without a pose"), std::string::npos)
      << exported.text;
  EXPECT_EQ(Lines(scratch() / "out/CAMERA_A/views.csv"), 1U + kViews + 1U);
  EXPECT_TRUE(fs::exists(scratch() / "out/CAMERA_A/color_000003.png"));
  ASSERT_TRUE(WriteFileBytes(scratch() / "a.toml", "[models]\nfolder = \"m\"\n").ok());
  for (const std::string compression : {"vdc", "zlib", "raw"}) {
    const ProgramOutput imported = Run("import out --camera B --config a.toml --output " +
                                       compression + ".lcm --compression " + compression);
    ASSERT_EQ(imported.exit_code, 0) << imported.text;
    Result<std::unique_ptr<EventLogReader>> reader =
        EventLogReader::Open(scratch() / (compression + ".lcm"));
    ASSERT_TRUE(reader.ok());
    int view = 0;
    std::optional<Pose> pose;
    while (const std::optional<LogEvent> event = (*reader)->Next()) {
      if (event->channel == "CAMERA_B_TO_WORLD") {
        pose = *PoseFromMessage(*DecodeChecked<rigid_transform_t>(event->data));
      }
      if (event->channel == "CAMERA_B_INFO") {
        const auto camera = CameraFromMessage(*DecodeChecked<camera_info_t>(event->data));
        ASSERT_TRUE(camera.ok());
        EXPECT_EQ(camera->fy, 31.0);
        EXPECT_EQ(camera->cx, 11.5);
      }
      if (event->channel != "CAMERA_B") continue;
      const Result<images_t> images = DecodeChecked<images_t>(event->data);
      ASSERT_TRUE(images.ok());
      const images_t expected = DepthToMessage(
          kWidth, kHeight, Depth(view), images->utime, view, "", DepthCompression::kNone);
      const Result<DepthFrame> frame = DepthFrameFromMessage(*images);
      const Result<DepthFrame> original = DepthFrameFromMessage(expected);
      ASSERT_TRUE(frame.ok() && original.ok());
      EXPECT_EQ(std::memcmp(frame->image.depth.data(),
                            original->image.depth.data(),
                            sizeof(float) * original->image.depth.size()),
                0);
      ASSERT_TRUE(pose.has_value());
      EXPECT_TRUE(pose->isApprox(ViewPose(view), 1e-12));
      ++view;
    }
    EXPECT_EQ(view, kViews);
    EXPECT_TRUE(OpenConfig("", (scratch() / (compression + ".lcm")).string()).ok());
  }
}

TEST_F(Export, TablesHaveALineForEachMessage) {
  const ProgramOutput exported = Run("export run.lcm --output out --format csv");
  ASSERT_EQ(exported.exit_code, 0) << exported.text;
  EXPECT_NE(exported.text.find("1 messages of an unknown type on FOREIGN"), std::string::npos);
  EXPECT_NE(exported.text.find("1 malformed messages"), std::string::npos) << exported.text;
  EXPECT_EQ(Lines(scratch() / "out/CAMERA_A_TO_WORLD.csv"), 1U + 2U * kViews);
  EXPECT_EQ(Lines(scratch() / "out/CAMERA_A.csv"), 1U + kViews + 1U);
  EXPECT_EQ(Lines(scratch() / "out/CAMERA_A.images.csv"), 1U + 2U * (kViews + 1U));
  const std::string poses = Text(scratch() / "out/CAMERA_A_TO_WORLD.csv");
  const std::string head = "event,event_utime_us,utime,trans[0],trans[1],trans[2],quat[0],quat[1]";
  EXPECT_EQ(poses.substr(0, head.size()), head);
  const std::string images = Text(scratch() / "out/CAMERA_A.images.csv");
  EXPECT_EQ(images.substr(0, 20), "event,images,utime,w");
  EXPECT_EQ(images.find(",data"), std::string::npos);
  // Every line has as many fields as the head.
  for (const auto& entry : fs::directory_iterator(scratch() / "out")) {
    const std::string text = Text(entry.path());
    std::optional<long> commas;
    for (size_t at = 0; at < text.size(); at = text.find('\n', at) + 1) {
      const std::string line = text.substr(at, text.find('\n', at) - at);
      const long count = std::count(line.begin(), line.end(), ',');
      EXPECT_EQ(count, commas.value_or(count)) << entry.path() << ": " << line;
      commas = count;
    }
  }
}

TEST_F(Export, CloudsHaveEveryPointInTheWorld) {
  size_t num_points = 0;
  for (int i = 0; i < kViews; ++i) {
    for (const uint16_t millimetres : Depth(i)) num_points += millimetres != 0 ? 1U : 0U;
  }
  ASSERT_EQ(Run("export run.lcm --output one --format ply --merge").exit_code, 0);
  ASSERT_EQ(Run("export run.lcm --output all --format ply").exit_code, 0);
  const std::string merged = Text(scratch() / "one/CAMERA_A.ply");
  EXPECT_NE(merged.find(Format("element vertex %zu\n", num_points)), std::string::npos);
  const size_t start = merged.find("end_header\n") + 11;
  EXPECT_EQ(merged.size() - start, 15 * num_points);
  std::string views;
  for (int i = 0; i < kViews; ++i) {
    const std::string view = Text(scratch() / Format("all/CAMERA_A/view_%06d.ply", i));
    views += view.substr(view.find("end_header\n") + 11);
  }
  EXPECT_EQ(merged.substr(start), views);
  // The first point, by hand.
  const std::vector<uint16_t> depth = Depth(0);
  size_t i = 0;
  while (depth[i] == 0) ++i;
  const double z = 0.001 * depth[i];
  const Eigen::Vector3d p_camera((static_cast<double>(i % kWidth) - 11.5) / 30.0 * z,
                                 (static_cast<double>(i / kWidth) - 8.5) / 31.0 * z,
                                 z);
  Eigen::Vector3f point;
  std::memcpy(point.data(), merged.data() + start, 12);
  EXPECT_TRUE(point.isApprox((ViewPose(0) * p_camera).cast<float>(), 1e-5F));
  EXPECT_EQ(merged[start + 12], 1);
}

TEST_F(Export, AnIndependentReaderFindsTheMcapSound) {
  ASSERT_EQ(Run("export run.lcm --output run.mcap --format mcap").exit_code, 0);
  const std::string check = std::string(VANTAGE_SOURCE_DIR) + "/tests/tools/mcap_check.py";
  const fs::path report = scratch() / "report.txt";
  const auto run = [&](const fs::path& file) {
    const std::string command =
        "python3 '" + check + "' '" + file.string() + "' >'" + report.string() + "' 2>&1";
    return std::system(command.c_str());
  };
  ASSERT_EQ(run(scratch() / "run.mcap"), 0) << Text(report);
  const std::string said = Text(report);
  EXPECT_NE(said.find("/CAMERA_A/depth foxglove.RawImage 5\n"), std::string::npos) << said;
  EXPECT_NE(said.find("/CAMERA_A/color foxglove.RawImage 5\n"), std::string::npos) << said;
  EXPECT_NE(said.find("/CAMERA_A/calibration foxglove.CameraCalibration 1\n"), std::string::npos);
  EXPECT_NE(said.find("/tf foxglove.FrameTransform 8\n"), std::string::npos) << said;
  EXPECT_NE(said.find("/FOREIGN - 1\n"), std::string::npos) << said;
  // It notices any byte that is changed.
  const std::string good = Text(scratch() / "run.mcap");
  Rng rng(3);
  for (int i = 0; i < 10; ++i) {
    std::string bad = good;
    const size_t at = rng.Below(static_cast<uint32_t>(bad.size()));
    bad[at] = static_cast<char>(bad[at] ^ 0x10);
    ASSERT_TRUE(WriteFileBytes(scratch() / "bad.mcap", bad).ok());
    EXPECT_NE(run(scratch() / "bad.mcap"), 0) << "byte " << at;
  }
}

TEST_F(Export, StretchesAndChannels) {
  ASSERT_EQ(Run("export run.lcm -o a --format images --from 1.5 --to 3.5").exit_code, 0);
  EXPECT_EQ(Lines(scratch() / "a/CAMERA_A/views.csv"), 3U);
  ASSERT_EQ(Run("export run.lcm -o b --format csv --channels 'CAMERA_.*_INFO'").exit_code, 0);
  EXPECT_EQ(ListTree(scratch() / "b").size(), 1U);
}

TEST_F(Export, ADamagedLogGivesWhatIsWhole) {
  std::string text = Text(scratch() / "run.lcm");
  text.resize(text.size() / 2);
  ASSERT_TRUE(WriteFileBytes(scratch() / "cut.lcm", text).ok());
  const ProgramOutput exported = Run("export cut.lcm --output out --format csv");
  EXPECT_EQ(exported.exit_code, 0);
  EXPECT_NE(exported.text.find("cut.lcm is damaged"), std::string::npos) << exported.text;
}

TEST_F(Export, BadInputIsOneSentence) {
  ASSERT_TRUE(WriteFileBytes(scratch() / "noise.lcm", std::string(5000, 'x')).ok());
  fs::create_directory(scratch() / "taken");
  ASSERT_TRUE(WriteFileBytes(scratch() / "taken/file", "x").ok());
  for (const std::string format : {"images", "csv", "ply", "mcap"}) {
    const std::string rest = " --format " + format;
    ExpectRefused("export none.lcm -o x" + rest, "none.lcm");
    ExpectRefused("export noise.lcm -o x" + rest, "noise.lcm");
    ExpectRefused("export run.lcm -o taken" + rest, "taken exists");
    ExpectRefused("export run.lcm -o nowhere/x" + rest, "nowhere/x");
    ExpectRefused("export run.lcm -o x --channels '['" + rest, "[");
    ExpectRefused("export run.lcm -o x --channels NONE" + rest, "NONE");
    ExpectRefused("export run.lcm -o x --from 2 --to 1" + rest, "--from 2 is not before --to 1");
    ExpectRefused("export run.lcm -o x --from noon" + rest, "noon");
  }
  ExpectRefused("export run.lcm -o x --format pdf", "pdf");
  ExpectRefused("export run.lcm -o x --format csv --merge", "--merge");
  ExpectRefused("export run.lcm -o x --format images --channels FOREIGN", "no images");
  ExpectRefused("import nowhere --camera A --output x.lcm", "nowhere");
  ExpectRefused("import taken --camera A --output x.lcm --compression jpeg", "jpeg");
  ExpectRefused("import taken --camera A --output x.lcm --config none.toml", "none.toml");
}

}  // namespace
}  // namespace vantage
