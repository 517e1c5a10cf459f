#include "tools/evaluate/dataset_text.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "common/format.h"
#include "tools/support/csv_field.h"

namespace vantage {
namespace {

// Keeps the order of the members.
using Json = nlohmann::ordered_json;

const DatasetView& ViewOf(const DatasetResults& results, const DatasetOutcome& outcome) {
  return results.datasets[outcome.dataset].views[outcome.view];
}

const ObjectModel& ModelOf(const DatasetResults& results, const DatasetOutcome& outcome) {
  const DatasetObject& object = ViewOf(results, outcome).objects[outcome.object];
  return results.datasets[outcome.dataset].models[object.model];
}

// "-" where there is none.
std::string Cell(double value, int decimals) {
  return std::isfinite(value) ? Format("%.*f", decimals, value) : "-";
}

std::string Verdict(const DatasetOutcome& outcome) {
  if (!outcome.is_found) return "not found";
  if (outcome.success.is_within) return "within";
  return outcome.success.is_indistinguishable ? "indistinguishable" : "wrong";
}

std::string OutcomeLine(const DatasetResults& results, const DatasetOutcome& outcome) {
  return Format("%-12.12s %-20.20s %-9s %-11s %-17s %7s %7s %6s %6s %7s %7.1f\n",
                ViewOf(results, outcome).name.c_str(),
                ModelOf(results, outcome).id.c_str(),
                outcome.estimator.c_str(),
                Name(outcome.search).c_str(),
                Verdict(outcome).c_str(),
                Cell(outcome.success.angle / kDegree, 2).c_str(),
                Cell(1e3 * outcome.success.distance, 2).c_str(),
                outcome.is_found ? Cell(outcome.score, 3).c_str() : "-",
                outcome.is_found ? Cell(outcome.success.discrepancy, 3).c_str() : "-",
                Cell(1e3 * outcome.truth_offset, 2).c_str(),
                1e3 * outcome.seconds);
}

std::string SummaryLine(const DatasetResults& results, const DatasetSummary& summary) {
  return Format("%-26.26s %-9s %-11s %7d %5d %6d %9d %9d %5d %8s %8s %8s %7.1f %7.1f\n",
                results.datasets[summary.dataset].name.c_str(),
                summary.estimator.c_str(),
                Name(summary.search).c_str(),
                summary.num_objects,
                summary.num_found,
                summary.num_within,
                summary.num_indistinguishable,
                summary.num_succeeded,
                summary.num_wrong,
                Cell(summary.median_angle / kDegree, 2).c_str(),
                Cell(summary.largest_angle / kDegree, 2).c_str(),
                Cell(1e3 * summary.median_distance, 2).c_str(),
                1e3 * summary.median_seconds,
                1e3 * summary.largest_seconds);
}

// By column; those of the pose are empty where nothing was found.
std::vector<std::pair<const char*, std::string>> Columns(const DatasetResults& results,
                                                         const DatasetOutcome& outcome) {
  const auto found = [&outcome](const std::string& field) {
    return outcome.is_found ? field : std::string();
  };
  const PoseSuccess& success = outcome.success;
  const StageSeconds& stages = outcome.stages;
  return {{"dataset", CsvField(results.datasets[outcome.dataset].name)},
          {"estimator", CsvField(outcome.estimator)},
          {"search", Name(outcome.search)},
          {"view", CsvField(ViewOf(results, outcome).name)},
          {"model", CsvField(ModelOf(results, outcome).id)},
          {"found", outcome.is_found ? "1" : "0"},
          {"within", success.is_within ? "1" : "0"},
          {"indistinguishable", success.is_indistinguishable ? "1" : "0"},
          {"angle_deg", CsvField(success.angle / kDegree)},
          {"distance_mm", CsvField(1e3 * success.distance)},
          {"other_angle_deg", CsvField(outcome.angle_other / kDegree)},
          {"other_distance_mm", CsvField(1e3 * outcome.distance_other)},
          {"discrepancy", found(CsvField(success.discrepancy))},
          {"deviation_sigmas", found(CsvField(success.deviation))},
          {"score", found(CsvField(outcome.score))},
          {"truth_offset_mm", CsvField(1e3 * outcome.truth_offset)},
          {"clusters", std::to_string(outcome.num_clusters)},
          {"wrong_detections", std::to_string(outcome.num_wrong)},
          {"total_ms", CsvField(1e3 * outcome.seconds)},
          {"segmentation_ms", CsvField(1e3 * stages.segmentation)},
          {"normals_ms", CsvField(1e3 * stages.normals)},
          {"proposal_ms", CsvField(1e3 * stages.proposal)},
          {"verification_ms", CsvField(1e3 * stages.verification)},
          {"refinement_ms", CsvField(1e3 * stages.refinement)}};
}

Json ToJson(const Pose& pose) {
  const Eigen::Quaterniond q = Canonical(Eigen::Quaterniond(pose.linear()));
  const Eigen::Vector3d& t = pose.translation();
  return {{"trans", {t.x(), t.y(), t.z()}}, {"quat_wxyz", {q.w(), q.x(), q.y(), q.z()}}};
}

Json ToJson(const StageSeconds& stages) {
  return {{"segmentation", stages.segmentation},
          {"normals", stages.normals},
          {"proposal", stages.proposal},
          {"verification", stages.verification},
          {"refinement", stages.refinement}};
}

Json ToJson(const DatasetResults& results, const DatasetOutcome& outcome) {
  const PoseSuccess& success = outcome.success;
  const DatasetObject& object = ViewOf(results, outcome).objects[outcome.object];
  Json json = {{"dataset", results.datasets[outcome.dataset].name},
               {"estimator", outcome.estimator},
               {"search", Name(outcome.search)},
               {"view", ViewOf(results, outcome).name},
               {"model", ModelOf(results, outcome).id},
               {"is_found", outcome.is_found},
               {"is_within", success.is_within},
               {"is_indistinguishable", success.is_indistinguishable},
               {"angle_deg", success.angle / kDegree},
               {"distance_mm", 1e3 * success.distance},
               {"other_angle_deg", outcome.angle_other / kDegree},
               {"other_distance_mm", 1e3 * outcome.distance_other},
               {"discrepancy", success.discrepancy},
               {"deviation_sigmas", success.deviation},
               {"score", outcome.score},
               {"truth_offset_mm", 1e3 * outcome.truth_offset},
               {"num_clusters", outcome.num_clusters},
               {"num_wrong", outcome.num_wrong},
               {"T_camera_object_true", ToJson(object.T_camera_object)},
               {"T_camera_object", nullptr},
               {"seconds", outcome.seconds},
               {"stage_seconds", ToJson(outcome.stages)}};
  if (outcome.is_found) json["T_camera_object"] = ToJson(outcome.T_camera_object);
  return json;
}

Json ToJson(const DatasetResults& results, const DatasetSummary& summary) {
  return {{"dataset", results.datasets[summary.dataset].name},
          {"estimator", summary.estimator},
          {"search", Name(summary.search)},
          {"num_objects", summary.num_objects},
          {"num_found", summary.num_found},
          {"num_within", summary.num_within},
          {"num_indistinguishable", summary.num_indistinguishable},
          {"num_succeeded", summary.num_succeeded},
          {"num_wrong", summary.num_wrong},
          {"median_angle_deg", summary.median_angle / kDegree},
          {"largest_angle_deg", summary.largest_angle / kDegree},
          {"median_distance_mm", 1e3 * summary.median_distance},
          {"median_seconds", summary.median_seconds},
          {"largest_seconds", summary.largest_seconds}};
}

}  // namespace

std::string DatasetText(const DatasetResults& results) {
  std::string text;
  for (const std::string& note : results.notes) text += note + "\n";
  for (size_t d = 0; d < results.datasets.size(); ++d) {
    const Dataset& dataset = results.datasets[d];
    text += Format("%s: %s\n", dataset.name.c_str(), dataset.what.c_str());
    for (const std::string& note : dataset.notes) text += "  " + note + "\n";
    text += Format("%-12s %-20s %-9s %-11s %-17s %7s %7s %6s %6s %7s %7s\n",
                   "view",
                   "model",
                   "estimator",
                   "search",
                   "verdict",
                   "deg",
                   "mm",
                   "score",
                   "differ",
                   "true mm",
                   "ms");
    for (const DatasetOutcome& outcome : results.outcomes) {
      if (outcome.dataset == d) text += OutcomeLine(results, outcome);
    }
    text += "\n";
  }
  text += Format("%-26s %-9s %-11s %7s %5s %6s %9s %9s %5s %8s %8s %8s %7s %7s\n",
                 "dataset",
                 "estimator",
                 "search",
                 "objects",
                 "found",
                 "within",
                 "indisting",
                 "succeeded",
                 "wrong",
                 "med deg",
                 "max deg",
                 "med mm",
                 "med ms",
                 "max ms");
  for (const DatasetSummary& summary : Summarize(results)) text += SummaryLine(results, summary);
  return text;
}

std::string DatasetCsv(const DatasetResults& results) {
  std::string csv;
  for (const DatasetOutcome& outcome : results.outcomes) {
    const auto columns = Columns(results, outcome);
    const auto append = [&csv, &columns](auto field) {
      for (size_t i = 0; i < columns.size(); ++i) {
        if (i > 0) csv += ',';
        csv += field(columns[i]);
      }
      csv += '\n';
    };
    if (csv.empty()) append([](const auto& column) { return std::string(column.first); });
    append([](const auto& column) { return column.second; });
  }
  return csv;
}

std::string DatasetJson(const DatasetResults& results) {
  Json json = {{"command", results.command},
               {"version", results.version},
               {"seed", results.seed},
               {"max_angle_deg", results.bounds.max_angle / kDegree},
               {"max_distance_of_diameter", results.bounds.max_distance},
               {"notes", results.notes},
               {"summaries", Json::array()},
               {"outcomes", Json::array()}};
  for (const DatasetSummary& summary : Summarize(results)) {
    json["summaries"].push_back(ToJson(results, summary));
  }
  for (const DatasetOutcome& outcome : results.outcomes) {
    json["outcomes"].push_back(ToJson(results, outcome));
  }
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace vantage
