#include "tools/evaluate/confusion_text.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/format.h"
#include "tools/evaluate/report_numbers.h"
#include "tools/support/csv_field.h"

namespace vantage {
namespace {

// Keeps the order of the members.
using Json = nlohmann::ordered_json;

Json ToJson(const Interval& interval) {
  return {{"value", interval.value}, {"low", interval.low}, {"high", interval.high}};
}

Json ToJson(const TableFacts& table) {
  Json confused_by = Json::array();
  for (const ConfusedBy& one : table.confused_by) {
    confused_by.push_back({{"angle_deg", one.angle_deg},
                           {"axis", {one.axis.x(), one.axis.y(), one.axis.z()}},
                           {"share", one.share},
                           {"largest_share", one.largest_share}});
  }
  return {{"model_id", table.model_id},
          {"symmetry", table.symmetry},
          {"num_directions", table.num_directions},
          {"num_rows", table.num_rows},
          {"num_trials", table.num_trials},
          {"missed", table.missed},
          {"right", table.right},
          {"num_modes", table.num_modes},
          {"confused_by", confused_by}};
}

Json ToJson(const ReweightingTable& table) {
  Json methods = Json::array();
  for (const MethodInfo& method : table.methods) {
    methods.push_back(
        {{"id", method.id}, {"label", method.label}, {"parameters", method.parameters}});
  }
  return {{"k", table.k},
          {"methods", methods},
          {"model_ids", table.model_ids},
          {"final_deg", table.final_deg}};
}

Json ToJson(const PeakFacts& peaks) {
  return {{"model_id", peaks.model_id},
          {"method", peaks.method},
          {"views", peaks.views},
          {"num_peaks", peaks.num_peaks},
          {"best_deg", peaks.best_deg},
          {"share_of_best", peaks.share_of_best},
          {"highest", peaks.highest},
          {"others_deg", peaks.others_deg}};
}

Json ToJson(const StepQuartiles& line) {
  return {{"model_id", line.model_id},
          {"strategy", line.strategy},
          {"detection_low", line.detection_low},
          {"detection_median", line.detection_median},
          {"detection_high", line.detection_high},
          {"final_low", line.final_low},
          {"final_median", line.final_median},
          {"final_high", line.final_high}};
}

Json ToJson(const ViewsNeeded& needed) {
  return {{"mean", ToJson(needed.mean)},
          {"median", needed.median},
          {"reached_mean", needed.reached_mean},
          {"never_share", needed.never_share},
          {"final_right", needed.final_right},
          {"less_random", ToJson(needed.less_random)},
          {"less_heuristic", ToJson(needed.less_heuristic)},
          {"claims", needed.claims},
          {"claims_right", needed.claims_right}};
}

Json ToJson(const CalibrationBin& bin) {
  return {{"low", bin.low},
          {"high", bin.high},
          {"count", bin.count},
          {"mean_mass", bin.mean_mass},
          {"right", bin.right}};
}

Json ToJson(const ConfusionBar& bar) {
  return {{"name", bar.name},
          {"value", bar.value},
          {"low", bar.low},
          {"high", bar.high},
          {"bar", bar.bar},
          {"unit", bar.unit},
          {"met", bar.met}};
}

Json ToJson(const ObjectViewsNeeded& object);

template <class T>
Json ListToJson(const std::vector<T>& list) {
  Json json = Json::array();
  for (const T& item : list) json.push_back(ToJson(item));
  return json;
}

Json ToJson(const ObjectViewsNeeded& object) {
  return {{"model_id", object.model_id},
          {"symmetry", object.symmetry},
          {"strategies", ListToJson(object.strategies)},
          {"held", object.held}};
}

std::string NeededLine(const std::string& label, const ViewsNeeded& needed) {
  return Format(
      "  %-20s %5.2f (%.2f..%.2f)  median %4.1f  reached %5.2f  never %5.1f %%  "
      "right at the end %5.1f %%\n",
      label.c_str(),
      needed.mean.value,
      needed.mean.low,
      needed.mean.high,
      needed.median,
      needed.reached_mean,
      100.0 * needed.never_share,
      100.0 * needed.final_right);
}

std::string ReweightingText(const ReweightingTable& table) {
  std::string text =
      Format("Final errors after a circle at k = %d, degrees, median (quartiles):\n", table.k);
  for (size_t object = 0; object < table.model_ids.size(); ++object) {
    text += Format("  %s\n", table.model_ids[object].c_str());
    for (size_t m = 0; m < table.methods.size(); ++m) {
      text += Format("    %-28s %s\n",
                     table.methods[m].label.c_str(),
                     ErrorsText(table.final_deg[object][m]).c_str());
    }
  }
  return text;
}

void AppendLine(const std::vector<std::string>& fields, std::string* text) {
  for (size_t i = 0; i < fields.size(); ++i) {
    if (i > 0) *text += ',';
    *text += fields[i];
  }
  *text += '\n';
}

}  // namespace

std::string ErrorsText(const std::vector<double>& errors_deg) {
  const std::vector<double> errors = WithMissing(errors_deg);
  return Format(
      "%.2f (%.2f..%.2f)", Median(errors), Quantile(errors, 0.25), Quantile(errors, 0.75));
}

std::string ConfusionText(const ConfusionResults& results) {
  std::string text;
  for (const TableFacts& table : results.tables) {
    text += Format("%-12s %4d directions, %6lld trials: right %5.1f %%, missed %4.1f %%, %d modes",
                   table.model_id.c_str(),
                   table.num_directions,
                   static_cast<long long>(table.num_trials),
                   100.0 * table.right,
                   100.0 * table.missed,
                   table.num_modes);
    for (const ConfusedBy& one : table.confused_by) {
      text += Format("; %.0f deg %.1f %%", one.angle_deg, 100.0 * one.share);
    }
    text += "\n";
  }
  text += "\n";
  for (const ReweightingTable& table : results.reweighting) text += ReweightingText(table) + "\n";
  for (const PeakFacts& peaks : results.peaks) {
    text += Format("%-10s %-5s after %2d views: %d peaks, the heaviest %.2f deg off\n",
                   peaks.model_id.c_str(),
                   peaks.method.c_str(),
                   peaks.views,
                   peaks.num_peaks,
                   peaks.best_deg);
  }
  if (results.objects.empty()) return text;
  text += Format("\nViews until the right mode holds %.0f %%, over %zu objects:\n",
                 100.0 * results.enough,
                 results.objects.size());
  for (size_t s = 0; s < results.strategies.size(); ++s) {
    text += NeededLine(results.strategies[s], results.all_objects[s]);
  }
  text += "By object, means:\n";
  for (const ObjectViewsNeeded& object : results.objects) {
    text += Format("  %-14s", object.model_id.c_str());
    for (size_t s = 0; s < results.strategies.size(); ++s) {
      text += Format("  %s %.2f", results.strategies[s].c_str(), object.strategies[s].mean.value);
    }
    text += "\n";
  }
  for (const ConfusionBar& bar : results.bars) {
    text += Format("%s %s: %.3g (%.3g..%.3g), bar %g\n",
                   bar.met ? "met   " : "MISSED",
                   bar.name.c_str(),
                   bar.value,
                   bar.low,
                   bar.high,
                   bar.bar);
  }
  return text;
}

std::string ConfusionJson(const ConfusionResults& results) {
  const Json json = {{"command", results.command},
                     {"version", results.version},
                     {"seed", results.seed},
                     {"circles", results.circles},
                     {"sequences", results.sequences},
                     {"views", results.views},
                     {"candidates", results.candidates},
                     {"enough", results.enough},
                     {"right_angle_deg", results.right_angle_deg},
                     {"tables", ListToJson(results.tables)},
                     {"reweighting", ListToJson(results.reweighting)},
                     {"peaks", ListToJson(results.peaks)},
                     {"steps", ListToJson(results.steps)},
                     {"strategies", results.strategy_ids},
                     {"objects", ListToJson(results.objects)},
                     {"all_objects", ListToJson(results.all_objects)},
                     {"ratio_to_random", ToJson(results.ratio_to_random)},
                     {"ratio_to_heuristic", ToJson(results.ratio_to_heuristic)},
                     {"calibration", ListToJson(results.calibration)},
                     {"bars", ListToJson(results.bars)}};
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string ReweightingCsv(const ConfusionResults& results) {
  std::string text = "k,object,method,circle,final_deg\n";
  for (const ReweightingTable& table : results.reweighting) {
    for (size_t object = 0; object < table.model_ids.size(); ++object) {
      for (size_t m = 0; m < table.methods.size(); ++m) {
        const std::vector<double>& errors = table.final_deg[object][m];
        for (size_t circle = 0; circle < errors.size(); ++circle) {
          AppendLine({std::to_string(table.k),
                      CsvField(table.model_ids[object]),
                      CsvField(table.methods[m].id),
                      std::to_string(circle),
                      CsvField(errors[circle])},
                     &text);
        }
      }
    }
  }
  return text;
}

std::string ViewsNeededCsv(const ConfusionResults& results) {
  std::string text = "object,strategy,sequence,views\n";
  for (const ObjectViewsNeeded& object : results.objects) {
    for (size_t s = 0; s < object.held.size(); ++s) {
      for (size_t i = 0; i < object.held[s].size(); ++i) {
        AppendLine({CsvField(object.model_id),
                    CsvField(results.strategy_ids[s]),
                    std::to_string(i),
                    CsvField(object.held[s][i])},
                   &text);
      }
    }
  }
  return text;
}

std::string StepsCsv(const ConfusionResults& results) {
  std::string text =
      "object,strategy,view,detection_low,detection_median,detection_high,final_low,final_median,"
      "final_high\n";
  for (const StepQuartiles& line : results.steps) {
    for (size_t view = 0; view < line.final_median.size(); ++view) {
      AppendLine({CsvField(line.model_id),
                  CsvField(line.strategy),
                  std::to_string(view + 1),
                  CsvField(line.detection_low[view]),
                  CsvField(line.detection_median[view]),
                  CsvField(line.detection_high[view]),
                  CsvField(line.final_low[view]),
                  CsvField(line.final_median[view]),
                  CsvField(line.final_high[view])},
                 &text);
    }
  }
  return text;
}

}  // namespace vantage
