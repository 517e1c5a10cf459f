#include "perception/calibration/charuco_detector.h"

#include <opencv2/aruco/charuco.hpp>

#include "perception/calibration/aruco_dictionary.h"

namespace vantage {

CharucoDetector::CharucoDetector(const CalibrationTarget& target)
    : target_(target), points_(TargetPoints(target)) {}

std::vector<TargetPoint> CharucoDetector::Detect(const GrayImage& image) {
  if (!IsDetectable(image)) return {};
  const cv::Mat view(image.height, image.width, CV_8U, const_cast<uint8_t*>(image.pixels.data()));
  const auto known = ArucoDictionary::Find(target_.family);
  if (!known) return {};
  std::vector<cv::Point2f> corners;
  std::vector<int> ids;
  try {
    const auto dictionary = cv::aruco::getPredefinedDictionary(known->opencv_id);
    const auto board = cv::aruco::CharucoBoard::create(target_.columns,
                                                       target_.rows,
                                                       static_cast<float>(target_.size),
                                                       static_cast<float>(target_.marker),
                                                       dictionary);
    for (int& id : board->ids) id += target_.first_id;
    std::vector<int> marker_ids;
    std::vector<std::vector<cv::Point2f>> marker_corners;
    cv::aruco::detectMarkers(view, dictionary, marker_corners, marker_ids);
    if (marker_ids.empty()) return {};
    cv::aruco::interpolateCornersCharuco(marker_corners, marker_ids, view, board, corners, ids);
  } catch (const cv::Exception&) {
    return {};
  }
  std::vector<TargetPoint> points;
  for (size_t i = 0; i < ids.size() && i < corners.size(); ++i) {
    if (ids[i] < 0 || static_cast<size_t>(ids[i]) >= points_.size()) continue;
    // For this part of OpenCV (0, 0) is the corner of a pixel.
    points.push_back({.p_target = points_[static_cast<size_t>(ids[i])],
                      .pixel = Eigen::Vector2d(corners[i].x - 0.5, corners[i].y - 0.5)});
  }
  return points;
}

}  // namespace vantage
