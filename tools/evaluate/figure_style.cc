#include "tools/evaluate/figure_style.h"

#include <algorithm>
#include <cmath>

#include "common/format.h"
#include "tools/evaluate/report_numbers.h"

namespace vantage {
namespace {

constexpr const char* kReplacement = "\xEF\xBF\xBD";

// Bytes of the UTF-8 character at the front, 0 where there is none.
size_t CharacterLength(std::string_view text) {
  const auto first = static_cast<unsigned char>(text.front());
  if (first < 0x80) return 1;
  const size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || text.size() < length) return 0;
  for (size_t i = 1; i < length; ++i) {
    if ((static_cast<unsigned char>(text[i]) & 0xc0U) != 0x80U) return 0;
  }
  return length;
}

std::string Quoted(std::string_view text, size_t longest, std::string_view after) {
  std::string quoted = "'";
  for (size_t count = 0; !text.empty(); ++count) {
    if (count == longest) {
      quoted += "…";
      break;
    }
    const size_t length = CharacterLength(text);
    const auto first = static_cast<unsigned char>(text.front());
    if (length == 0 || first < 0x20 || first == 0x7f) {
      quoted += kReplacement;
    } else if (first == '\'') {
      quoted += "''";
    } else {
      quoted += text.substr(0, length);
    }
    text.remove_prefix(std::max<size_t>(length, 1));
  }
  return quoted + std::string(after) + "'";
}

}  // namespace

std::string FigureHead(int width, int height, int font_size) {
  return Format(
      "set terminal svg noenhanced size %d,%d dynamic font 'sans-serif,%d' background '#ffffff'\n"
      "set border 3 lc rgb '#888888'\nset tics nomirror textcolor rgb '%s'\n"
      "set grid lc rgb '#e3e6ea' lw 0.7\nset format '%%g'\nunset key\nset datafile missing 'NaN'\n",
      width,
      height,
      font_size,
      kInkColor);
}

std::string FigureText(std::string_view text, size_t longest) { return Quoted(text, longest, ""); }

std::string FigureLabel(const MethodInfo& method, size_t longest) {
  return Quoted(MethodName(method), longest, method.is_past_paper ? " *" : "");
}

const char* MethodColor(const MethodInfo& method) {
  return method.is_histogram ? kOursColor : kOtherColor;
}

std::string DataNumber(double value) {
  return std::isfinite(value) ? Format("%.6g", value) : "NaN";
}

double DrawnError(double error_deg) {
  return std::isnan(error_deg) ? error_deg : std::max(error_deg, kSmallestDrawnDeg);
}

std::string PlacePanel(const PanelPlace& place) {
  return Format(
      "set lmargin at screen %.4f\nset rmargin at screen %.4f\n"
      "set bmargin at screen %.4f\nset tmargin at screen %.4f\n",
      place.left,
      place.right,
      place.bottom,
      place.top);
}

double RowOfMethod(const EvaluationResults& results, size_t method) {
  return static_cast<double>(results.methods.size() - method);
}

std::string MethodRows(const EvaluationResults& results, bool names) {
  std::string script = "unset label\nunset object\nset grid noytics xtics\nunset ytics\n";
  script += Format("set yrange [0.4:%.1f]\n", static_cast<double>(results.methods.size()) + 0.6);
  for (size_t i = 0; i < results.methods.size(); ++i) {
    const double row = RowOfMethod(results, i);
    const bool best = results.methods[i].id == results.best_ours;
    if (best) {
      script += Format(
          "set object rectangle from graph 0, first %.2f to graph 1, first %.2f behind "
          "fc rgb '#dcebfa' fs solid noborder\n",
          row - 0.45,
          row + 0.45);
    }
    if (names) {
      script += Format("set label %s at graph -0.03, first %.2f right textcolor rgb '%s'\n",
                       FigureLabel(results.methods[i], 26).c_str(),
                       row,
                       results.methods[i].is_histogram ? kOursColor : kInkColor);
    }
  }
  return script;
}

std::string LogarithmicRange(char axis, double low, double high) {
  const double bottom = std::pow(10.0, std::floor(std::log10(low) + 1e-9));
  const double decade = std::pow(10.0, std::ceil(std::log10(high) - 1e-9));
  // No error lies in most of the decade above 100.
  const double top = decade > 999.0 && high < 200.0 ? 250.0 : std::max(decade, 10.0 * bottom);
  return Format("set logscale %c\nset %crange [%g:%g]\n", axis, axis, bottom, top);
}

}  // namespace vantage
