// Runs vantage-handeye as its users do.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "bus/conversions.h"
#include "bus/event_log.h"
#include "bus/image_conversion.h"
#include "bus/message_check.h"
#include "common/format.h"
#include "common/rng.h"
#include "nodes/handeye_file.h"
#include "perception/calibration/calibration_target.h"
#include "tests/tools/run_program.h"
#include "tools/support/png_image.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

const fs::path kData = fs::path(VANTAGE_SOURCE_DIR) / "../shared/data/handeye";

Eigen::Vector3d NormalVector(double sigma, Rng& rng) {
  return sigma * Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal());
}

Pose MakePose(const Eigen::Vector3d& rotation_vector, const Eigen::Vector3d& translation) {
  Pose pose = Pose::Identity();
  pose.linear() = ExpSo3(rotation_vector).toRotationMatrix();
  pose.translation() = translation;
  return pose;
}

struct PosePair {
  Pose T_base_hand;
  Pose T_camera_target;
};

// Of an eye in hand, with noise.
std::vector<PosePair> Simulate(int num_views, double turn, const Pose& T_hand_camera) {
  Rng rng(5);
  const Pose T_base_target = MakePose({0.1, 3.0, -0.2}, {0.6, 0.1, 0.05});
  std::vector<PosePair> pairs;
  for (int i = 0; i < num_views; ++i) {
    const Pose B =
        MakePose(NormalVector(turn, rng), Eigen::Vector3d(0.0, 0.0, 0.5) + NormalVector(0.05, rng));
    const Pose A = T_base_target * B.inverse() * T_hand_camera.inverse();
    pairs.push_back({A, MakePose(NormalVector(0.001, rng), NormalVector(3e-4, rng)) * B});
  }
  return pairs;
}

std::string Fields(const Pose& pose) {
  const Eigen::Vector3d t = pose.translation();
  const Eigen::Quaterniond q(pose.linear());
  return Format(
      "%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g", t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z());
}

class HandEyeTool : public ToolTest {
 protected:
  HandEyeTool() : ToolTest("vantage-handeye") {}

  void WritePoses(const std::string& name, const std::vector<PosePair>& pairs) const {
    std::ofstream file(scratch() / name);
    file << "hand_x,hand_y,hand_z,hand_qw,hand_qx,hand_qy,hand_qz,"
            "camera_x,camera_y,camera_z,camera_qw,camera_qx,camera_qy,camera_qz\n";
    for (const PosePair& pair : pairs) {
      file << Fields(pair.T_base_hand) << "," << Fields(pair.T_camera_target) << "\n";
    }
  }
  void Write(const std::string& name, const std::string& text) const {
    std::ofstream(scratch() / name, std::ios::binary) << text;
  }
  // Exit code 1, no calibration, and the words in its refusal.
  void ExpectUnusable(const std::string& arguments, const std::string& words) const {
    const ProgramOutput output = Run("calibrate --setup eye-in-hand --output o " + arguments);
    EXPECT_EQ(output.exit_code, 1) << output.text;
    EXPECT_NE(output.text.find("refused: "), std::string::npos) << output.text;
    EXPECT_NE(output.text.find(words), std::string::npos) << words << "\n" << output.text;
    EXPECT_FALSE(fs::exists(scratch() / "o" / "handeye.toml"));
    EXPECT_TRUE(fs::exists(scratch() / "o" / "report.html"));
  }
};

const Pose kMount = MakePose({0.02, -0.03, 1.57}, {0.05, -0.03, 0.08});

TEST_F(HandEyeTool, CalibratesFromPoses) {
  WritePoses("a.csv", Simulate(25, 0.3, kMount));
  const ProgramOutput output =
      Run("calibrate --setup eye-in-hand --poses a.csv --camera FRONT --output o");
  ASSERT_EQ(output.exit_code, 0) << output.text;
  const Result<HandEyeFile> file = ReadHandEyeFile(scratch() / "o" / "handeye.toml");
  ASSERT_TRUE(file.ok()) << file.error().message;
  EXPECT_EQ(file->camera, "FRONT");
  EXPECT_LT((file->T_x.translation() - kMount.translation()).norm(), 5e-4);
  EXPECT_LT(
      GeodesicAngle(Eigen::Quaterniond(file->T_x.linear()), Eigen::Quaterniond(kMount.linear())),
      0.1 * kDegree);
  for (const char* name : {"residuals.csv", "residuals.svg", "report.html"}) {
    EXPECT_GT(fs::file_size(scratch() / "o" / name), 500U) << name;
  }
  const ProgramOutput again =
      Run("calibrate --setup eye-in-hand --poses a.csv --camera FRONT --output o");
  EXPECT_EQ(again.text, output.text);
}

