#include "perception/calibration/calibration_target.h"

#include <cmath>

#include "common/format.h"
#include "perception/calibration/aruco_dictionary.h"
#include "perception/calibration/tag_family.h"

namespace vantage {
namespace {

using Kind = CalibrationTarget::Kind;

Error Invalid(std::string message) { return {ErrorCode::kInvalidArgument, std::move(message)}; }

Result<void> CheckCounts(const CalibrationTarget& target) {
  const int lowest = target.kind == Kind::kAprilTags ? 1 : 3;
  constexpr int kHighest = 100;
  for (const int count : {target.columns, target.rows}) {
    if (count < lowest || count > kHighest) {
      return Invalid(Format("calibration target of %d columns and %d rows, expected %d to %d each",
                            target.columns,
                            target.rows,
                            lowest,
                            kHighest));
    }
  }
  return {};
}

Result<void> CheckTags(const CalibrationTarget& target) {
  const auto family = TagFamily::Find(target.family);
  if (!family) return family.error();
  const int count = target.columns * target.rows;
  if (target.first_id < 0 || target.first_id > family->num_tags() - count) {
    return Invalid(Format("tags %d to %d of the calibration target, but the family %s has 0 to %d",
                          target.first_id,
                          target.first_id + count - 1,
                          target.family.c_str(),
                          family->num_tags() - 1));
  }
  // A tag is told from what is around it by a ring of its own cells; white ones may be shared.
  const int cells = family->has_plain_ring() ? 1 : 2 * family->outer_cells();
  const double least = target.size * cells / family->border_cells();
  if (count > 1 && !(target.gap >= 0.999 * least && target.gap <= 10.0)) {
    return Invalid(Format("gap between tags of %g m, expected %g to 10 for tags of %g m",
                          target.gap,
                          least,
                          target.size));
  }
  return {};
}

Result<void> CheckCharuco(const CalibrationTarget& target) {
  const auto dictionary = ArucoDictionary::Find(target.family);
  if (!dictionary) return dictionary.error();
  if (!(target.marker >= 0.1 * target.size && target.marker <= 0.95 * target.size)) {
    return Invalid(
        Format("markers of %g m in a ChArUco board's squares of %g m, expected 0.1 to "
               "0.95 of the square",
               target.marker,
               target.size));
  }
  const int count = target.columns * target.rows / 2;
  if (target.first_id < 0 || target.first_id > dictionary->num_markers - count) {
    return Invalid(
        Format("markers %d to %d of the ChArUco board, but the dictionary %s has 0 to %d",
               target.first_id,
               target.first_id + count - 1,
               target.family.c_str(),
               dictionary->num_markers - 1));
  }
  return {};
}

Result<void> CheckChessboard(const CalibrationTarget& target) {
  if ((target.columns + target.rows) % 2 == 0) {
    return Invalid(
        Format("a chessboard of %d x %d inner corners looks the same upside down; use "
               "one with an odd and an even number of them, or cover a row",
               target.columns,
               target.rows));
  }
  return {};
}

/// m, from the outermost points that a detector reports (tags) or squares to the end of the white
/// margin.
double Margin(const CalibrationTarget& target) {
  if (target.kind != Kind::kAprilTags) return 0.5 * target.size;
  const auto family = TagFamily::Find(target.family);
  if (!family) return 0.0;
  return target.size * (family->outer_cells() + 1) / family->border_cells();
}

}  // namespace

Result<void> CalibrationTarget::Validate() const {
  if (const auto counts = CheckCounts(*this); !counts) return counts;
  if (!(size >= 1e-4 && size <= 10.0)) {
    return Invalid(Format("%s of %g m on the calibration target, expected 0.0001 to 10",
                          kind == Kind::kAprilTags ? "tags" : "squares",
                          size));
  }
  switch (kind) {
    case Kind::kAprilTags:
      return CheckTags(*this);
    case Kind::kChessboard:
      return CheckChessboard(*this);
    case Kind::kCharuco:
      return CheckCharuco(*this);
  }
  return {};
}

Eigen::Vector2d CalibrationTarget::BoardSize() const {
  Eigen::Vector2d pattern(columns, rows);
  if (kind == Kind::kChessboard) pattern += Eigen::Vector2d::Ones();
  pattern *= size;
  if (kind == Kind::kAprilTags) pattern += gap * Eigen::Vector2d(columns - 1, rows - 1);
  const double margin = Margin(*this);
  return pattern + 2.0 * Eigen::Vector2d(margin, margin);
}

std::vector<Eigen::Vector3d> TargetPoints(const CalibrationTarget& target) {
  const bool has_tags = target.kind == Kind::kAprilTags;
  // Of a ChArUco board the inner corners, as of a chessboard.
  const int fewer = target.kind == Kind::kCharuco ? 1 : 0;
  const int columns = target.columns - fewer;
  const int rows = target.rows - fewer;
  const double pitch = has_tags ? target.size + target.gap : target.size;
  const double half = 0.5 * target.size;
  std::vector<Eigen::Vector3d> points;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector3d middle(
          (column - 0.5 * (columns - 1)) * pitch, (row - 0.5 * (rows - 1)) * pitch, 0.0);
      if (!has_tags) {
        points.push_back(middle);
        continue;
      }
      // Clockwise from the top left, as seen.
      points.push_back(middle + Eigen::Vector3d(-half, -half, 0.0));
      points.push_back(middle + Eigen::Vector3d(half, -half, 0.0));
      points.push_back(middle + Eigen::Vector3d(half, half, 0.0));
      points.push_back(middle + Eigen::Vector3d(-half, half, 0.0));
    }
  }
  return points;
}

}  // namespace vantage
