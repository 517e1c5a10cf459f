#include "tools/handeye/pose_file.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "common/format.h"
#include "common/time_range.h"
#include "tools/handeye/pose_json.h"

namespace vantage {
namespace {

using Kind = RawPose::Rotation;

constexpr size_t kMostRows = 100'000;

Error Corrupt(std::string message) { return {ErrorCode::kCorrupt, std::move(message)}; }

std::vector<std::string> NamesOf(Kind kind) {
  switch (kind) {
    case Kind::kRotationVector:
      return {"x", "y", "z", "rx", "ry", "rz"};
    case Kind::kMatrix: {
      std::vector<std::string> names;
      for (int row = 0; row < 4; ++row) {
        for (int column = 0; column < 4; ++column) names.push_back(Format("m%d%d", row, column));
      }
      return names;
    }
    case Kind::kQuaternion:
      break;
  }
  return {"x", "y", "z", "qw", "qx", "qy", "qz"};
}

Result<std::vector<RawView>> ReadPoseCsv(const std::filesystem::path& file) {
  const Result<CsvTable> table = CsvTable::Read(file);
  if (!table) return table.error();
  const Result<PoseColumns> hand = PoseColumns::Find(*table, "hand");
  if (!hand)
    return Error{hand.error().code, Format("%s %s", file.c_str(), hand.error().message.c_str())};
  const Result<PoseColumns> camera = PoseColumns::Find(*table, "camera");
  if (!camera) {
    return Error{camera.error().code,
                 Format("%s %s", file.c_str(), camera.error().message.c_str())};
  }
  std::vector<size_t> used = hand->used();
  used.insert(used.end(), camera->used().begin(), camera->used().end());
  if (Result<void> known = CheckColumns(*table, file.string(), used); !known) return known.error();
  if (table->num_rows() > kMostRows) {
    return Corrupt(Format(
        "%s has %zu rows, expected at most %zu", file.c_str(), table->num_rows(), kMostRows));
  }
  const std::optional<size_t> name = table->Column("name");
  std::vector<RawView> views;
  for (size_t row = 0; row < table->num_rows(); ++row) {
    Result<RawPose> hand_pose = hand->Read(*table, row);
    if (!hand_pose) return hand_pose.error();
    Result<RawPose> camera_pose = camera->Read(*table, row);
    if (!camera_pose) return camera_pose.error();
    const Result<int64_t> utime = ReadUtime(*table, row);
    if (!utime) return utime.error();
    views.push_back({name ? table->Text(row, *name) : Format("row %zu", row + 1),
                     *utime,
                     *hand_pose,
                     *camera_pose});
  }
  return views;
}

}  // namespace

Result<PoseColumns> PoseColumns::Find(const CsvTable& table, const std::string& prefix) {
  std::optional<PoseColumns> found;
  for (const Kind kind : {Kind::kQuaternion, Kind::kRotationVector, Kind::kMatrix}) {
    PoseColumns columns;
    columns.kind_ = kind;
    for (const std::string& name : NamesOf(kind)) {
      const auto column = table.Column(Format("%s_%s", prefix.c_str(), name.c_str()));
      if (!column) break;
      columns.columns_.push_back(*column);
    }
    if (columns.columns_.size() < NamesOf(kind).size()) continue;
    if (found) {
      return Corrupt(Format("has %s poses in two notations, expected one", prefix.c_str()));
    }
    found = columns;
  }
  if (found) return *found;
  std::string there;
  for (const std::string& column : table.columns()) {
    there += Format("%s%.40s", there.empty() ? "" : ", ", column.c_str());
  }
  const char* p = prefix.c_str();
  return Corrupt(
      Format("lacks columns of the %s poses, expected %s_x, %s_y, %s_z with %s_qw, _qx, "
             "_qy, _qz or %s_rx, _ry, _rz, or %s_m00 to %s_m33; it has: %.400s",
             p,
             p,
             p,
             p,
             p,
             p,
             p,
             p,
             there.c_str()));
}

Result<RawPose> PoseColumns::Read(const CsvTable& table, size_t row) const {
  std::vector<double> numbers;
  for (const size_t column : columns_) {
    const Result<double> number = table.Number(row, column);
    if (!number) return number.error();
    numbers.push_back(*number);
  }
  if (kind_ == Kind::kMatrix) {
    Result<RawPose> pose = RawFromMatrix(numbers);
    if (!pose)
      return Corrupt(Format("%s: %s", table.Place(row).c_str(), pose.error().message.c_str()));
    return pose;
  }
  RawPose pose{.translation = {numbers[0], numbers[1], numbers[2]}, .kind = kind_};
  std::copy(numbers.begin() + 3, numbers.end(), pose.rotation.begin());
  return pose;
}

Result<RawPose> RawFromMatrix(const std::vector<double>& m) {
  constexpr double kTolerance = 1e-6;
  if (m.size() != 16 || std::abs(m[12]) > kTolerance || std::abs(m[13]) > kTolerance ||
      std::abs(m[14]) > kTolerance || std::abs(m[15] - 1.0) > kTolerance) {
    return Corrupt("no matrix of a pose: expected 4 rows of 4 numbers, the last one 0 0 0 1");
  }
  return RawPose{.translation = {m[3], m[7], m[11]},
                 .kind = Kind::kMatrix,
                 .rotation = {m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]}};
}

Result<int64_t> ReadUtime(const CsvTable& table, size_t row) {
  const std::optional<size_t> column = table.Column("utime");
  if (!column) return int64_t{0};
  const Result<double> number = table.Number(row, *column);
  if (!number) return number.error();
  if (*number >= 0.0 && *number <= static_cast<double>(kLatestUtime)) {
    return static_cast<int64_t>(*number);
  }
  return Corrupt(Format("%s: utime = %g, expected microseconds since the epoch, 0 to %jd",
                        table.Place(row).c_str(),
                        *number,
                        intmax_t{kLatestUtime}));
}

Result<void> CheckColumns(const CsvTable& table,
                          const std::string& file,
                          const std::vector<size_t>& used) {
  for (size_t i = 0; i < table.columns().size(); ++i) {
    const std::string& name = table.columns()[i];
    if (name == "name" || name == "utime" || std::ranges::find(used, i) != used.end()) continue;
    return Corrupt(
        Format("%s has a column '%.60s' that has no meaning here, expected those of the "
               "poses, 'name' and 'utime'",
               file.c_str(),
               name.c_str()));
  }
  return {};
}

Result<std::vector<RawView>> ReadPoseFile(const std::filesystem::path& file) {
  const bool is_json = file.extension() == ".json";
  if (!is_json && file.extension() != ".csv") {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s is of no known format, expected FILE.csv or FILE.json", file.c_str())};
  }
  Result<std::vector<RawView>> views = is_json ? ReadPoseJson(file) : ReadPoseCsv(file);
  if (views && views->empty()) {
    return Corrupt(Format("%s holds no poses, expected at least 3 pairs", file.c_str()));
  }
  return views;
}

}  // namespace vantage