TEST_F(HandEyeTool, NamesMistakesAndOutliers) {
  std::vector<PosePair> pairs = Simulate(25, 0.3, kMount);
  pairs[7].T_camera_target.translation().x() += 0.1;
  WritePoses("a.csv", pairs);
  const ProgramOutput output = Run("calibrate --setup eye-in-hand --poses a.csv");
  EXPECT_EQ(output.exit_code, 0) << output.text;
  EXPECT_NE(output.text.find("outliers            row 8\n"), std::string::npos) << output.text;
  std::vector<PosePair> inverted = pairs;
  for (PosePair& pair : inverted) pair.T_camera_target = pair.T_camera_target.inverse();
  WritePoses("a.csv", inverted);
  ExpectUnusable("--poses a.csv", "if the camera poses are inverted (T_target_camera was given");
  std::vector<PosePair> millimeters = pairs;
  for (PosePair& pair : millimeters) pair.T_base_hand.translation() *= 1e3;
  WritePoses("a.csv", millimeters);
  ExpectUnusable("--poses a.csv", "if the robot's translations are in millimeters");
}

TEST_F(HandEyeTool, RefusesMotionsThatFixNothing) {
  std::vector<PosePair> pairs = Simulate(12, 0.0, kMount);
  WritePoses("a.csv", pairs);
  ExpectUnusable("--poses a.csv", "add views");
  for (PosePair& pair : pairs) pair = pairs.front();
  WritePoses("a.csv", pairs);
  const ProgramOutput same = Run("calibrate --setup eye-in-hand --poses a.csv --output o");
  EXPECT_NE(same.exit_code, 0) << same.text;
  EXPECT_NE(same.text.find("the robot poses are all the same"), std::string::npos) << same.text;
  EXPECT_FALSE(fs::exists(scratch() / "o" / "handeye.toml"));
}

