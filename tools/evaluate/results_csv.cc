#include "tools/evaluate/results_csv.h"

#include "tools/support/csv_field.h"

namespace vantage {
namespace {

std::string Fields(const Interval& interval) {
  return CsvField(interval.value) + "," + CsvField(interval.low) + "," + CsvField(interval.high);
}

void AppendViews(const std::string& head,
                 const std::vector<double>& plain,
                 const std::vector<double>& symmetric,
                 std::string* csv) {
  for (size_t view = 0; view < plain.size(); ++view) {
    *csv += head + "," + std::to_string(view + 1) + "," + CsvField(plain[view]) + "," +
            CsvField(symmetric[view]) + "\n";
  }
}

}  // namespace

std::string GridCsv(const EvaluationResults& results) {
  std::string csv = "k,num_cells,mean_deg,deviation_deg,megabytes,build_seconds\n";
  for (const GridStatistics& grid : results.grids) {
    csv += std::to_string(grid.k) + "," + std::to_string(grid.num_cells) + "," +
           CsvField(grid.mean_deg) + "," + CsvField(grid.deviation_deg) + "," +
           CsvField(grid.megabytes) + "," + CsvField(grid.build_seconds) + "\n";
  }
  return csv;
}

std::string SweepCsv(const EvaluationResults& results) {
  const ClusteringSweep& sweep = results.sweep;
  std::string csv = "w_min,w_max,mean_error_deg,wrong_mode_rate\n";
  for (size_t i = 0; i < sweep.w_min.size(); ++i) {
    for (size_t j = 0; j < sweep.w_max.size(); ++j) {
      if (sweep.w_min[i] > sweep.w_max[j]) continue;
      csv += CsvField(sweep.w_min[i]) + "," + CsvField(sweep.w_max[j]) + "," +
             CsvField(sweep.mean_error_deg[i][j]) + "," + CsvField(sweep.wrong_mode_rate[i][j]) +
             "\n";
    }
  }
  return csv;
}

std::string CircleCsv(const EvaluationResults& results) {
  std::string csv = "model,method,view,error_deg,error_symmetric_deg\n";
  for (const CircleErrors& object : results.circle) {
    const std::string model = CsvField(object.model_id);
    AppendViews(model + ",detection", object.detection_deg, object.detection_symmetric_deg, &csv);
    for (size_t method = 0; method < object.step_deg.size(); ++method) {
      AppendViews(model + "," + CsvField(results.methods[method].id),
                  object.step_deg[method],
                  object.step_symmetric_deg[method],
                  &csv);
    }
  }
  return csv;
}

std::string SequencesCsv(const EvaluationResults& results) {
  std::string csv = "model,sequence,method,error_deg\n";
  for (const SequenceErrors& object : results.sequences) {
    for (size_t method = 0; method < object.final_deg.size(); ++method) {
      for (size_t i = 0; i < object.final_deg[method].size(); ++i) {
        csv += CsvField(object.model_id) + "," + std::to_string(i + 1) + "," +
               CsvField(results.methods[method].id) + "," + CsvField(object.final_deg[method][i]) +
               "\n";
      }
    }
  }
  return csv;
}

std::string AccuracyCsv(const EvaluationResults& results) {
  std::string csv = "method,label,is_histogram,is_past_paper";
  for (const char* name : {"median_deg",
                           "mean_deg",
                           "wrong_mode_rate",
                           "median_difference_deg",
                           "difference_of_medians_deg",
                           "difference_of_wrong_mode_rates",
                           "early_wrong_mode_rate",
                           "difference_of_early_wrong_mode_rates",
                           "difference_to_blind_deg"}) {
    const std::string column = name;
    csv += "," + column + "," + column + "_low," + column + "_high";
  }
  csv += ",seconds_per_view,num_without_estimate\n";
  for (size_t i = 0; i < results.accuracy.size(); ++i) {
    const MethodInfo& method = results.methods[i];
    const MethodAccuracy& accuracy = results.accuracy[i];
    csv += CsvField(method.id) + "," + CsvField(method.label) +
           (method.is_histogram ? ",1" : ",0") + (method.is_past_paper ? ",1," : ",0,") +
           Fields(accuracy.median_deg) + "," + Fields(accuracy.mean_deg) + "," +
           Fields(accuracy.wrong_mode_rate) + "," + Fields(accuracy.median_difference_deg) + "," +
           Fields(accuracy.difference_of_medians_deg) + "," +
           Fields(accuracy.difference_of_wrong_mode_rates) + "," +
           Fields(accuracy.early_wrong_mode_rate) + "," +
           Fields(accuracy.difference_of_early_wrong_mode_rates) + "," +
           Fields(accuracy.difference_to_blind_deg) + "," + CsvField(accuracy.seconds_per_view) +
           "," + std::to_string(accuracy.num_without_estimate) + "\n";
  }
  return csv;
}

}  // namespace vantage
