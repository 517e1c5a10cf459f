#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "common/format.h"
#include "tests/tools/run_program.h"
#include "tools/handeye/gray_image_file.h"
#include "tools/handeye/image_folder.h"
#include "tools/handeye/intrinsics_file.h"
#include "tools/handeye/pose_file.h"
#include "tools/support/png_image.h"

namespace vantage {
namespace {

class HandEyeFiles : public ScratchTest {
 protected:
  std::string Write(const std::string& name, const std::string& text) {
    std::ofstream(scratch() / name, std::ios::binary) << text;
    return (scratch() / name).string();
  }
  // The error of a file with this text; empty where there is none.
  std::string Refusal(const std::string& name, const std::string& text) {
    const Result<std::vector<RawView>> views = ReadPoseFile(Write(name, text));
    return views ? "" : views.error().message;
  }
  void ExpectRefusal(const std::string& name, const std::string& text, const std::string& words) {
    const std::string refusal = Refusal(name, text);
    EXPECT_NE(refusal.find(words), std::string::npos) << words << ": " << refusal;
    EXPECT_NE(refusal.find(name), std::string::npos) << refusal;
  }
};

constexpr const char* kHeader =
    "name,hand_x,hand_y,hand_z,hand_qw,hand_qx,hand_qy,hand_qz,camera_rx,camera_ry,camera_rz,"
    "camera_x,camera_y,camera_z\n";

TEST_F(HandEyeFiles, CsvInAnyOrderOfColumns) {
  const auto views = ReadPoseFile(Write(
      "a.csv",
      std::string("# made by hand\n\n") + kHeader +
          "\"a, b\",1,2,3,1,0,0,0,0.1,-0.2,3e-1,4,5,+6\nsecond,1,2,3,0,1,0,0,0,0,0,0,0,1\r\n"));
  ASSERT_TRUE(views.ok()) << views.error().message;
  ASSERT_EQ(views->size(), 2U);
  const RawView& view = views->front();
  EXPECT_EQ(view.name, "a, b");
  EXPECT_EQ(view.hand.translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(view.hand.kind, RawPose::Rotation::kQuaternion);
  EXPECT_EQ(view.hand.rotation[0], 1.0);
  EXPECT_EQ(view.camera.kind, RawPose::Rotation::kRotationVector);
  EXPECT_EQ(view.camera.rotation[1], -0.2);
  EXPECT_EQ(view.camera.translation, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(views->back().name, "second");
}

TEST_F(HandEyeFiles, WhatIsWrongInACsvIsNamed) {
  const std::string row = "a,1,2,3,1,0,0,0,0,0,0,4,5,6\n";
  const std::string header = kHeader;
  EXPECT_EQ(Refusal("a.csv", header + row), "");
  ExpectRefusal("a.csv", "", "is empty");
  ExpectRefusal("a.csv", header, "holds no poses");
  ExpectRefusal("a.csv", header + "a,1,2\n", "a.csv:2 has 3 fields, expected 14");
  ExpectRefusal(
      "a.csv", header + row + "a,1,2,3,nan,0,0,0,0,0,0,4,5,6\n", "a.csv:3: hand_qw = 'nan'");
  ExpectRefusal("a.csv", header + "a,1,2,3,1,0,0,0,0,0,0,4,5,six\n", "camera_z = 'six'");
  ExpectRefusal("a.csv", header + "a,1,2,3,1,0,0,0,0,0,0,4,5,1e999\n", "camera_z");
  ExpectRefusal("a.csv", "x,y,z\n1,2,3\n", "lacks columns of the hand poses");
  ExpectRefusal("a.csv", "mood," + header + "1," + row, "'mood' that has no meaning");
  ExpectRefusal("a.csv", "name," + header + "1," + row, "'name' twice");
  ExpectRefusal("a.csv", "utime," + header + "-1," + row, "utime = -1");
  ExpectRefusal("a.txt", header + row, "no known format");
  EXPECT_NE(ReadPoseFile(scratch() / "none.csv").error().message.find("no such file"),
            std::string::npos);
}

std::string MatrixColumns(const std::string& prefix) {
  std::string text;
  for (int i = 0; i < 16; ++i)
    text += Format("%s%s_m%d%d", i == 0 ? "" : ",", prefix.c_str(), i / 4, i % 4);
  return text;
}

TEST_F(HandEyeFiles, CsvOfMatrices) {
  const std::string header = MatrixColumns("hand") + "," + MatrixColumns("camera") + "\n";
  const std::string unit = "1,0,0,7,0,1,0,8,0,0,1,9,0,0,0,1";
  const auto views = ReadPoseFile(Write("m.csv", header + unit + "," + unit + "\n"));
  ASSERT_TRUE(views.ok()) << views.error().message;
  EXPECT_EQ(views->front().camera.translation, Eigen::Vector3d(7, 8, 9));
  ExpectRefusal(
      "m.csv", header + unit + ",1,0,0,7,0,1,0,8,0,0,1,9,0,0,5,1\n", "the last one 0 0 0 1");
}

TEST_F(HandEyeFiles, JsonOfOurOwn) {
  const std::string hand = R"({"position_m": [1, 2, 3], "quaternion_wxyz": [1, 0, 0, 0]})";
  const std::string camera = R"({"position_m": [4, 5, 6], "rotation_vector_rad": [0.1, 0, 0]})";
  const auto file = [&](const std::string& a, const std::string& b) {
    return R"({"views": [{"name": "v", "utime": 5, "hand": )" + a + R"(, "camera": )" + b + "}]}";
  };
  const auto views = ReadPoseFile(Write("a.json", file(hand, camera)));
  ASSERT_TRUE(views.ok()) << views.error().message;
  EXPECT_EQ(views->front().name, "v");
  EXPECT_EQ(views->front().utime, 5);
  EXPECT_EQ(views->front().camera.rotation[0], 0.1);
  ExpectRefusal(
      "a.json", file(hand, R"({"position_m": [4, 5, 6]})"), "[0]: camera: expected position_m");
  ExpectRefusal("a.json", file(hand, R"({"position": [4, 5, 6]})"), "unknown field 'position'");
  ExpectRefusal(
      "a.json", file(hand, R"({"matrix": [[1]]})"), "camera: expected a matrix of 4 rows");
  ExpectRefusal("a.json",
                file(hand, R"({"position_m": [4, 5, null], "quaternion_wxyz": [1, 0, 0, 0]})"),
                "null");
  ExpectRefusal("a.json", R"({"views": [{"hand": )" + hand + "}]}", "camera is missing");
  ExpectRefusal("a.json", R"({"views": []})", "holds no poses");
  ExpectRefusal("a.json", R"({"poses": []})", "unknown field 'poses'");
  ExpectRefusal("a.json", "{\"views\": [", "parse error");
  ExpectRefusal("a.json", "", "parse error");
  ExpectRefusal("a.json", "7", "expected {\"views\"");
  ExpectRefusal("a.json", "[[[[1, 0], [0, 1]], 5]]", "[0]: base_T_eef");
  ExpectRefusal("a.json", std::string(2'000'000, '['), "nested deeper");
}

TEST_F(HandEyeFiles, MoveItSamples) {
  const std::string matrix = "[[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]";
  const auto views = ReadPoseFile(Write("m.json", "[[" + matrix + "," + matrix + "]]"));
  ASSERT_TRUE(views.ok()) << views.error().message;
  EXPECT_EQ(views->front().hand.translation.x(), 0.5);
  EXPECT_EQ(views->front().name, "pair 1");
}

constexpr const char* kVispPose =
    "rows: 6\ncols: 1\ndata: \n  - [0.7]\n  - [-0.03]\n  - [0.4]\n  - [3.05]\n  - [0.003]\n  - "
    "[0.1]\n";

TEST_F(HandEyeFiles, FoldersByPatterns) {
  for (const int number : {10, 2, 1}) {
    Write(Format("image-%d.png", number), "");
    Write(Format("pose_%d.yaml", number), kVispPose);
  }
  Write("image-x.png", "");
  ImageFolderLayout layout{scratch(), "image-%d.png", "pose_%d.yaml"};
  const auto images = ReadImageFolder(layout);
  ASSERT_TRUE(images.ok()) << images.error().message;
  ASSERT_EQ(images->size(), 3U);
  EXPECT_EQ(images->back().file.filename(), "image-10.png");
  EXPECT_EQ(images->front().hand.translation, Eigen::Vector3d(0.7, -0.03, 0.4));
  EXPECT_EQ(images->front().hand.rotation[2], 0.1);

  Write("pose_2.yaml", "rows: 6\ncols: 1\ndata: [1, 2, nan, 4, 5, 6]");
  EXPECT_NE(ReadImageFolder(layout).error().message.find("some not finite"), std::string::npos);
  Write("pose_2.yaml", "1 2 3");
  EXPECT_NE(ReadImageFolder(layout).error().message.find("holds 3 numbers"), std::string::npos);
  Write("pose_2.yaml", "1 0 0 4\n0 1 0 5\n0 0 1 6\n0 0 0 1\n");
  EXPECT_EQ((*ReadImageFolder(layout))[1].hand.translation, Eigen::Vector3d(4, 5, 6));
  std::filesystem::remove(scratch() / "pose_2.yaml");
  EXPECT_NE(ReadImageFolder(layout).error().message.find("has no pose"), std::string::npos);
  layout.image_pattern = "image.png";
  EXPECT_NE(ReadImageFolder(layout).error().message.find("expected a file's name with %d"),
            std::string::npos);
  layout.image_pattern = "";
  EXPECT_NE(ReadImageFolder(layout).error().message.find("together"), std::string::npos);
  layout.folder = scratch() / "none";
  EXPECT_NE(ReadImageFolder(layout).error().message.find("is no folder"), std::string::npos);
}

TEST_F(HandEyeFiles, FoldersByTable) {
  Write("poses.csv", "image,hand_x,hand_y,hand_z,hand_rx,hand_ry,hand_rz\na.png,1,2,3,0,0,0\n");
  const auto images = ReadImageFolder({.folder = scratch()});
  ASSERT_TRUE(images.ok()) << images.error().message;
  EXPECT_EQ(images->front().file, scratch() / "a.png");
  Write("poses.csv", "picture,hand_x,hand_y,hand_z,hand_rx,hand_ry,hand_rz\na.png,1,2,3,0,0,0\n");
  EXPECT_NE(ReadImageFolder({.folder = scratch()}).error().message.find("lacks the column 'image'"),
            std::string::npos);
}

TEST_F(HandEyeFiles, Images) {
  RgbImage picture{4, 3, std::vector<uint8_t>(36, 0)};
  for (size_t i = 0; i < 3; ++i) picture.rgb[3 * 6 + i] = 200;  // (2, 1)
  ASSERT_TRUE(WritePng(scratch() / "a.png", picture).ok());
  const Result<GrayImage> image = ReadGrayImage(scratch() / "a.png");
  ASSERT_TRUE(image.ok()) << image.error().message;
  EXPECT_EQ(image->width, 4);
  EXPECT_EQ(image->at(2, 1), 200);
  EXPECT_EQ(image->at(1, 2), 0);

  std::ifstream stream(scratch() / "a.png", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  for (size_t size = 0; size < bytes.size(); size += 3) {
    EXPECT_FALSE(ReadGrayImage(Write("cut.png", bytes.substr(0, size))).ok()) << size;
  }
  std::string huge = bytes;
  huge[17] = '\x3f';  // 4,128,768 px wide
  EXPECT_FALSE(ReadGrayImage(Write("huge.png", huge)).ok());
  huge = bytes;
  huge[18] = huge[22] = '\x3f';  // 16,128 px each way
  EXPECT_NE(ReadGrayImage(Write("huge.png", huge)).error().message.find("claims a size"),
            std::string::npos);
  EXPECT_NE(ReadGrayImage(Write("text.png", "hello")).error().message.find("neither PNG nor JPEG"),
            std::string::npos);
  EXPECT_FALSE(ReadGrayImage(Write("cut.jpg", "\xff\xd8\xff\xe0")).ok());
}

TEST_F(HandEyeFiles, Intrinsics) {
  const std::string xml =
      "<?xml version=\"1.0\"?><root><camera><image_width>640</image_width><image_height>480"
      "</image_height><model><type>perspectiveProjWithoutDistortion</type><px>1</px></model><model>"
      "<type>perspectiveProjWithDistortion</type><px> 607.5</px><py>608</py><u0>323.4</u0><v0>243"
      "</v0><kud>-0.1</kud><kdu>0.1</kdu></model></camera></root>";
  const Result<CameraIntrinsics> visp = ReadIntrinsics(Write("camera.xml", xml));
  ASSERT_TRUE(visp.ok()) << visp.error().message;
  EXPECT_EQ(visp->camera.fx, 607.5);
  EXPECT_EQ(visp->camera.cy, 243.0);
  EXPECT_EQ(visp->distortion.k1, -0.1);
  EXPECT_EQ(visp->camera.width, 640);
  EXPECT_NE(ReadIntrinsics(Write("camera.xml", "<px>"))
                .error()
                .message.find("has no number in <image_width>"),
            std::string::npos);
  const Result<CameraIntrinsics> again =
      ReadIntrinsics(Write("camera.toml", IntrinsicsToml(*visp)));
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_EQ(again->camera, visp->camera);
  EXPECT_EQ(again->distortion, visp->distortion);
  EXPECT_FALSE(ReadIntrinsics(Write("camera.toml", "fx_px = 1.0\n")).ok());
  EXPECT_FALSE(ReadIntrinsics(scratch() / "none.toml").ok());
}

}  // namespace
}  // namespace vantage
