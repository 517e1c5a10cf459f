#include "perception/calibration/aruco_dictionary.h"

#include <array>
#include <opencv2/aruco/dictionary.hpp>
#include <string>

#include "common/check.h"

namespace vantage {
namespace {

struct Entry {
  const char* name;
  int id;
};

constexpr std::array kDictionaries = {
    Entry{"DICT_4X4_50", cv::aruco::DICT_4X4_50},
    Entry{"DICT_4X4_100", cv::aruco::DICT_4X4_100},
    Entry{"DICT_4X4_250", cv::aruco::DICT_4X4_250},
    Entry{"DICT_4X4_1000", cv::aruco::DICT_4X4_1000},
    Entry{"DICT_5X5_50", cv::aruco::DICT_5X5_50},
    Entry{"DICT_5X5_100", cv::aruco::DICT_5X5_100},
    Entry{"DICT_5X5_250", cv::aruco::DICT_5X5_250},
    Entry{"DICT_5X5_1000", cv::aruco::DICT_5X5_1000},
    Entry{"DICT_6X6_50", cv::aruco::DICT_6X6_50},
    Entry{"DICT_6X6_100", cv::aruco::DICT_6X6_100},
    Entry{"DICT_6X6_250", cv::aruco::DICT_6X6_250},
    Entry{"DICT_6X6_1000", cv::aruco::DICT_6X6_1000},
    Entry{"DICT_7X7_50", cv::aruco::DICT_7X7_50},
    Entry{"DICT_7X7_100", cv::aruco::DICT_7X7_100},
    Entry{"DICT_7X7_250", cv::aruco::DICT_7X7_250},
    Entry{"DICT_7X7_1000", cv::aruco::DICT_7X7_1000},
    Entry{"DICT_ARUCO_ORIGINAL", cv::aruco::DICT_ARUCO_ORIGINAL},
    Entry{"DICT_APRILTAG_16h5", cv::aruco::DICT_APRILTAG_16h5},
    Entry{"DICT_APRILTAG_25h9", cv::aruco::DICT_APRILTAG_25h9},
    Entry{"DICT_APRILTAG_36h10", cv::aruco::DICT_APRILTAG_36h10},
    Entry{"DICT_APRILTAG_36h11", cv::aruco::DICT_APRILTAG_36h11},
};

}  // namespace

Result<ArucoDictionary> ArucoDictionary::Find(std::string_view name) {
  std::string known;
  for (const Entry& entry : kDictionaries) {
    if (name == entry.name) {
      const auto dictionary = cv::aruco::getPredefinedDictionary(entry.id);
      return ArucoDictionary{.opencv_id = entry.id,
                             .num_markers = dictionary->bytesList.rows,
                             .cells = dictionary->markerSize + 2};
    }
    if (!known.empty()) known += ", ";
    known += entry.name;
  }
  std::string message = "unknown dictionary of markers \"";
  message.append(name.substr(0, 64)).append("\", expected one of ").append(known);
  return Error{ErrorCode::kInvalidArgument, std::move(message)};
}

std::vector<bool> ArucoDictionary::BlackCells(int marker) const {
  VANTAGE_CHECK(marker >= 0 && marker < num_markers, std::to_string(marker));
  const auto dictionary = cv::aruco::getPredefinedDictionary(opencv_id);
  const cv::Mat bits = cv::aruco::Dictionary::getBitsFromByteList(
      dictionary->bytesList.rowRange(marker, marker + 1), dictionary->markerSize);
  std::vector<bool> black(static_cast<size_t>(cells) * static_cast<size_t>(cells), true);
  for (int row = 0; row < bits.rows; ++row) {
    for (int column = 0; column < bits.cols; ++column) {
      black[static_cast<size_t>((row + 1) * cells + column + 1)] =
          bits.at<uint8_t>(row, column) == 0;
    }
  }
  return black;
}

}  // namespace vantage
