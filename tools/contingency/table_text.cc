#include "tools/contingency/table_text.h"

#include <algorithm>
#include <optional>

#include "common/format.h"
#include "common/so3.h"
#include "fusion/confusion/direction_grid.h"
#include "fusion/so3_grid.h"
#include "tools/contingency/trial_units.h"

namespace vantage {
namespace {

constexpr size_t kShown = 10;  // Directions.

DirectionSummary Summarize(int32_t direction, const DirectionTrials& trials) {
  DirectionSummary summary{direction, trials.trials, trials.missed, 0};
  for (const DifferenceCount& difference : trials.differences) {
    const bool is_turned =
        GeodesicAngle(difference.Difference(), Eigen::Quaterniond::Identity()) >= kTurned;
    if (is_turned) summary.turned += difference.count;
  }
  return summary;
}

// Every line of a text of several, with blanks before it.
std::string Indented(const std::string& lines) {
  std::string text;
  for (size_t begin = 0; begin < lines.size();) {
    const size_t end = std::min(lines.find('\n', begin), lines.size());
    text += "    ";
    text += lines.substr(begin, end - begin);
    text += '\n';
    begin = end + 1;
  }
  return text;
}

std::string KeyText(const ContingencyKey& key) {
  std::string text;
  text += Format("model        %s, mesh %s\n", key.model_id.c_str(), key.mesh_hash.c_str());
  text += Format("estimator    %s\n", key.estimator.c_str());
  text += Indented(key.estimator_parameters);
  text += "sensor\n" + Indented(key.sensor) + "stopping\n" + Indented(key.stopping);
  text += Format("seed         %ju\n", uintmax_t{key.seed});
  return text;
}

std::string AmbiguousText(const std::vector<DirectionSummary>& summaries,
                          const DirectionGrid& grid) {
  std::string text =
      Format("most ambiguous directions (turned: by %.0f deg or more)\n", kTurned / kDegree);
  text += "  direction     x      y      z   trials  missed  turned\n";
  for (size_t i = 0; i < std::min(kShown, summaries.size()); ++i) {
    const DirectionSummary& summary = summaries[i];
    const Eigen::Vector3d center = grid.Center(summary.direction);
    text += Format("  %9d %6.2f %6.2f %6.2f %7d %6.1f %% %5.1f %%\n",
                   summary.direction,
                   center.x(),
                   center.y(),
                   center.z(),
                   summary.trials,
                   100.0 * summary.missed / summary.trials,
                   100.0 * summary.turned / summary.trials);
  }
  return text;
}

std::string DirectionsText(const ContingencyTable& table) {
  const std::vector<DirectionSummary> summaries = SummarizeDirections(table);
  std::string text =
      Format("directions   %zu of %d measured", summaries.size(), table.key.num_directions);
  const std::vector<int32_t> missing = MissingDirections(table);
  if (!missing.empty()) text += ", missing " + RangesText(missing, kShown);
  text += '\n';
  if (summaries.empty()) return text;
  int64_t trials = 0;
  int64_t missed = 0;
  int64_t turned = 0;
  for (const DirectionSummary& summary : summaries) {
    trials += summary.trials;
    missed += summary.missed;
    turned += summary.turned;
  }
  text += Format("             %.0f trials each, %.1f %% missed, %.1f %% turned\n",
                 static_cast<double>(trials) / static_cast<double>(summaries.size()),
                 100.0 * static_cast<double>(missed) / static_cast<double>(trials),
                 100.0 * static_cast<double>(turned) / static_cast<double>(trials));
  return text + AmbiguousText(summaries, DirectionGrid(table.key.num_directions));
}

}  // namespace

double DirectionSummary::Ambiguity() const {
  return trials == 0 ? 0.0 : static_cast<double>(missed + turned) / trials;
}

std::vector<DirectionSummary> SummarizeDirections(const ContingencyTable& table) {
  std::vector<DirectionSummary> summaries;
  for (size_t i = 0; i < table.directions.size(); ++i) {
    if (table.directions[i].trials == 0) continue;
    summaries.push_back(Summarize(static_cast<int32_t>(i), table.directions[i]));
  }
  std::stable_sort(summaries.begin(), summaries.end(), [](const auto& a, const auto& b) {
    return a.Ambiguity() > b.Ambiguity();
  });
  return summaries;
}

std::vector<int32_t> MissingDirections(const ContingencyTable& table) {
  std::vector<int32_t> missing;
  for (int32_t i = 0; i < table.key.num_directions; ++i) {
    const auto place = static_cast<size_t>(i);
    if (place >= table.directions.size() || table.directions[place].trials == 0) {
      missing.push_back(i);
    }
  }
  return missing;
}

std::string TableText(const ContingencyTable& table, uintmax_t bytes) {
  std::string text = KeyText(table.key);
  text += Format("trials       %jd\nsize         %.2f MB\n",
                 intmax_t{table.NumTrials()},
                 1e-6 * static_cast<double>(bytes));
  if (table.key.rows_k > 0) {
    text += Format("rows         %zu of %d of k = %d\n",
                   table.rows.size(),
                   So3Grid(table.key.rows_k).num_cells(),
                   table.key.rows_k);
  }
  if (table.key.num_directions > 0) text += DirectionsText(table);
  return text;
}

std::string TableCsv(const ContingencyTable& table) {
  std::vector<DirectionSummary> summaries = SummarizeDirections(table);
  std::sort(summaries.begin(), summaries.end(), [](const auto& a, const auto& b) {
    return a.direction < b.direction;
  });
  std::string text = "direction,x,y,z,trials,missed,turned\n";
  std::optional<DirectionGrid> grid;
  if (table.key.num_directions > 0) grid.emplace(table.key.num_directions);
  for (const DirectionSummary& summary : summaries) {
    const Eigen::Vector3d center = grid->Center(summary.direction);
    text += Format("%d,%.6f,%.6f,%.6f,%d,%d,%d\n",
                   summary.direction,
                   center.x(),
                   center.y(),
                   center.z(),
                   summary.trials,
                   summary.missed,
                   summary.turned);
  }
  return text;
}

}  // namespace vantage
