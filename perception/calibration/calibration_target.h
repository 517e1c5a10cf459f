#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "common/gray_image.h"
#include "common/result.h"

namespace vantage {

/// A flat target to calibrate with. Its frame: origin in the middle of the printed pattern, x along
/// the columns, y along the rows (downwards), z into the board, so that a camera that looks
/// straight at it has its axes.
struct CalibrationTarget {
  enum class Kind { kAprilTags, kChessboard, kCharuco };

  Kind kind = Kind::kAprilTags;
  int columns = 6;  ///< tags; squares of a ChArUco board; inner corners of a chessboard
  int rows = 6;
  double size = 0.03;   ///< m, side of a tag's black square, or of a square
  double gap = 0.009;   ///< m, between neighboring tags' black squares
  double marker = 0.0;  ///< m, side of a ChArUco board's markers
  int first_id = 0;     ///< of the tag at the top left; ids count up along the rows
  std::string family =
      "tag36h11";  ///< of tags; of a ChArUco board the dictionary, e.g. "DICT_4X4_50"

  /// Errors: sizes, counts and ids out of range (named), an unknown family; a chessboard that looks
  /// the same upside down (both counts odd or both even): its views would contradict each other.
  Result<void> Validate() const;
  /// m, whole pattern with its white margin, x and y.
  [[nodiscard]] Eigen::Vector2d BoardSize() const;
};

/// All points of a valid target that a detector may report, m: of tags the corners of the black
/// square, clockwise from the top left; of a board the squares' inner corners. Row by row.
std::vector<Eigen::Vector3d> TargetPoints(const CalibrationTarget& target);

/// The target as it is printed, the whole BoardSize(), for the simulator and for printers. A pixel
/// is as dark as its black share. The target's origin is the image's middle.
/// @param pixels_per_meter at least 100; the image's size is rounded to whole pixels. Errors: not a
/// valid target; more than 8192 px.
Result<GrayImage> DrawTarget(const CalibrationTarget& target, double pixels_per_meter);

}  // namespace vantage
