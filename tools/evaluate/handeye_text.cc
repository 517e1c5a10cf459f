#include "tools/evaluate/handeye_text.h"

#include "common/format.h"
#include "tools/support/csv_field.h"

namespace vantage {
namespace {

std::string IntervalFields(const Interval& interval) {
  return Format(",%s,%s,%s",
                CsvField(interval.value).c_str(),
                CsvField(interval.low).c_str(),
                CsvField(interval.high).c_str());
}

}  // namespace

std::string HandEyeText(const HandEyeResults& results) {
  std::string text;
  std::string group;
  for (const HandEyeCell& cell : results.cells) {
    const std::string of = Format("%s, %d views, %.0f %% outliers",
                                  cell.setup.c_str(),
                                  cell.views,
                                  100.0 * cell.outlier_share);
    if (of != group) {
      group = of;
      text += Format("\n%s\n%-32s %22s %22s %20s %14s %9s\n",
                     of.c_str(),
                     "",
                     "median mm [95 %]",
                     "median deg [95 %]",
                     "RMSE mm, deg",
                     "by the bound",
                     "ms");
    }
    text +=
        Format("%-32s %7.3f [%5.3g, %5.3g] %7.4f [%5.3g, %5.3g] %10.4g %9.4g %6.4g, %6.4g %9.2f\n",
               cell.method.c_str(),
               cell.median_mm.value,
               cell.median_mm.low,
               cell.median_mm.high,
               cell.median_deg.value,
               cell.median_deg.low,
               cell.median_deg.high,
               cell.rmse_mm.value,
               cell.rmse_deg.value,
               cell.ratio_translation.value,
               cell.ratio_rotation.value,
               cell.median_ms);
  }
  text += Format("\n%-40s %10s %22s %14s %13s\n",
                 "of itself",
                 "trials",
                 "coverage % [95 %]",
                 "false alarms %",
                 "wrong views %");
  for (const HandEyeSelfTest& test : results.self_tests) {
    text += Format("%-40s %10d %7.1f [%5.1f, %5.1f] %14.2f %13.3f\n",
                   Format("%s, %d views, %.0f %% outliers",
                          test.setup.c_str(),
                          test.views,
                          100.0 * test.outlier_share)
                       .c_str(),
                   test.trials,
                   100.0 * test.coverage.value,
                   100.0 * test.coverage.low,
                   100.0 * test.coverage.high,
                   100.0 * test.false_alarms.value,
                   100.0 * test.wrong_views);
  }
  text += "\ndegenerate motions flagged\n";
  for (const HandEyeDegenerate& counted : results.degenerate) {
    text += Format("%s, %s, %.0f %% outliers: %d of %d (%s)\n",
                   counted.motion.c_str(),
                   counted.setup.c_str(),
                   100.0 * counted.outlier_share,
                   counted.flagged,
                   counted.trials,
                   counted.reason.c_str());
  }
  text += "\n";
  for (const HandEyeBar& bar : results.bars) {
    text += Format("%s %s: %.3f %s\n",
                   bar.met ? "met   " : "MISSED",
                   bar.name.c_str(),
                   bar.value,
                   bar.unit.c_str());
  }
  return text;
}

std::string HandEyeCsv(const HandEyeResults& results) {
  std::string csv = "method,setup,views,outlier_share,trials,failed";
  for (const char* name :
       {"median_mm", "median_deg", "rmse_mm", "rmse_deg", "ratio_translation", "ratio_rotation"}) {
    csv += Format(",%s,%s_low,%s_high", name, name, name);
  }
  csv += ",median_ms,least_ms\n";
  for (const HandEyeCell& cell : results.cells) {
    csv += Format("%s,%s,%d,%g,%d,%d",
                  CsvField(std::string_view(cell.method)).c_str(),
                  CsvField(std::string_view(cell.setup)).c_str(),
                  cell.views,
                  cell.outlier_share,
                  cell.trials,
                  cell.failed);
    for (const Interval* interval : {&cell.median_mm,
                                     &cell.median_deg,
                                     &cell.rmse_mm,
                                     &cell.rmse_deg,
                                     &cell.ratio_translation,
                                     &cell.ratio_rotation}) {
      csv += IntervalFields(*interval);
    }
    csv += Format(",%s,%s\n", CsvField(cell.median_ms).c_str(), CsvField(cell.least_ms).c_str());
  }
  return csv;
}

}  // namespace vantage
