#include "tools/replay/sweep_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/format.h"
#include "tools/support/csv_field.h"

namespace vantage {
namespace {

using Json = nlohmann::ordered_json;

std::string IntervalText(const Interval& interval) {
  if (!std::isfinite(interval.value)) return "-";
  if (!std::isfinite(interval.low)) return Format("%.3f", interval.value);
  return Format("%.3f [%.3f, %.3f]", interval.value, interval.low, interval.high);
}

Json Number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json ToJson(const Interval& interval) {
  return {{"median", Number(interval.value)},
          {"low_95", Number(interval.low)},
          {"high_95", Number(interval.high)}};
}

Json ToJson(const std::optional<PoseError>& error) {
  if (!error) return {};
  return {{"rotation_deg", error->angle / kDegree}, {"position_mm", 1e3 * error->distance}};
}

Json ToJson(const SweepErrors& errors) {
  return {{"rotation_deg", ToJson(errors.rotation_deg)},
          {"position_mm", ToJson(errors.position_mm)}};
}

std::string CsvErrors(const std::optional<PoseError>& error) {
  if (!error) return ",,";
  return Format(
      ",%s,%s", CsvField(error->angle / kDegree).c_str(), CsvField(1e3 * error->distance).c_str());
}

}  // namespace

std::string SweepTable(const SweepGrid& grid, const std::vector<SweepCell>& cells) {
  std::vector<std::vector<std::string>> rows(1);
  for (const SweepParameter& each : grid.parameters) rows[0].push_back(each.key);
  for (const char* name :
       {"found", "extra", "fused deg", "fused mm", "refined deg", "refined mm"}) {
    rows[0].emplace_back(name);
  }
  for (size_t i = 0; i < cells.size(); ++i) {
    const SweepCell& cell = cells[i];
    std::vector<std::string> row;
    for (const ConfigOverride& each : grid.Overrides(i)) row.push_back(each.literal);
    row.push_back(Format("%d of %d", cell.num_found, cell.num_objects));
    row.push_back(std::to_string(cell.num_extra));
    for (const SweepErrors* errors : {&cell.fused, &cell.refined}) {
      row.push_back(IntervalText(errors->rotation_deg));
      row.push_back(IntervalText(errors->position_mm));
    }
    rows.push_back(row);
  }
  std::vector<size_t> widths(rows[0].size());
  for (const auto& row : rows) {
    for (size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const auto& row : rows) {
    for (size_t i = 0; i < row.size(); ++i) {
      text += Format("%s%*s", i == 0 ? "" : "  ", static_cast<int>(widths[i]), row[i].c_str());
    }
    text += "\n";
  }
  return text;
}

std::string SweepCsv(const SweepGrid& grid,
                     const std::vector<std::string>& logs,
                     const std::vector<SweepCell>& cells) {
  std::string text;
  for (const SweepParameter& each : grid.parameters) text += CsvField(each.key) + ',';
  text += "log,object,model,found,converged,views,fused_deg,fused_mm,refined_deg,refined_mm\n";
  for (size_t i = 0; i < cells.size(); ++i) {
    std::string start;
    for (const ConfigOverride& each : grid.Overrides(i)) start += CsvField(each.literal) + ',';
    for (size_t log = 0; log < cells[i].logs.size(); ++log) {
      const std::vector<SweepObject>& objects = cells[i].logs[log];
      for (size_t k = 0; k < objects.size(); ++k) {
        const SweepObject& object = objects[k];
        text += start + CsvField(logs[log]);
        text += Format(",%zu,", k) + CsvField(object.model_id);
        text +=
            Format(",%d,%d,%d", object.found ? 1 : 0, object.converged ? 1 : 0, object.num_views);
        text += CsvErrors(object.fused) + CsvErrors(object.refined) + "\n";
      }
    }
  }
  return text;
}

std::string SweepJson(const SweepGrid& grid,
                      const std::vector<std::string>& logs,
                      const std::vector<SweepCell>& cells) {
  Json json;
  for (const SweepParameter& each : grid.parameters) json["grid"][each.key] = each.literals;
  json["logs"] = logs;
  json["bootstrap_seed"] = kSweepSeed;
  json["cells"] = Json::array();
  for (size_t i = 0; i < cells.size(); ++i) {
    Json cell;
    for (const ConfigOverride& each : grid.Overrides(i)) {
      cell["parameters"][each.key] = each.literal;
    }
    cell["objects"] = cells[i].num_objects;
    cell["found"] = cells[i].num_found;
    cell["extra"] = cells[i].num_extra;
    cell["fused"] = ToJson(cells[i].fused);
    cell["refined"] = ToJson(cells[i].refined);
    cell["logs"] = Json::array();
    for (const std::vector<SweepObject>& log : cells[i].logs) {
      Json objects = Json::array();
      for (const SweepObject& object : log) {
        objects.push_back({{"model", object.model_id},
                           {"found", object.found},
                           {"converged", object.converged},
                           {"views", object.num_views},
                           {"fused", ToJson(object.fused)},
                           {"refined", ToJson(object.refined)}});
      }
      cell["logs"].push_back(objects);
    }
    json["cells"].push_back(cell);
  }
  // Of texts that are no UTF-8, as paths may be.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace vantage
