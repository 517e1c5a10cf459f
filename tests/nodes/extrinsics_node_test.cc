#include "nodes/extrinsics_node.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "bus/conversions.h"
#include "bus/image_conversion.h"
#include "drivers/sim/board_painter.h"
#include "drivers/sim/shading.h"
#include "drivers/sim/sim_arm.h"
#include "tests/nodes/clocked_test_bus.h"
#include "vantage/handeye_check_t.hpp"
#include "vantage/handeye_result_t.hpp"

namespace vantage {
namespace {

/// A camera in a hand before a board of tags, whose calibration is known.
class Cell {
 public:
  Cell() {
    config.camera = "XTION";
    config.target = CalibrationTarget{.columns = 3, .rows = 3};
    config.T_world_base =
        Eigen::Translation3d(0.3, -0.2, 0.1) * Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ());
    calibration.camera = "XTION";
    calibration.T_x = Eigen::Translation3d(0.03, -0.06, 0.05) *
                      Eigen::AngleAxisd(0.4, Eigen::Vector3d(0.2, 0.1, 1.0).normalized());
    calibration.T_y =
        Eigen::AngleAxisd(180.0 * kDegree, Eigen::Vector3d::UnitX()) * Pose::Identity();
    Eigen::Matrix<double, 6, 1> sigmas;
    sigmas << Eigen::Vector3d::Constant(0.01 * kDegree), Eigen::Vector3d::Constant(5e-5);
    calibration.covariance = sigmas.cwiseAbs2().asDiagonal();
    calibration.target_covariance = calibration.covariance;
    calibration.pixel_rms = 0.2;
    T_hand_camera = calibration.T_x;
  }

  void Start() {
    auto created = ExtrinsicsNode::Create(bus, config, calibration);
    ASSERT_TRUE(created.ok()) << created.error().message;
    node = std::move(created).value();
  }
  /// Rests for a while with the camera there; an image comes in the middle.
  void Rest(const Pose& T_base_camera) {
    const Pose T_base_hand = T_base_camera * T_hand_camera.inverse(Eigen::Isometry);
    for (int i = 0; i < 120; ++i, bus.now += 10'000) {
      if (i == 30 && bus.handlers.contains("CAMERA_XTION")) {
        bus.Send("CAMERA_XTION", Image(T_base_camera));
      }
      bus.Send("HAND_TO_BASE", PoseToMessage(T_base_hand, bus.now));
    }
  }

  ClockedTestBus bus;
  ExtrinsicsConfig config;
  HandEyeFile calibration;
  Pose T_hand_camera;  // The truth.
  std::unique_ptr<ExtrinsicsNode> node;

