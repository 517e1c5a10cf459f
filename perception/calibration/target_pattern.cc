#include "perception/calibration/target_pattern.h"

#include <algorithm>
#include <cmath>

#include "common/check.h"
#include "common/format.h"
#include "perception/calibration/aruco_dictionary.h"
#include "perception/calibration/tag_family.h"

namespace vantage {
namespace {

/// Adds the black cells of a square marker, neighbors along a row as one.
void AddMarker(const std::vector<bool>& black,
               const Eigen::Vector2d& lowest,
               double cell,
               std::vector<TargetRectangle>& parts) {
  const int side = static_cast<int>(std::lround(std::sqrt(static_cast<double>(black.size()))));
  for (int row = 0; row < side; ++row) {
    int column = 0;
    while (column < side) {
      const auto is_black = [&](int c) { return black[static_cast<size_t>(row * side + c)]; };
      const int begin = column;
      while (column < side && is_black(column)) ++column;
      if (column > begin) {
        parts.push_back({lowest + cell * Eigen::Vector2d(begin, row),
                         lowest + cell * Eigen::Vector2d(column, row + 1)});
      } else {
        ++column;
      }
    }
  }
}

std::vector<TargetRectangle> TagParts(const CalibrationTarget& target) {
  const auto family = TagFamily::Find(target.family);
  const double cell = target.size / family->border_cells();
  std::vector<TargetRectangle> parts;
  for (int row = 0; row < target.rows; ++row) {
    for (int column = 0; column < target.columns; ++column) {
      const Eigen::Vector2d middle(
          (column - 0.5 * (target.columns - 1)) * (target.size + target.gap),
          (row - 0.5 * (target.rows - 1)) * (target.size + target.gap));
      const double half = 0.5 * target.size + family->outer_cells() * cell;
      AddMarker(family->BlackCells(target.first_id + row * target.columns + column),
                middle - Eigen::Vector2d(half, half),
                cell,
                parts);
    }
  }
  return parts;
}

/// Squares of a board, the one at the top left black; markers in the white ones where there are
/// any.
std::vector<TargetRectangle> BoardParts(const CalibrationTarget& target) {
  const bool has_markers = target.kind == CalibrationTarget::Kind::kCharuco;
  const int columns = has_markers ? target.columns : target.columns + 1;
  const int rows = has_markers ? target.rows : target.rows + 1;
  const Eigen::Vector2d corner = -0.5 * target.size * Eigen::Vector2d(columns, rows);
  std::vector<TargetRectangle> parts;
  int marker = target.first_id;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector2d lowest = corner + target.size * Eigen::Vector2d(column, row);
      if ((row + column) % 2 == 0) {
        parts.push_back({lowest, lowest + target.size * Eigen::Vector2d::Ones()});
      } else if (has_markers) {
        const auto dictionary = ArucoDictionary::Find(target.family);
        const double margin = 0.5 * (target.size - target.marker);
        AddMarker(dictionary->BlackCells(marker++),
                  lowest + Eigen::Vector2d(margin, margin),
                  target.marker / dictionary->cells,
                  parts);
      }
    }
  }
  return parts;
}

/// Length of [begin, end] within the pixel from `pixel` to `pixel` + 1.
double Overlap(double begin, double end, int pixel) {
  return std::max(0.0, std::min(end, pixel + 1.0) - std::max(begin, static_cast<double>(pixel)));
}

/// Adds the share of each pixel that the rectangle, px, covers.
void AddCoverage(const Eigen::Vector2d& lowest,
                 const Eigen::Vector2d& highest,
                 int width,
                 int height,
                 std::vector<float>& coverage) {
  const auto bounded = [](double value, int limit) {
    return std::clamp(static_cast<int>(std::floor(value)), 0, limit - 1);
  };
  for (int v = bounded(lowest.y(), height); v <= bounded(highest.y(), height); ++v) {
    const double rows = Overlap(lowest.y(), highest.y(), v);
    for (int u = bounded(lowest.x(), width); u <= bounded(highest.x(), width); ++u) {
      coverage[static_cast<size_t>(v) * static_cast<size_t>(width) + static_cast<size_t>(u)] +=
          static_cast<float>(rows * Overlap(lowest.x(), highest.x(), u));
    }
  }
}

}  // namespace

std::vector<TargetRectangle> BlackParts(const CalibrationTarget& target) {
  VANTAGE_CHECK(target.Validate().ok(), target.family);
  return target.kind == CalibrationTarget::Kind::kAprilTags ? TagParts(target) : BoardParts(target);
}

Result<GrayImage> DrawTarget(const CalibrationTarget& target, double pixels_per_meter) {
  if (const auto valid = target.Validate(); !valid) return valid.error();
  constexpr int kLargest = 8192;
  const Eigen::Vector2d size = pixels_per_meter * target.BoardSize();
  if (!(pixels_per_meter >= 100.0) || !(size.maxCoeff() <= kLargest) || !(size.minCoeff() >= 1.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("a picture of the target at %g px/m has %g x %g px, expected at least 100 "
                        "px/m and 1 to %d px each way",
                        pixels_per_meter,
                        size.x(),
                        size.y(),
                        kLargest)};
  }
  const int width = static_cast<int>(std::lround(size.x()));
  const int height = static_cast<int>(std::lround(size.y()));
  std::vector<float> coverage(static_cast<size_t>(width) * static_cast<size_t>(height), 0.0F);
  const Eigen::Vector2d middle(0.5 * width, 0.5 * height);
  for (const TargetRectangle& part : BlackParts(target)) {
    AddCoverage(middle + pixels_per_meter * part.lowest,
                middle + pixels_per_meter * part.highest,
                width,
                height,
                coverage);
  }
  GrayImage image(width, height, 255);
  for (size_t i = 0; i < coverage.size(); ++i) {
    image.pixels[i] =
        static_cast<uint8_t>(std::lround(255.0F * (1.0F - std::min(coverage[i], 1.0F))));
  }
  return image;
}

}  // namespace vantage
