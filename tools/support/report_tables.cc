// The text forms of a report: terminal, CSV, JSON.
#include <nlohmann/json.hpp>

#include "common/format.h"
#include "tools/support/report_page.h"

namespace vantage {
namespace {

std::string Angle(const std::optional<PoseError>& error, int digits) {
  return error ? Format("%.*f", digits, error->angle / kDegree) : "";
}

std::string Distance(const std::optional<PoseError>& error, int digits) {
  return error ? Format("%.*f", digits, 1e3 * error->distance) : "";
}

// A run of before refinement has none.
std::optional<PoseError> RefinedAt(const ObjectHistory& object, size_t view) {
  return view < object.refined.size() ? object.refined[view] : std::nullopt;
}

nlohmann::json Json(const std::optional<PoseError>& error) {
  if (!error) return nullptr;
  return {{"rotation_deg", error->angle / kDegree}, {"position_mm", 1e3 * error->distance}};
}

}  // namespace

std::string SummaryTable(const RunMetrics& metrics, const ReportLimits& limits) {
  std::string table = Format("%-14s %8s %11s %11s %13s %12s %7s %9s\n",
                             "object",
                             "instance",
                             "error (deg)",
                             "error (mm)",
                             "refined (deg)",
                             "refined (mm)",
                             "views",
                             "seconds");
  for (const ObjectHistory& object : metrics.objects) {
    const std::optional<PoseError> error = object.final_error();
    const std::optional<PoseError> refined = object.final_refined_error();
    table +=
        Format("%-14s %8s %11s %11s %13s %12s %7d %9.1f%s\n",
               object.model_id.c_str(),
               object.instance ? std::to_string(*object.instance).c_str() : "-",
               error ? Angle(error, 2).c_str() : "-",
               error ? Distance(error, 2).c_str() : "-",
               refined ? Angle(refined, 3).c_str() : "-",
               refined ? Distance(refined, 2).c_str() : "-",
               object.num_views,
               object.seconds,
               object.instance ? (object.converged ? "" : "  (not converged)") : "  (not found)");
  }
  for (const std::string& extra : metrics.extra) {
    table += Format("%-14s is reported but not in the truth\n", extra.c_str());
  }
  for (const ObjectHistory& object : metrics.objects) {
    const std::optional<PoseError> error = object.final_error();
    const std::optional<double> median = object.median_detection_angle();
    if (!error || !median) continue;
    table += Format("%s: fused %.2f deg, median single detection %.2f deg\n",
                    object.model_id.c_str(),
                    error->angle / kDegree,
                    *median / kDegree);
  }
  table += Format(
      "limits: %.3g deg modulo symmetry, %.3g mm: %s\n",
      limits.rotation_deg,
      limits.position_mm,
      metrics.Within(limits.rotation_deg * kDegree, 1e-3 * limits.position_mm) ? "met" : "NOT met");
  return table;
}

std::string ViewTable(const RunMetrics& metrics) {
  std::string table = Format("%5s %-14s %15s %14s %12s %11s %14s %13s\n",
                             "view",
                             "object",
                             "detected (deg)",
                             "detected (mm)",
                             "fused (deg)",
                             "fused (mm)",
                             "refined (deg)",
                             "refined (mm)");
  size_t views = 0;
  for (const ObjectHistory& object : metrics.objects) views = std::max(views, object.fused.size());
  for (size_t view = 0; view < views; ++view) {
    for (const ObjectHistory& object : metrics.objects) {
      if (view >= object.fused.size()) continue;
      table += Format("%5zu %-14s %15s %14s %12s %11s %14s %13s\n",
                      view + 1,
                      object.model_id.c_str(),
                      Angle(object.detected[view], 2).c_str(),
                      Distance(object.detected[view], 2).c_str(),
                      Angle(object.fused[view], 2).c_str(),
                      Distance(object.fused[view], 2).c_str(),
                      Angle(RefinedAt(object, view), 3).c_str(),
                      Distance(RefinedAt(object, view), 2).c_str());
    }
  }
  return table;
}

std::string ErrorsCsv(const RunMetrics& metrics) {
  std::string csv =
      "object,instance,view,detected_deg,detected_mm,fused_deg,fused_mm,refined_deg,refined_mm\n";
  for (const ObjectHistory& object : metrics.objects) {
    for (size_t view = 0; view < object.fused.size(); ++view) {
      csv += Format("%s,%d,%zu,%s,%s,%s,%s,%s,%s\n",
                    object.model_id.c_str(),
                    object.instance.value_or(-1),
                    view + 1,
                    Angle(object.detected[view], 6).c_str(),
                    Distance(object.detected[view], 6).c_str(),
                    Angle(object.fused[view], 6).c_str(),
                    Distance(object.fused[view], 6).c_str(),
                    Angle(RefinedAt(object, view), 6).c_str(),
                    Distance(RefinedAt(object, view), 6).c_str());
    }
  }
  return csv;
}

std::string ReportJson(const RunMetrics& metrics, const ReportLimits& limits) {
  nlohmann::json objects = nlohmann::json::array();
  for (const ObjectHistory& object : metrics.objects) {
    nlohmann::json views = nlohmann::json::array();
    for (size_t i = 0; i < object.fused.size(); ++i) {
      views.push_back({{"detected", Json(object.detected[i])},
                       {"fused", Json(object.fused[i])},
                       {"refined", Json(RefinedAt(object, i))}});
    }
    const std::optional<double> median = object.median_detection_angle();
    objects.push_back(
        {{"model", object.model_id},
         {"instance", object.instance ? nlohmann::json(*object.instance) : nlohmann::json(nullptr)},
         {"error", Json(object.final_error())},
         {"refined_error", Json(object.final_refined_error())},
         {"median_detection_deg",
          median ? nlohmann::json(*median / kDegree) : nlohmann::json(nullptr)},
         {"num_views", object.num_views},
         {"converged", object.converged},
         {"seconds", object.seconds},
         {"views", views}});
  }
  const nlohmann::json report = {
      {"limits", {{"rotation_deg", limits.rotation_deg}, {"position_mm", limits.position_mm}}},
      {"met", metrics.Within(limits.rotation_deg * kDegree, 1e-3 * limits.position_mm)},
      {"objects", objects},
      {"extra", metrics.extra}};
  // Names come from the log: what is no UTF-8 in them is replaced.
  return report.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace vantage