 private:
  images_t Image(const Pose& T_base_camera) const {
    SimScene scene;
    scene.board.emplace();
    scene.board->T_world_board = calibration.T_y;
    scene.board->size = config.target->BoardSize();
    scene.board->print = *DrawTarget(*config.target, 8000.0);
    SceneRenderer renderer(scene, CameraModel{});
    const RenderedView& view = renderer.Render(T_base_camera);
    std::vector<uint8_t> rgb;
    ShadeColor(view, &rgb);
    BoardPainter(*scene.board, 1).Paint(view, T_base_camera, renderer.Board(), bus.now, &rgb);
    image_t image{};
    image.utime = bus.now;
    image.width = 640;
    image.height = 480;
    image.row_stride = 3 * 640;
    image.pixelformat = image_t::PIXEL_FORMAT_RGB;
    image.data = rgb;
    images_t message{};
    message.utime = bus.now;
    AppendImage(images_t::LEFT, std::move(image), &message);
    return message;
  }
};

Pose View(int i) {
  return ViewOnSphere(Eigen::Vector3d::Zero(),
                      0.9 * static_cast<double>(i),
                      (50.0 + 8.0 * (i % 4)) * kDegree,
                      0.4 + 0.05 * (i % 3));
}

TEST(ExtrinsicsNode, PublishesTheCamerasPoseAtTheHandsRateAndTime) {
  Cell cell;
  cell.calibration.robot_scale = 1.001;
  cell.calibration.time_offset = 0.02;
  cell.Start();
  Pose T_base_hand = View(1);
  cell.bus.Send("HAND_TO_BASE", PoseToMessage(T_base_hand, cell.bus.now));
  const auto poses = cell.bus.Take<rigid_transform_t>("CAMERA_XTION_TO_WORLD");
  ASSERT_EQ(poses.size(), 1U);
  EXPECT_EQ(poses[0].utime, cell.bus.now - 20'000);
  T_base_hand.translation() *= 1.001;
  EXPECT_TRUE(PoseFromMessage(poses[0])->isApprox(
      cell.config.T_world_base * T_base_hand * cell.calibration.T_x, 1e-9));
  const auto results = cell.bus.Take<handeye_result_t>("HANDEYE_RESULT");
  ASSERT_EQ(results.size(), 1U);
  EXPECT_EQ(results[0].camera, "XTION");
  EXPECT_DOUBLE_EQ(results[0].robot_scale, 1.001);
  EXPECT_DOUBLE_EQ(results[0].trans[0], 0.03);
}

TEST(ExtrinsicsNode, ACameraThatStandsStillIsToldTenTimesASecond) {
  Cell cell;
  cell.config.setup = HandEyeSetup::kEyeToHand;
  cell.calibration.setup = HandEyeSetup::kEyeToHand;
  cell.Start();
  for (int i = 0; i < 200; ++i, cell.bus.now += 5'000) cell.node->Poll();
  const auto poses = cell.bus.Take<rigid_transform_t>("CAMERA_XTION_TO_WORLD");
  EXPECT_EQ(poses.size(), 10U);
  EXPECT_TRUE(PoseFromMessage(poses.back())
                  ->isApprox(cell.config.T_world_base * cell.calibration.T_x, 1e-9));
  EXPECT_EQ(cell.bus.Take<handeye_result_t>("HANDEYE_RESULT").size(), 1U);
}

TEST(ExtrinsicsNode, TurnsNextViewIntoPosesOfTheHand) {
  Cell cell;
  cell.Start();
  next_view_t view{};
  view.seq = 17;
  view_candidate_t candidate{};
  const rigid_transform_t wire = PoseToMessage(View(2), 0);
  std::copy_n(wire.trans, 3, candidate.trans);
  std::copy_n(wire.quat, 4, candidate.quat);
  view.candidates = {candidate};
  view.num_candidates = 1;
  cell.bus.Send("NEXT_VIEW", view);
  const auto asked = cell.bus.Take<next_view_t>("NEXT_HAND_POSE");
  ASSERT_EQ(asked.size(), 1U);
  EXPECT_EQ(asked[0].seq, 17);
  const Pose T_base_hand = *PoseFromWire(asked[0].candidates[0].trans, asked[0].candidates[0].quat);
  EXPECT_TRUE(
      (cell.config.T_world_base * T_base_hand * cell.calibration.T_x).isApprox(View(2), 1e-9));
  view.candidates[0].quat[0] = 7.0;
  cell.bus.Send("NEXT_VIEW", view);
  EXPECT_TRUE(cell.bus.Take<next_view_t>("NEXT_HAND_POSE").empty());
  EXPECT_NE(cell.bus.state.find("NEXT_VIEW"), std::string::npos);
}

TEST(ExtrinsicsNode, TheCheckHoldsUntilTheCameraIsKnocked) {
  Cell cell;
  cell.Start();
  cell.bus.Send("CAMERA_XTION_INFO", CameraToMessage(CameraModel{}, {}, cell.bus.now, 0));
  for (int i = 0; i < 5; ++i) cell.Rest(View(i));
  auto checks = cell.bus.Take<handeye_check_t>("HANDEYE_CHECK");
  ASSERT_GE(checks.size(), 4U);
  EXPECT_EQ(checks.back().state, handeye_check_t::HOLDS) << checks.back().reason;
  EXPECT_EQ(checks.back().source, "target");
  EXPECT_EQ(checks.back().num_views, 5);
  EXPECT_LT(checks.back().pixel_rms, 0.2);
  EXPECT_EQ(cell.bus.state, "ok");
  cell.T_hand_camera = cell.T_hand_camera * Eigen::Translation3d(0.002, 0.0, 0.0) *
                       Eigen::AngleAxisd(0.5 * kDegree, Eigen::Vector3d::UnitY());
  for (int i = 5; i < 8; ++i) cell.Rest(View(i));
  checks = cell.bus.Take<handeye_check_t>("HANDEYE_CHECK");
  EXPECT_EQ(checks.back().state, handeye_check_t::DRIFTED);
  EXPECT_NEAR(checks.back().translation, 0.002, 0.0005);
  EXPECT_NEAR(checks.back().rotation, 0.5 * kDegree, 0.05 * kDegree);
  EXPECT_NE(cell.bus.state.find("the camera has moved"), std::string::npos) << cell.bus.state;
}

/// Rests where the camera sees three objects that lie still.
void RestBeforeObjects(const Pose& T_base_camera, int64_t seq, Cell* cell) {
  const Pose T_base_hand = T_base_camera * cell->T_hand_camera.inverse(Eigen::Isometry);
  for (int i = 0; i < 120; ++i, cell->bus.now += 10'000) {
    if (i == 30) {
      DetectionSet set;
      set.utime = cell->bus.now;
      set.seq = seq;
      set.camera = "XTION";
      set.T_world_camera = cell->config.T_world_base * T_base_camera;
      for (int thing = 0; thing < 3; ++thing) {
        Detection detection;
        detection.model_id = thing == 0 ? "mug" : "filter";
        detection.cluster = thing;
        const Eigen::Translation3d p_base(0.12 * (thing - 1), 0.05 * thing * thing, 0.0);
        detection.T_camera_object = T_base_camera.inverse(Eigen::Isometry) * p_base;
        detection.mse = 1e-6;
        detection.inlier_fraction = 0.9;
        detection.verification_score = 0.9;
        set.detections.push_back(detection);
      }
      cell->bus.Send("DETECTIONS_.*", DetectionsToMessage(set));
    }
    cell->bus.Send("HAND_TO_BASE", PoseToMessage(T_base_hand, cell->bus.now));
  }
}

TEST(ExtrinsicsNode, WithoutATargetObjectsTellOfAKnock) {
  Cell cell;
  cell.config.target.reset();
  cell.Start();
  for (int i = 0; i < 6; ++i) RestBeforeObjects(View(i), i, &cell);
  auto checks = cell.bus.Take<handeye_check_t>("HANDEYE_CHECK");
  ASSERT_FALSE(checks.empty());
  EXPECT_EQ(checks.back().state, handeye_check_t::HOLDS) << checks.back().reason;
  EXPECT_EQ(checks.back().source, "detections");
  EXPECT_GT(checks.back().num_views, 6) << "of three objects each";
  cell.T_hand_camera = cell.T_hand_camera * Eigen::Translation3d(0.0, 0.03, 0.0);
  for (int i = 6; i < 12; ++i) RestBeforeObjects(View(i), i, &cell);
  checks = cell.bus.Take<handeye_check_t>("HANDEYE_CHECK");
  ASSERT_FALSE(checks.empty());
  EXPECT_EQ(checks.back().state, handeye_check_t::DRIFTED) << checks.back().reason;
}

TEST(ExtrinsicsNode, RefusesAnotherCamerasCalibration) {
  Cell cell;
  cell.calibration.camera = "OTHER";
  const auto created = ExtrinsicsNode::Create(cell.bus, cell.config, cell.calibration);
  ASSERT_FALSE(created.ok());
  EXPECT_NE(created.error().message.find("of camera OTHER, eye in hand"), std::string::npos);
}

TEST(MakeExtrinsicsNode, SaysHowToComeByACalibration) {
  ClockedTestBus bus;
  Result<ConfigReader> config =
      ConfigReader::Parse("[extrinsics]\ncalibration = \"/nowhere/x.toml\"\n", "test.toml");
  ASSERT_TRUE(config.ok());
  const auto node = MakeExtrinsicsNode(bus, *config, {});
  ASSERT_FALSE(node.ok());
  EXPECT_NE(node.error().message.find("/nowhere/x.toml"), std::string::npos);
  EXPECT_NE(node.error().message.find("vantage-handeye makes one"), std::string::npos);
}

}  // namespace
}  // namespace vantage
