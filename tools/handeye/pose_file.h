#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/result.h"
#include "perception/calibration/raw_pose.h"
#include "tools/handeye/csv_table.h"

namespace vantage {

/// Reads pairs of poses (docs/calibration.md): CSV with columns hand_... and camera_..., JSON of
/// our own, or MoveIt's pose_samples.json; the name's ending tells which. Poses are taken as they
/// are written, but for numbers that are not finite. Errors name file and line or index: absent,
/// empty, too large, another format, columns or fields that are missing or unknown, values that are
/// no numbers.
Result<std::vector<RawView>> ReadPoseFile(const std::filesystem::path& file);

/// The columns of one pose in a CSV file: PREFIX_x, _y, _z (m) and PREFIX_qw, _qx, _qy, _qz, or
/// PREFIX_rx, _ry, _rz (rad), or PREFIX_m00 ... _m33 instead of all of them.
class PoseColumns {
 public:
  /// Errors: columns are missing, or of two notations.
  static Result<PoseColumns> Find(const CsvTable& table, const std::string& prefix);
  /// Errors: no number; a matrix whose last row is not 0 0 0 1.
  [[nodiscard]] Result<RawPose> Read(const CsvTable& table, size_t row) const;
  [[nodiscard]] const std::vector<size_t>& used() const { return columns_; }

 private:
  RawPose::Rotation kind_ = RawPose::Rotation::kQuaternion;
  std::vector<size_t> columns_;
};

/// The pose of 16 numbers, row by row. Errors: the last row is not 0 0 0 1.
Result<RawPose> RawFromMatrix(const std::vector<double>& numbers);

/// utime of a row, 0 where there is no such column. Errors: no whole number from 0 to the year
/// 2200.
Result<int64_t> ReadUtime(const CsvTable& table, size_t row);

/// Errors: a column that is not among those used, nor "name" nor "utime".
Result<void> CheckColumns(const CsvTable& table,
                          const std::string& file,
                          const std::vector<size_t>& used);

}  // namespace vantage
