#include "tools/support/pose_records.h"

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/format.h"

namespace vantage {
namespace {

using nlohmann::json;

// Throws json::exception on fields that are absent or of another type.
PoseRecord Parse(const std::string& line) {
  const json fields = json::parse(line);
  PoseRecord record;
  record.model = fields.at("model").get<std::string>();
  record.estimator = fields.at("estimator").get<std::string>();
  record.view = fields.at("view").get<int>();
  record.is_peer = fields.at("is_peer").get<bool>();
  record.ms = fields.at("ms").get<double>();
  record.stages_ms = fields.at("stages_ms").get<std::map<std::string, double>>();
  record.is_within = fields.at("within").get<bool>();
  record.is_success = fields.at("success").get<bool>();
  record.angle_deg = fields.value("angle_deg", 0.0);
  record.distance_mm = fields.value("distance_mm", 0.0);
  return record;
}

}  // namespace

Result<void> ReadPoseRecords(const std::filesystem::path& file, std::vector<PoseRecord>* records) {
  std::ifstream stream(file);
  if (!stream) {
    return Error{ErrorCode::kNotFound, "estimates " + file.string() + " can't be read"};
  }
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    const std::string place = Format("%s:%d: ", file.c_str(), number);
    try {
      const PoseRecord record = Parse(line);
      if (!(record.ms > 0.0) || !std::isfinite(record.ms)) {
        return Error{ErrorCode::kCorrupt,
                     place + Format("ms = %g, expected a positive number", record.ms)};
      }
      if (record.is_within && !record.is_success) {
        return Error{ErrorCode::kCorrupt, place + "within but no success, expected both"};
      }
      records->push_back(record);
    } catch (const json::exception& exception) {
      return Error{ErrorCode::kCorrupt,
                   place + "no estimate of pose_comparison: " + exception.what()};
    }
  }
  return {};
}

}  // namespace vantage
