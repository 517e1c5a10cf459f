#include <algorithm>
#include <utility>
#include <vector>

#include "common/format.h"
#include "tools/support/log_comparison.h"

namespace vantage {
namespace {

std::string Columns(const std::vector<std::string>& cells, size_t first_width) {
  std::string line = Format("%-*s", static_cast<int>(first_width), cells.front().c_str());
  for (size_t i = 1; i < cells.size(); ++i) line += Format(" %11s", cells[i].c_str());
  return line + "\n";
}

std::string Size(double value) { return value > 0.0 ? Format("%.3g", value) : "0"; }
std::string Count(int64_t value) { return std::to_string(value); }

}  // namespace

std::string EventDifference::Describe(const std::array<std::string, 2>& names) const {
  std::string text = channel;
  if (utime != 0) text += Format(", utime %jd", intmax_t{utime});
  text += Format(", seq %jd: ", intmax_t{seq});
  if (!field) {
    const bool in_first = first_event >= 0;
    return text + Format("event %jd of the %s log has no match in the %s one",
                         intmax_t{in_first ? first_event : second_event},
                         names[in_first ? 0 : 1].c_str(),
                         names[in_first ? 1 : 0].c_str());
  }
  text += Format("event %jd of the %s log, %jd of the %s one\n  %s",
                 intmax_t{first_event},
                 names[0].c_str(),
                 intmax_t{second_event},
                 names[1].c_str(),
                 field->path.c_str());
  if (!field->size.empty()) text += " by " + field->size;
  text += Format("\n    %s: ", names[0].c_str()) + field->first;
  return text + Format("\n    %s: ", names[1].c_str()) + field->second;
}

std::string ComparisonText(const LogComparison& comparison,
                           const std::array<std::string, 2>& names) {
  size_t width = 8;
  for (const auto& [name, channel] : comparison.channels) width = std::max(width, name.size());
  std::string text = Columns(
      {"channel", names[0], names[1], "matched", "identical", "within", "mm", "deg", "other"},
      width);
  std::array<int64_t, 2> repeats{};
  int64_t late = 0;
  for (const auto& [name, channel] : comparison.channels) {
    text += Columns({name,
                     Count(channel.count[0]),
                     Count(channel.count[1]),
                     Count(channel.matched),
                     Count(channel.identical),
                     Count(channel.within),
                     Size(channel.position_mm),
                     Size(channel.angle_deg),
                     Size(channel.number)},
                    width);
    late += channel.late;
    for (const size_t side : {size_t{0}, size_t{1}}) repeats.at(side) += channel.repeats.at(side);
  }
  text += Format("Not compared: %s.\n", kNotCompared);
  if (repeats[0] + repeats[1] > 0) {
    text += Format("Sent again unchanged, and taken as one: %jd %s, %jd %s.\n",
                   intmax_t{repeats[0]},
                   names[0].c_str(),
                   intmax_t{repeats[1]},
                   names[1].c_str());
  }
  if (late > 0) {
    text += Format("The %s log ends before what answers its last %jd s: %jd messages.\n",
                   names[0].c_str(),
                   intmax_t{kAnswerTime_us / 1'000'000},
                   intmax_t{late});
  }
  for (const size_t side : {size_t{0}, size_t{1}}) {
    if (comparison.damage.at(side).empty()) continue;
    text += "Damage of the " + names.at(side) + " log: " + comparison.damage.at(side) + "\n";
  }
  const EventDifference* first = comparison.first();
  if (first == nullptr) return text + (comparison.clean() ? "No difference.\n" : "");
  return text + "First difference: " + first->Describe(names) + "\n";
}

}  // namespace vantage
