#include "nodes/planner_config.h"

#include <optional>
#include <utility>

#include "common/so3.h"

namespace vantage {
namespace {

constexpr int kMostViews = 10'000;
constexpr double kFarAway = 100.0;  // m

void ReadPoint(ConfigReader::Table& table, const std::string& key, Eigen::Vector3d* point) {
  std::vector<double> numbers = {point->x(), point->y(), point->z()};
  table.ReadNumbers(key, 3, -kFarAway, kFarAway, &numbers);
  *point = Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
}

void ReadCandidates(ConfigReader::Table& table, ViewCandidateParameters* candidates) {
  ReadPoint(table, "target_m", &candidates->target);
  table.Read("radius_m", &candidates->radius, 0.05, kFarAway);
  std::vector<double> elevation = {candidates->lowest_elevation / kDegree,
                                   candidates->highest_elevation / kDegree};
  table.ReadNumbers("elevation_deg", 2, -90.0, 90.0, &elevation);
  candidates->lowest_elevation = elevation[0] * kDegree;
  candidates->highest_elevation = elevation[1] * kDegree;
  table.Read("views", &candidates->count, 0, kMostViews);
  table.Read("elevations", &candidates->num_elevations, 1, 90);
  table.Read("azimuths", &candidates->num_azimuths, 1, 360);
}

// A box, or with a center a ball. All keys are asked for, so that a misspelt one is told of them.
void ReadKeepOut(ConfigReader::Table table, ReachabilityParameters* reach) {
  const auto corner = [&table](const char* key) {
    std::vector<double> numbers;
    table.ReadNumbers(key, 3, -kFarAway, kFarAway, &numbers);
    return numbers.empty() ? Eigen::Vector3d::Zero().eval() : Eigen::Vector3d(numbers.data());
  };
  std::string name;
  table.Require("name");
  table.Read("name", &name);
  const KeepOutBox box{name, corner("lowest_m"), corner("highest_m")};
  const Eigen::Vector3d center = corner("center_m");
  std::optional<double> radius;
  table.Read("radius_m", &radius, 1e-3, kFarAway);
  const bool is_ball = table.Has("center_m") || table.Has("radius_m");
  if (is_ball && (table.Has("lowest_m") || table.Has("highest_m"))) {
    table.Fail("name",
               "expected lowest_m and highest_m of a box, or center_m and radius_m of a ball, "
               "not some of both");
  } else if (is_ball) {
    for (const char* key : {"center_m", "radius_m"}) table.Require(key);
    reach->spheres.push_back({name, center, radius.value_or(0.0)});
  } else {
    for (const char* key : {"lowest_m", "highest_m"}) table.Require(key);
    reach->boxes.push_back(box);
  }
}

void ReadReach(ConfigReader::Table& table, ReachabilityParameters* reach) {
  ReadPoint(table, "arm_base_m", &reach->base);
  std::vector<double> range;
  table.ReadNumbers("arm_reach_m", 2, 0.0, kFarAway, &range);
  if (!range.empty()) {
    reach->nearest = range[0];
    reach->farthest = range[1];
  }
  for (ConfigReader::Table& keep_out : table.SubTables("keep_out")) ReadKeepOut(keep_out, reach);
}

}  // namespace

std::vector<std::string> CriterionNames() {
  return {"information_gain", "confusion_heuristic", "farthest", "circle", "random"};
}

PlannerConfig ReadPlannerConfig(ConfigReader& config) {
  PlannerConfig result;
  ConfigReader::Table table = config.Root().Sub("planner");
  table.ReadChoice("criterion", &result.criterion, CriterionNames());
  int64_t seed = 1;
  table.Read("seed", &seed, int64_t{0}, int64_t{1} << 62U);
  result.seed = static_cast<uint64_t>(seed);
  ReadCandidates(table, &result.views.candidates);
  ReadReach(table, &result.views.reach);
  table.Read("table_height_m", &result.views.occlusion.table_height, -kFarAway, kFarAway);
  table.Read("travel_weight_nat_per_m", &result.views.travel_weight, 0.0, 1e3);
  table.Read("least_gain_nat", &result.views.stop.least_gain, 0.0, 1e3);
  table.Read("sure", &result.views.stop.sure, 0.01, 0.999999);
  table.Read("max_views", &result.views.max_views, 1, kMostViews);
  return result;
}

}  // namespace vantage
