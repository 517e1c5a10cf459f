#include "tools/support/view_choice_figure.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "common/format.h"
#include "common/so3.h"
#include "tools/support/gnuplot.h"

namespace vantage {
namespace {

constexpr size_t kMostCandidates = 5000;  // More are left out of a picture.

// Place on the map, deg from straight down along x and y; nothing for what is no pose.
Result<Eigen::Vector2d> PlaceOnMap(const view_candidate_t& candidate) {
  const Result<Pose> pose = PoseFromWire(candidate.trans, candidate.quat);
  if (!pose) return pose.error();
  const Eigen::Vector3d to_camera = -(pose->linear() * Eigen::Vector3d::UnitZ());
  const double from_vertical = std::acos(std::clamp(to_camera.z(), -1.0, 1.0)) / kDegree;
  const double azimuth = std::atan2(to_camera.y(), to_camera.x());
  return Eigen::Vector2d(from_vertical * std::cos(azimuth), from_vertical * std::sin(azimuth));
}

void AppendBlock(const std::string& name, const std::string& lines, std::string* script) {
  *script += Format("$%s << END\n", name.c_str()) + lines + "END\n";
}

// "refused by the robot" of "refused by the robot: out of reach at 1.2 m".
std::string KindOf(const std::string& reason) { return reason.substr(0, reason.find(": ")); }

}  // namespace

Result<std::string> ViewChoiceFigure(const next_view_t& decision) {
  std::string open;
  std::string rejected;
  std::string selected;
  double largest = 0.0;
  const size_t count = std::min(decision.candidates.size(), kMostCandidates);
  for (size_t i = 0; i < count; ++i) {
    const view_candidate_t& candidate = decision.candidates[i];
    const Result<Eigen::Vector2d> place = PlaceOnMap(candidate);
    if (!place || !std::isfinite(candidate.gain)) continue;
    const std::string line = Format("%.2f %.2f %.6g\n", place->x(), place->y(), candidate.gain);
    if (static_cast<int32_t>(i) == decision.selected) selected = line;
    (candidate.reason.empty() ? open : rejected) += line;
    if (candidate.reason.empty()) largest = std::max(largest, candidate.gain);
  }
  if (open.empty() && rejected.empty()) return std::string();
  std::string script =
      "set terminal svg noenhanced size 420,360 dynamic font 'sans-serif,13' background "
      "'#ffffff'\nset size ratio -1\nunset border\nunset tics\nunset key\n"
      "set xrange [-95:95]\nset yrange [-95:95]\n"
      "set palette defined (0 '#e3e8ee', 0.5 '#6aa6d8', 1 '#123a6b')\n";
  script +=
      Format("set cbrange [0:%g]\nset cbtics\nset cblabel 'gain'\n", largest > 0.0 ? largest : 1.0);
  for (const int ring : {30, 60, 90}) {
    script += Format("set object circle at 0,0 size %d fs empty border lc rgb '#cccccc'\n", ring);
    if (ring == 90) continue;
    script +=
        Format("set label '%d°' at 0,%d center offset 0,0.5 tc rgb '#888888'\n", 90 - ring, ring);
  }
  std::string plots;
  const auto add = [&](const char* name, const std::string& lines, const char* style) {
    if (lines.empty()) return;
    AppendBlock(name, lines, &script);
    if (!plots.empty()) plots += ", ";
    plots += Format("$%s using 1:2:3 %s", name, style);
  };
  add("rejected", rejected, "with points pt 2 ps 0.35 lc rgb '#aaaaaa'");
  add("open", open, "with points pt 7 ps 0.55 lc palette");
  add("selected", selected, "with points pt 6 ps 1.7 lw 3 lc rgb '#d1495b'");
  return RunGnuplot(script + "plot " + plots + "\n");
}

std::string RejectionText(const next_view_t& decision) {
  if (decision.candidates.empty()) return {};
  std::map<std::string, int> counts;
  int num_rejected = 0;
  for (const view_candidate_t& candidate : decision.candidates) {
    if (candidate.reason.empty()) continue;
    ++counts[KindOf(candidate.reason)];
    ++num_rejected;
  }
  std::vector<std::pair<std::string, int>> kinds(counts.begin(), counts.end());
  std::ranges::stable_sort(kinds, [](const auto& a, const auto& b) { return a.second > b.second; });
  std::string text = Format("%zu candidates by %s, %d of them rejected",
                            decision.candidates.size(),
                            decision.criterion.c_str(),
                            num_rejected);
  constexpr size_t kMostKinds = 4;
  for (size_t i = 0; i < std::min(kinds.size(), kMostKinds); ++i) {
    text += i == 0 ? ": " : ", ";
    text += Format("%d %s", kinds[i].second, kinds[i].first.c_str());
  }
  return text + ".";
}

}  // namespace vantage