TEST_F(HandEyeTool, RefusesWhatItCannotRead) {
  WritePoses("two.csv", Simulate(2, 0.3, kMount));
  Write("empty.csv", "");
  Write("bomb.json", std::string(100'000, '['));
  Write("mirror.json",
        "[[[[1,0,0,0],[0,1,0,0],[0,0,-1,0],[0,0,0,1]],[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]]]");
  WritePoses("good.csv", Simulate(9, 0.3, kMount));
  const std::string poses = "calibrate --setup eye-in-hand --poses ";
  ExpectRefused(poses + "none.csv", "none.csv: no such file");
  ExpectRefused(poses + "empty.csv", "empty.csv is empty");
  ExpectRefused(poses + "bomb.json", "nested deeper");
  ExpectRefused(poses + "two.csv", "expected at least 3");
  ExpectRefused(poses + "mirror.json",
                "pair 1: pose of the robot: rotation matrix has determinant -1");
  ExpectRefused(poses + "good.csv --log a.lcm", "expected one of --poses");
  ExpectRefused(poses + "good.csv --estimate distortion", "show in images alone");
  ExpectRefused(poses + "good.csv --estimate time-offset", "expected --log");
  ExpectRefused(poses + "good.csv --robot-noise 0 0", "--robot-noise, expected");
  ExpectRefused(poses + "good.csv --robot-noise nan 1", "--robot-noise");
  ExpectRefused(poses + "good.csv --detections X", "together");
  ExpectRefused(poses + "good.csv --columns 5", "expected --target KIND");
  ExpectRefused("calibrate --poses good.csv", "--setup");
  ExpectRefused("calibrate --setup beside --poses good.csv", "--setup");
  ExpectRefused("calibrate --setup eye-in-hand --images none --target apriltags",
                "expected --columns");
  ExpectRefused(
      "calibrate --setup eye-in-hand --log none.lcm --target apriltags --columns 3 --rows 3 "
      "--size 0.03",
      "none.lcm");
  ExpectRefused("suggest none.toml --hand 0 0 0 1 0 0 0", "none.toml is not there");
}

TEST_F(HandEyeTool, DrawsTargets) {
  const std::string tags =
      "draw-target --target apriltags --columns 2 --rows 2 --size 0.03 --gap 0.01";
  EXPECT_EQ(Run(tags + " --output a.svg").exit_code, 0);
  EXPECT_EQ(Run(tags + " --output a.png --dpi 150").exit_code, 0);
  std::ifstream svg(scratch() / "a.svg");
  std::string text;
  std::getline(svg, text);
  EXPECT_NE(text.find("mm\" height="), std::string::npos) << text.substr(0, 200);
  ExpectRefused(tags + " --output a.pdf", "expected FILE.svg or FILE.png");
  ExpectRefused(tags + " --family tag99 --output b.png", "tag99");
  ExpectRefused("draw-target --output a.svg", "expected --target");
}

// Photographs of a board of tags: the target drawn where a pinhole camera sees it.
class Photographer {
 public:
  explicit Photographer(const CalibrationTarget& target)
      : size_(target.BoardSize()), board_(*DrawTarget(target, kScale)) {}

  GrayImage Take(const CameraModel& camera, const Pose& T_camera_target) const {
    GrayImage image(camera.width, camera.height, 128);
    const Pose T_target_camera = T_camera_target.inverse();
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        double sum = 0.0;
        for (int k = 0; k < 9; ++k) {
          sum += Ray(T_target_camera,
                     camera.Unproject(u + (k % 3 - 1) / 3.0, v + (k / 3 - 1) / 3.0, 1.0));
        }
        image.at(u, v) = static_cast<uint8_t>(sum / 9.0);
      }
    }
    return image;
  }

 private:
  static constexpr double kScale = 4000.0;  // px/m

  [[nodiscard]] double Ray(const Pose& T_target_camera, const Eigen::Vector3d& ray) const {
    const Eigen::Vector3d eye = T_target_camera.translation();
    const Eigen::Vector3d direction = T_target_camera.linear() * ray;
    const Eigen::Vector3d p = eye - eye.z() / direction.z() * direction;
    const int u = static_cast<int>(std::floor((p.x() + 0.5 * size_.x()) * kScale));
    const int v = static_cast<int>(std::floor((p.y() + 0.5 * size_.y()) * kScale));
    const bool inside = u >= 0 && v >= 0 && u < board_.width && v < board_.height;
    return inside ? board_.at(u, v) : 128.0;
  }

  Eigen::Vector2d size_;
  GrayImage board_;
};

const CalibrationTarget kBoard{.columns = 3, .rows = 3, .size = 0.04, .gap = 0.01};
constexpr const char* kBoardOptions =
    " --target apriltags --columns 3 --rows 3 --size 0.04 --gap 0.01";
const CameraModel kCamera{
    .width = 480, .height = 360, .fx = 430.0, .fy = 430.0, .cx = 239.5, .cy = 179.5};

constexpr int64_t kStart = 1'700'000'000'000'000;  // us

// A log of a hand that goes from pose to pose and rests for a second at each.
void WriteLog(const fs::path& file, const std::vector<PosePair>& pairs) {
  const Photographer photographer(kBoard);
  auto writer = EventLogWriter::Create(file);
  ASSERT_TRUE(writer.ok());
  const auto write = [&](int64_t utime, const std::string& channel, const auto& message) {
    ASSERT_TRUE((*writer)->Write(utime, channel, Encode(message)).ok());
  };
  CameraIdentity identity;
  identity.name = "FRONT";
  identity.registered = true;
  write(kStart, "CAMERA_FRONT_INFO", CameraToMessage(kCamera, identity, kStart, 0));
  for (size_t i = 0; i < pairs.size(); ++i) {
    const int64_t arrival = kStart + static_cast<int64_t>(i) * 2'000'000;
    for (int64_t t = 0; t <= 1'000'000; t += 50'000) {
      write(arrival + t, "HAND_TO_BASE", PoseToMessage(pairs[i].T_base_hand, arrival + t));
    }
    const GrayImage gray = photographer.Take(kCamera, pairs[i].T_camera_target);
    image_t image{};
    image.utime = arrival + 500'000;
    image.width = image.row_stride = gray.width;
    image.height = gray.height;
    image.pixelformat = image_t::PIXEL_FORMAT_GRAY;
    image.data = gray.pixels;
    image.size = static_cast<int32_t>(gray.pixels.size());
    images_t images{};
    images.utime = image.utime;
    AppendImage(images_t::LEFT, image, &images);
    images.n_images = 1;
    write(image.utime, "CAMERA_FRONT", images);
  }
  ASSERT_TRUE((*writer)->Close().ok());
}

TEST_F(HandEyeTool, CalibratesFromALog) {
  WriteLog(scratch() / "a.lcm", Simulate(10, 0.25, kMount));
  const std::string arguments =
      std::string("calibrate --setup eye-in-hand --camera FRONT --log a.lcm") + kBoardOptions;
  const ProgramOutput output = Run(arguments + " --output o");
  ASSERT_EQ(output.exit_code, 0) << output.text;
  const Result<HandEyeFile> file = ReadHandEyeFile(scratch() / "o" / "handeye.toml");
  ASSERT_TRUE(file.ok()) << file.error().message;
  EXPECT_GE(file->num_views, 8) << output.text;
  EXPECT_EQ(file->intrinsics, kCamera);
  EXPECT_LT((file->T_x.translation() - kMount.translation()).norm(), 0.002) << output.text;
  const ProgramOutput next = Run("suggest o/handeye.toml --hand " + [&] {
    std::string text = Fields(Simulate(1, 0.0, kMount).front().T_base_hand);
    for (char& c : text) c = c == ',' ? ' ' : c;
    return text;
  }() + kBoardOptions);
  EXPECT_EQ(next.exit_code, 0) << next.text;
  EXPECT_NE(next.text.find("after a view from there"), std::string::npos) << next.text;

  ExpectRefused(arguments + " --hand-channel ARM", "no poses of the hand");
  ExpectRefused(
      "calibrate --setup eye-in-hand --camera SIDE --log a.lcm --target apriltags --columns 3 "
      "--rows 3 --size 0.04",
      "no intrinsics on CAMERA_SIDE_INFO");
  ExpectRefused(arguments + " --first-id 100", "There are tags with other ids: 0, 1, 2");
  ExpectRefused(arguments + " --family tag16h5 --first-id 9", "seen in none of 10 images");
  std::ifstream stream(scratch() / "a.lcm", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  Write("cut.lcm", bytes.substr(0, bytes.size() / 2));
  const ProgramOutput cut = Run(
      std::string("calibrate --setup eye-in-hand --camera FRONT --log cut.lcm") + kBoardOptions);
  EXPECT_NE(cut.text.find("the log is damaged"), std::string::npos) << cut.text;
}

TEST_F(HandEyeTool, CalibratesFromDetections) {
  const std::vector<PosePair> pairs = Simulate(12, 0.3, kMount);
  auto writer = EventLogWriter::Create(scratch() / "a.lcm");
  ASSERT_TRUE(writer.ok());
  for (size_t i = 0; i < pairs.size(); ++i) {
    const int64_t arrival = kStart + static_cast<int64_t>(i) * 2'000'000;
    for (int64_t t = 0; t <= 1'000'000; t += 50'000) {
      const auto bytes = Encode(PoseToMessage(pairs[i].T_base_hand, arrival + t));
      ASSERT_TRUE((*writer)->Write(arrival + t, "HAND_TO_BASE", bytes).ok());
    }
    Detection detection;
    detection.model_id = "mug";
    detection.T_camera_object = pairs[i].T_camera_target;
    detection.verification_score = 0.8;
    Detection worse = detection;
    worse.T_camera_object.translation().x() += 0.1;
    worse.verification_score = 0.5;
    DetectionSet set;
    set.utime = arrival + 500'000;
    set.camera = "FRONT";
    set.estimator = "ppf";
    set.detections = {worse, detection};
    const auto bytes = Encode(DetectionsToMessage(set));
    ASSERT_TRUE((*writer)->Write(set.utime, "DETECTIONS_PPF", bytes).ok());
  }
  ASSERT_TRUE((*writer)->Close().ok());
  const std::string models = VANTAGE_SOURCE_DIR "/models/";
  const std::string arguments =
      "calibrate --setup eye-in-hand --camera FRONT --log a.lcm --detections DETECTIONS_PPF "
      "--model ";
  const ProgramOutput output = Run(arguments + models + "mug --output o");
  ASSERT_EQ(output.exit_code, 0) << output.text;
  const Result<HandEyeFile> file = ReadHandEyeFile(scratch() / "o" / "handeye.toml");
  ASSERT_TRUE(file.ok()) << file.error().message;
  EXPECT_EQ(file->num_views, 12);
  EXPECT_LT((file->T_x.translation() - kMount.translation()).norm(), 0.001) << output.text;
  ExpectRefused(arguments + models + "duck", "holds a detection of duck");
  ExpectRefused(arguments + "none", "none");
}

TEST_F(HandEyeTool, RefusesImagesThatAreNone) {
  Write("camera.toml",
        "width_px = 480\nheight_px = 360\nfx_px = 430\nfy_px = 430\ncx_px = 240\ncy_px = 180\n");
  Write("poses.csv", "image,hand_x,hand_y,hand_z,hand_rx,hand_ry,hand_rz\na.png,1,2,3,0,0,0\n");
  const std::string arguments =
      std::string("calibrate --setup eye-in-hand --images . --intrinsics camera.toml") +
      kBoardOptions;
  ExpectRefused(arguments, "a.png: no such file");
  RgbImage black{480, 360, std::vector<uint8_t>(size_t{480} * 360 * 3, 0)};
  ASSERT_TRUE(WritePng(scratch() / "a.png", black).ok());
  ExpectRefused(arguments, "seen in none of 1 images");
  fs::resize_file(scratch() / "a.png", fs::file_size(scratch() / "a.png") - 20);
  ExpectRefused(arguments, "is cut off");
  black = {100, 100, std::vector<uint8_t>(30'000, 0)};
  ASSERT_TRUE(WritePng(scratch() / "a.png", black).ok());
  ExpectRefused(arguments, "has 100 x 100 px, expected 480 x 360 px");
}

// Published: translation (0.659, -0.249, 0.830) m, rounded to 1 mm.
TEST_F(HandEyeTool, CalibratesMoveItsSamples) {
  const fs::path file = kData / "moveit_calibration/pose_samples.json";
  if (!fs::exists(file)) GTEST_SKIP() << file << " is not there";
  const ProgramOutput output =
      Run("calibrate --setup eye-to-hand --output o --poses '" + file.string() + "'");
  ASSERT_EQ(output.exit_code, 0) << output.text;
  EXPECT_EQ(output.text.find("warning"), std::string::npos) << output.text;
  const Result<HandEyeFile> found = ReadHandEyeFile(scratch() / "o" / "handeye.toml");
  ASSERT_TRUE(found.ok());
  EXPECT_LT((found->T_x.translation() - Eigen::Vector3d(0.659, -0.249, 0.830)).norm(), 0.0015);
  const ProgramOutput wrong = Run("calibrate --setup eye-in-hand --poses '" + file.string() + "'");
  EXPECT_EQ(wrong.exit_code, 1) << wrong.text;
  EXPECT_NE(wrong.text.find("--setup eye-to-hand"), std::string::npos) << wrong.text;
}

std::string VispArguments(const fs::path& folder) {
  return "--image-pattern franka_image-%d.png --pose-pattern franka_pose_rPe_%d.yaml --intrinsics "
         "'" +
         (folder / "franka_camera.xml").string() + "' --images '" + folder.string() +
         "' --output o ";
}

TEST_F(HandEyeTool, CalibratesViSPsImages) {
  const fs::path in_hand = kData / "visp_franka_eye_in_hand";
  if (!fs::exists(in_hand)) GTEST_SKIP() << in_hand << " is not there";
  const ProgramOutput board =
      Run("calibrate --setup eye-in-hand --target chessboard --columns 9 --rows 6 "
          "--size 0.0236 " +
          VispArguments(in_hand));
  ASSERT_EQ(board.exit_code, 0) << board.text;
  Result<HandEyeFile> found = ReadHandEyeFile(scratch() / "o" / "handeye.toml");
  ASSERT_TRUE(found.ok());
  EXPECT_LT((found->T_x.translation() - Eigen::Vector3d(0.05772, -0.03392, -0.04228)).norm(),
            0.001);
  const ProgramOutput tag =
      Run("calibrate --setup eye-to-hand --target apriltags --columns 1 --rows 1 --size 0.048 "
          "--gap 0.01 "
          "--first-id 10 " +
          VispArguments(kData / "visp_franka_eye_to_hand"));
  ASSERT_EQ(tag.exit_code, 0) << tag.text;
  found = ReadHandEyeFile(scratch() / "o" / "handeye.toml");
  ASSERT_TRUE(found.ok());
  EXPECT_LT((found->T_x.translation() - Eigen::Vector3d(0.95404, -0.05124, 0.47622)).norm(), 0.003);
}

}  // namespace
}  // namespace vantage
