#include "tools/evaluate/results_json.h"

#include <nlohmann/json.hpp>

namespace vantage {
namespace {

// Keeps the order of the members.
using Json = nlohmann::ordered_json;

Json ToJson(const Interval& interval) {
  return {{"value", interval.value}, {"low", interval.low}, {"high", interval.high}};
}

Json ToJson(const MethodInfo& method) {
  return {{"id", method.id},
          {"label", method.label},
          {"parameters", method.parameters},
          {"is_histogram", method.is_histogram},
          {"is_past_paper", method.is_past_paper}};
}

Json ToJson(const GridStatistics& grid) {
  return {{"k", grid.k},
          {"num_cells", grid.num_cells},
          {"mean_deg", grid.mean_deg},
          {"deviation_deg", grid.deviation_deg},
          {"megabytes", grid.megabytes},
          {"build_seconds", grid.build_seconds}};
}

Json ToJson(const BinCounts& bins) {
  return {{"bin_width_deg", bins.bin_width_deg}, {"counts", bins.counts}};
}

Json ToJson(const ClusteringSweep& sweep) {
  return {{"w_min", sweep.w_min},
          {"w_max", sweep.w_max},
          {"mean_error_deg", sweep.mean_error_deg},
          {"wrong_mode_rate", sweep.wrong_mode_rate}};
}

Json ToJson(const CircleErrors& object) {
  return {{"model_id", object.model_id},
          {"symmetry", object.symmetry},
          {"detection_deg", object.detection_deg},
          {"detection_symmetric_deg", object.detection_symmetric_deg},
          {"step_deg", object.step_deg},
          {"step_symmetric_deg", object.step_symmetric_deg},
          {"particle_runs_deg", object.particle_runs_deg}};
}

Json ToJson(const MethodAccuracy& accuracy) {
  return {{"median_deg", ToJson(accuracy.median_deg)},
          {"mean_deg", ToJson(accuracy.mean_deg)},
          {"wrong_mode_rate", ToJson(accuracy.wrong_mode_rate)},
          {"median_difference_deg", ToJson(accuracy.median_difference_deg)},
          {"difference_of_medians_deg", ToJson(accuracy.difference_of_medians_deg)},
          {"difference_of_wrong_mode_rates", ToJson(accuracy.difference_of_wrong_mode_rates)},
          {"early_wrong_mode_rate", ToJson(accuracy.early_wrong_mode_rate)},
          {"difference_of_early_wrong_mode_rates",
           ToJson(accuracy.difference_of_early_wrong_mode_rates)},
          {"difference_to_blind_deg", ToJson(accuracy.difference_to_blind_deg)},
          {"seconds_per_view", accuracy.seconds_per_view},
          {"num_without_estimate", accuracy.num_without_estimate}};
}

Json ToJson(const SequenceErrors& object) {
  return {{"model_id", object.model_id},
          {"symmetry", object.symmetry},
          {"num_views", object.num_views},
          {"num_found", object.num_found},
          {"detection_deg", object.detection_deg},
          {"final_deg", object.final_deg},
          {"early_deg", object.early_deg},
          {"step_median_deg", object.step_median_deg}};
}

template <class T>
Json ListToJson(const std::vector<T>& list) {
  Json json = Json::array();
  for (const T& item : list) json.push_back(ToJson(item));
  return json;
}

}  // namespace

std::string ResultsJson(const EvaluationResults& results) {
  const Json json = {{"command", results.command},
                     {"version", results.version},
                     {"seed", results.seed},
                     {"wrong_mode_deg", results.wrong_mode_deg},
                     {"views_per_sequence", results.views_per_sequence},
                     {"early_views", results.early_views},
                     {"histogram_k", results.histogram_k},
                     {"methods", ListToJson(results.methods)},
                     {"best_ours", results.best_ours},
                     {"best_blind", results.best_blind},
                     {"grids", ListToJson(results.grids)},
                     {"grid_angles", ToJson(results.grid_angles)},
                     {"grid_distances", ToJson(results.grid_distances)},
                     {"sweep", ToJson(results.sweep)},
                     {"circle", ListToJson(results.circle)},
                     {"sequences", ListToJson(results.sequences)},
                     {"accuracy", ListToJson(results.accuracy)}};
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace vantage
