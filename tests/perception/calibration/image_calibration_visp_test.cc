#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "perception/calibration/image_calibration.h"
#include "perception/calibration/target_detector.h"
#include "perception/calibration/target_pose.h"
#include "tools/support/png_image.h"

// Images of a Franka arm with a D435 that come with ViSP (apps/calibration/hand-eye), and the
// results that ViSP publishes for them.
namespace vantage {
namespace {

const CameraModel kCamera{.width = 640,
                          .height = 480,
                          .fx = 607.5931396484375,
                          .fy = 607.574951171875,
                          .cx = 323.46282958984375,
                          .cy = 243.25529479980469};

std::filesystem::path Folder(const std::string& name) {
  return std::filesystem::path(VANTAGE_SOURCE_DIR) / "../shared/data/handeye" / name;
}

/// Translation, then rotation vector, one number in brackets a line.
Pose ReadPose(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  Eigen::Matrix<double, 6, 1> values = Eigen::Matrix<double, 6, 1>::Zero();
  Eigen::Index count = 0;
  while (std::getline(in, line) && count < 6) {
    const size_t bracket = line.find('[');
    if (bracket != std::string::npos) values[count++] = std::stod(line.substr(bracket + 1));
  }
  EXPECT_EQ(count, 6) << file;
  Pose pose = Pose::Identity();
  pose.translation() = values.head<3>();
  pose.linear() = ExpSo3(values.tail<3>()).toRotationMatrix();
  return pose;
}

std::vector<ImageView> ReadViews(const std::filesystem::path& folder,
                                 const CalibrationTarget& target) {
  auto detector = MakeTargetDetector(target).value();
  std::vector<ImageView> views;
  for (int i = 1; i <= 8; ++i) {
    const std::string number = std::to_string(i);
    ImageView view;
    view.name = number;
    view.T_base_hand = ReadPose(folder / ("franka_pose_rPe_" + number + ".yaml"));
    const auto picture = ReadPng8(folder / ("franka_image-" + number + ".png"));
    EXPECT_TRUE(picture.ok());
    if (!picture) continue;
    GrayImage image(picture->width, picture->height);
    image.pixels = picture->gray;
    view.points = detector->Detect(image);
    views.push_back(std::move(view));
  }
  return views;
}

/// Root mean square of how far what X says of each view alone is from their mean.
struct Spread {
  double translation = 0.0;  ///< m
  double rotation = 0.0;     ///< rad
};

Spread SpreadOf(const HandEyeResult& result, const std::vector<ImageView>& views) {
  std::vector<Pose> poses;
  for (const ImageView& view : views) {
    const auto seen = FindTargetPoses(view.points, kCamera, {}, 0.2);
    EXPECT_TRUE(seen.ok());
    const Pose A =
        result.setup == HandEyeSetup::kEyeInHand ? view.T_base_hand : view.T_base_hand.inverse();
    poses.push_back(A * result.T_x * (*seen)[0].T_camera_target);
  }
  const double count = static_cast<double>(poses.size());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  for (const Pose& pose : poses) mean += pose.translation() / count;
  rotation = poses[0].linear();
  for (int i = 0; i < 10; ++i) {
    Eigen::Vector3d step = Eigen::Vector3d::Zero();
    for (const Pose& pose : poses) {
      step += LogSo3(Eigen::Quaterniond(pose.linear() * rotation.transpose())) / count;
    }
    rotation = ExpSo3(step).toRotationMatrix() * rotation;
  }
  Spread spread;
  for (const Pose& pose : poses) {
    spread.translation += (pose.translation() - mean).squaredNorm() / count;
    const double angle =
        GeodesicAngle(Eigen::Quaterniond(pose.linear()), Eigen::Quaterniond(rotation));
    spread.rotation += angle * angle / count;
  }
  return {std::sqrt(spread.translation), std::sqrt(spread.rotation)};
}

TEST(ImageCalibrationVisp, EyeInHand) {
  const auto folder = Folder("visp_franka_eye_in_hand");
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder;
  const CalibrationTarget target{
      .kind = CalibrationTarget::Kind::kChessboard, .columns = 9, .rows = 6, .size = 0.0236};
  const std::vector<ImageView> views = ReadViews(folder, target);
  for (const ImageView& view : views) ASSERT_EQ(view.points.size(), 54U) << view.name;
  const auto result = CalibrateFromImages(HandEyeSetup::kEyeInHand, views, kCamera, {}, {});
  ASSERT_TRUE(result.ok()) << result.error().message;
  const Eigen::Vector3d published(0.05772, -0.03392, -0.04228);
  EXPECT_LT((result->T_x.translation() - published).norm(), 0.001);
  const double angle =
      GeodesicAngle(Eigen::Quaterniond(result->T_x.linear()), ExpSo3({0.00178, 0.00917, 1.58178}));
  EXPECT_LT(angle, 0.1 * kDegree);
  const Spread spread = SpreadOf(*result, views);
  EXPECT_LT(spread.translation, 0.00541);
  EXPECT_LT(spread.rotation, 0.456 * kDegree);
  EXPECT_TRUE(result->observability.is_sufficient) << result->observability.reason;
  for (const ViewResidual& view : result->views) EXPECT_FALSE(view.is_outlier) << view.name;
}

TEST(ImageCalibrationVisp, EyeToHand) {
  const auto folder = Folder("visp_franka_eye_to_hand");
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder;
  const CalibrationTarget target{.columns = 1, .rows = 1, .size = 0.048, .first_id = 10};
  const std::vector<ImageView> views = ReadViews(folder, target);
  for (const ImageView& view : views) ASSERT_EQ(view.points.size(), 4U) << view.name;
  const auto result = CalibrateFromImages(HandEyeSetup::kEyeToHand, views, kCamera, {}, {});
  ASSERT_TRUE(result.ok()) << result.error().message;
  const Eigen::Vector3d published(0.95404, -0.05124, 0.47622);
  EXPECT_LT((result->T_x.translation() - published).norm(), 0.003);
  const double angle = GeodesicAngle(Eigen::Quaterniond(result->T_x.linear()),
                                     ExpSo3({-1.104108, -1.112746, 1.289541}));
  EXPECT_LT(angle, 1.0 * kDegree);
  // What ViSP's own result leaves is 2.35 mm.
  EXPECT_LT(SpreadOf(*result, views).translation, 0.00235);
  EXPECT_TRUE(result->observability.is_sufficient) << result->observability.reason;
}

}  // namespace
}  // namespace vantage
