#include "perception/calibration/chessboard_detector.h"

#include <algorithm>
#include <opencv2/calib3d.hpp>

namespace vantage {
namespace {

/// Brightness in the middle of the square right below inner corner (row, column).
double SquareBrightness(const cv::Mat& image,
                        const std::vector<cv::Point2f>& corners,
                        int columns,
                        int row,
                        int column) {
  const auto corner = [&](int r, int c) { return corners[static_cast<size_t>(r * columns + c)]; };
  const cv::Point2f middle = 0.25F * (corner(row, column) + corner(row, column + 1) +
                                      corner(row + 1, column) + corner(row + 1, column + 1));
  const int u = std::clamp(static_cast<int>(std::lround(middle.x)), 0, image.cols - 1);
  const int v = std::clamp(static_cast<int>(std::lround(middle.y)), 0, image.rows - 1);
  return image.at<uint8_t>(v, u);
}

/// How much brighter those squares are that are white on a board whose top left square is black.
double Contrast(const cv::Mat& image,
                const std::vector<cv::Point2f>& corners,
                int columns,
                int rows) {
  double contrast = 0.0;
  for (int row = 0; row + 1 < rows; ++row) {
    for (int column = 0; column + 1 < columns; ++column) {
      const double sign = (row + column) % 2 == 0 ? -1.0 : 1.0;
      contrast += sign * SquareBrightness(image, corners, columns, row, column);
    }
  }
  return contrast;
}

/// Whether the corners are in the order of a mirror image.
bool IsMirrored(const std::vector<cv::Point2f>& corners, int columns, int rows) {
  const cv::Point2f along = corners[static_cast<size_t>(columns - 1)] - corners[0];
  const cv::Point2f down = corners[static_cast<size_t>(columns * (rows - 1))] - corners[0];
  return along.cross(down) < 0.0F;
}

}  // namespace

ChessboardDetector::ChessboardDetector(const CalibrationTarget& target)
    : target_(target), points_(TargetPoints(target)) {}

std::vector<TargetPoint> ChessboardDetector::Detect(const GrayImage& image) {
  if (!IsDetectable(image)) return {};
  const cv::Mat view(image.height, image.width, CV_8U, const_cast<uint8_t*>(image.pixels.data()));
  const int columns = target_.columns;
  const int rows = target_.rows;
  std::vector<cv::Point2f> corners;
  try {
    const int flags =
        cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_EXHAUSTIVE | cv::CALIB_CB_ACCURACY;
    if (!cv::findChessboardCornersSB(view, cv::Size(columns, rows), corners, flags)) return {};
  } catch (const cv::Exception&) {
    return {};
  }
  if (corners.size() != points_.size()) return {};
  if (IsMirrored(corners, columns, rows)) {
    for (int row = 0; row < rows; ++row) {
      const auto begin = corners.begin() + static_cast<std::ptrdiff_t>(row) * columns;
      std::reverse(begin, begin + columns);
    }
  }
  // Of the two ways to turn the board the one in which its top left square is black.
  if (Contrast(view, corners, columns, rows) < 0.0) std::reverse(corners.begin(), corners.end());
  std::vector<TargetPoint> points;
  for (size_t i = 0; i < corners.size(); ++i) {
    points.push_back(
        {.p_target = points_[i], .pixel = Eigen::Vector2d(corners[i].x, corners[i].y)});
  }
  return points;
}

}  // namespace vantage
