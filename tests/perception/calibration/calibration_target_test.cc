#include "perception/calibration/calibration_target.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

namespace vantage {
namespace {

using Kind = CalibrationTarget::Kind;

CalibrationTarget Chessboard(int columns, int rows) {
  return {.kind = Kind::kChessboard, .columns = columns, .rows = rows, .size = 0.02};
}

CalibrationTarget Charuco() {
  return {.kind = Kind::kCharuco,
          .columns = 7,
          .rows = 5,
          .size = 0.03,
          .marker = 0.022,
          .family = "DICT_5X5_50"};
}

std::string ErrorOf(const CalibrationTarget& target) {
  const auto valid = target.Validate();
  return valid ? "" : valid.error().message;
}

TEST(CalibrationTarget, GoodOnesAreValid) {
  EXPECT_EQ(ErrorOf({}), "");
  EXPECT_EQ(ErrorOf({.columns = 1, .rows = 1, .size = 0.048, .gap = 0.0, .first_id = 586}), "");
  EXPECT_EQ(ErrorOf(Chessboard(9, 6)), "");
  EXPECT_EQ(ErrorOf(Charuco()), "");
}

TEST(CalibrationTarget, BadOnesAreNamed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto expect_error = [](const CalibrationTarget& target, const std::string& part) {
    EXPECT_NE(ErrorOf(target).find(part), std::string::npos) << ErrorOf(target);
  };
  expect_error({.columns = 0}, "0 columns");
  expect_error({.rows = -3}, "-3 rows");
  expect_error({.columns = std::numeric_limits<int>::max()}, "1 to 100");
  expect_error({.size = nan}, "tags of nan m");
  expect_error({.size = -1.0}, "expected 0.0001 to 10");
  expect_error({.gap = nan}, "gap between tags of nan");
  expect_error({.gap = 0.001}, "gap between tags");
  expect_error({.first_id = -1}, "tags -1 to 34");
  expect_error({.first_id = std::numeric_limits<int>::max()}, "family tag36h11 has 0 to 586");
  expect_error({.first_id = 587 - 35}, "tags 552 to 587");
  expect_error({.family = "tag37h11"}, "tag36h11, tag25h9");
  expect_error(Chessboard(9, 7), "looks the same upside down");
  expect_error(Chessboard(2, 3), "expected 3 to 100");
  CalibrationTarget charuco = Charuco();
  charuco.marker = 0.03;
  expect_error(charuco, "markers of 0.03 m");
  charuco = Charuco();
  charuco.first_id = 40;
  expect_error(charuco, "dictionary DICT_5X5_50 has 0 to 49");
  charuco.family = std::string(100'000, 'x');
  EXPECT_LT(ErrorOf(charuco).size(), 1000U);
  expect_error(charuco, "DICT_4X4_50");
}

TEST(CalibrationTarget, PointsAreCenteredAndInOrder) {
  for (const CalibrationTarget& target : {CalibrationTarget{}, Chessboard(9, 6), Charuco()}) {
    const std::vector<Eigen::Vector3d> points = TargetPoints(target);
    const Eigen::Vector3d sum =
        std::accumulate(points.begin(), points.end(), Eigen::Vector3d(0.0, 0.0, 0.0));
    EXPECT_NEAR(sum.norm(), 0.0, 1e-12);
    // The first point is at the top left, the x axis to the right, the y axis down.
    EXPECT_LT(points.front().x(), 0.0);
    EXPECT_LT(points.front().y(), 0.0);
    EXPECT_GT(points[1].x(), points[0].x());
    EXPECT_EQ(points[1].y(), points[0].y());
  }
  EXPECT_EQ(TargetPoints({}).size(), 4U * 36U);
  EXPECT_EQ(TargetPoints(Chessboard(9, 6)).size(), 54U);
  EXPECT_EQ(TargetPoints(Charuco()).size(), 24U);
}

TEST(CalibrationTarget, PointsOfTagsAreAGapApart) {
  const std::vector<Eigen::Vector3d> points =
      TargetPoints({.columns = 2, .rows = 2, .size = 0.03, .gap = 0.009});
  EXPECT_NEAR(points[1].x() - points[0].x(), 0.03, 1e-12);
  EXPECT_NEAR(points[4].x() - points[1].x(), 0.009, 1e-12);
  EXPECT_NEAR(points[8].y() - points[3].y(), 0.009, 1e-12);
}

TEST(DrawTarget, BlackSharesAreThoseOfThePattern) {
  // Nine by six inner corners: 70 squares, of which 35 are black, with half a square around.
  const auto image = DrawTarget(Chessboard(9, 6), 1234.5);
  ASSERT_TRUE(image.ok());
  const Eigen::Vector2d size = 1234.5 * Chessboard(9, 6).BoardSize();
  EXPECT_EQ(image->width, std::lround(size.x()));
  EXPECT_EQ(image->height, std::lround(size.y()));
  double black = 0.0;
  for (const uint8_t pixel : image->pixels) black += (255.0 - pixel) / 255.0;
  const double expected = 35.0 * 0.02 * 0.02 * 1234.5 * 1234.5;
  EXPECT_NEAR(black, expected, 2e-4 * expected);
}

TEST(DrawTarget, EdgesLieWhereTheyAreTold) {
  // Along the middle row of a single tag: half the width of its black square from the middle.
  const CalibrationTarget tag{.columns = 1, .rows = 1, .size = 0.05};
  const auto image = DrawTarget(tag, 2011.0);
  ASSERT_TRUE(image.ok());
  // The outermost ring of cells is black: 255 to the left, then 50 mm / 8 of 0.
  double white = 0.0;
  const int v = image->height / 2;
  for (int u = 0; image->at(u, v) > 0; ++u) white += image->at(u, v) / 255.0;
  EXPECT_NEAR(white, 0.5 * image->width - 0.5 * 0.05 * 2011.0, 0.01);
}

TEST(DrawTarget, RefusesWhatIsTooLarge) {
  EXPECT_FALSE(DrawTarget({}, 99.0).ok());
  EXPECT_FALSE(DrawTarget({}, 1e9).ok());
  EXPECT_FALSE(DrawTarget({}, std::numeric_limits<double>::quiet_NaN()).ok());
  EXPECT_FALSE(DrawTarget({.columns = 0}, 1000.0).ok());
}

}  // namespace
}  // namespace vantage
