#include "tools/handeye/target_options.h"

#include <map>

#include "common/format.h"
#include "nodes/config_reader.h"
#include "nodes/target_config.h"

namespace vantage {
namespace {

using Kind = CalibrationTarget::Kind;

const std::map<std::string, Kind>& Kinds() {
  static const std::map<std::string, Kind> kinds = {{"apriltags", Kind::kAprilTags},
                                                    {"chessboard", Kind::kChessboard},
                                                    {"charuco", Kind::kCharuco}};
  return kinds;
}

Result<CalibrationTarget> ReadFile(const std::string& file) {
  Result<ConfigReader> reader = ConfigReader::Open(file);
  if (!reader) {
    return Error{reader.error().code,
                 Format("target %s: %s; expected apriltags, chessboard, charuco or a TOML file",
                        file.c_str(),
                        reader.error().message.c_str())};
  }
  CalibrationTarget target;
  ConfigReader::Table root = reader->Root();
  ReadTarget(root, &target);
  if (Result<void> read = reader->Finish(); !read) return read.error();
  return target;
}

}  // namespace

void TargetOptions::AddTo(CLI::App* command) {
  command->add_option("--target",
                      target_,
                      "apriltags, chessboard, charuco, or a TOML file that describes the target");
  command->add_option("--columns",
                      columns_,
                      "tags, or squares of a ChArUco board, or inner corners of a chessboard");
  command->add_option("--rows", rows_, "likewise");
  command->add_option("--size", size_, "m, side of a tag's black square, or of a square");
  command->add_option("--gap", gap_, "m, between the black squares of neighboring tags");
  command->add_option("--marker", marker_, "m, side of a ChArUco board's markers");
  command->add_option(
      "--family", family_, "of tags: tag36h11, ...; of a ChArUco board its dictionary");
  command->add_option("--first-id", first_id_, "of the tag at the top left");
}

Result<std::optional<CalibrationTarget>> TargetOptions::Read() const {
  const bool has_more = columns_ || rows_ || size_ || gap_ || marker_ || family_ || first_id_;
  if (target_.empty() && has_more) {
    return Error{ErrorCode::kInvalidArgument,
                 "columns, rows or sizes of a target without its kind, expected --target KIND"};
  }
  if (target_.empty()) return std::optional<CalibrationTarget>();
  CalibrationTarget target;
  if (const auto kind = Kinds().find(target_); kind != Kinds().end()) {
    target.kind = kind->second;
    if (target.kind == Kind::kCharuco) target.family = "DICT_4X4_50";
    if (!columns_ || !rows_ || !size_) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("--target %s without its measures, expected --columns, --rows and --size",
                          target_.c_str())};
    }
  } else {
    const Result<CalibrationTarget> read = ReadFile(target_);
    if (!read) return read.error();
    target = *read;
  }
  target.columns = columns_.value_or(target.columns);
  target.rows = rows_.value_or(target.rows);
  target.size = size_.value_or(target.size);
  target.gap = gap_.value_or(target.gap);
  target.marker = marker_.value_or(target.marker);
  target.family = family_.value_or(target.family);
  target.first_id = first_id_.value_or(target.first_id);
  if (Result<void> valid = target.Validate(); !valid) return valid.error();
  return std::optional(target);
}

}  // namespace vantage
