#include "nodes/planner_config.h"

#include <limits>
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

void ReadKeepOut(ConfigReader::Table table, ReachabilityParameters* reach) {
  table.Require("name");
  std::string name;
  table.Read("name", &name);
  if (table.Has("center_m")) {
    KeepOutSphere sphere;
    sphere.name = name;
    ReadPoint(table, "center_m", &sphere.center);
    table.Require("radius_m");
    table.Read("radius_m", &sphere.radius, 1e-3, kFarAway);
    reach->spheres.push_back(std::move(sphere));
    return;
  }
  KeepOutBox box;
  box.name = name;
  table.Require("lowest_m");
  table.Require("highest_m");
  ReadPoint(table, "lowest_m", &box.lowest);
  ReadPoint(table, "highest_m", &box.highest);
  reach->boxes.push_back(std::move(box));
}

void ReadReach(ConfigReader::Table& table, ReachabilityParameters* reach) {
  ReadPoint(table, "arm_base_m", &reach->base);
  if (table.Has("arm_reach_m")) {
    std::vector<double> range;
    table.ReadNumbers("arm_reach_m", 2, 0.0, kFarAway, &range);
    if (range.size() == 2) {
      reach->nearest = range[0];
      reach->farthest = range[1];
    }
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
  if (table.Has("table_height_m")) {
    double height = 0.0;
    table.Read("table_height_m", &height, -kFarAway, kFarAway);
    result.views.occlusion.table_height = height;
  }
  table.Read("travel_weight_nat_per_m", &result.views.travel_weight, 0.0, 1e3);
  table.Read("least_gain_nat", &result.views.stop.least_gain, 0.0, 1e3);
  table.Read("sure", &result.views.stop.sure, 0.01, 0.999999);
  table.Read("max_views", &result.views.max_views, 1, kMostViews);
  return result;
}

}  // namespace vantage
