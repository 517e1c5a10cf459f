#include "tools/monitor/shown_text.h"

#include <array>
#include <cmath>
#include <cstdint>

#include "common/format.h"

namespace vantage {

std::string Shown(std::string_view text, size_t most) {
  std::string shown(text.substr(0, most));
  for (char& c : shown) {
    if (c < 0x20 || c > 0x7e) c = '?';
  }
  if (text.size() > most && most > 0) shown.back() = '~';
  return shown;
}

std::string Padded(std::string_view text, size_t columns) {
  std::string padded = Shown(text, columns);
  padded.resize(columns, ' ');
  return padded;
}

std::string DurationText(double seconds) {
  if (!(seconds >= 0.0) || seconds > 1e12) return "-";
  const auto whole = static_cast<int64_t>(seconds);
  const auto part = [whole](int64_t unit, int64_t of) {
    return static_cast<int>(whole / unit % of);
  };
  if (whole >= 86400) {
    return Format(
        "%jdd%02d:%02d", static_cast<intmax_t>(whole / 86400), part(3600, 24), part(60, 60));
  }
  if (whole >= 3600) return Format("%d:%02d:%02d", part(3600, 24), part(60, 60), part(1, 60));
  return Format("%d:%02d", part(60, 60), part(1, 60));
}

std::string NumberText(double value) {
  if (!std::isfinite(value)) return "-";
  const double size = std::abs(value);
  if (size >= 1e6) return Format("%.0e", value);
  return Format(size < 9.95 ? "%.1f" : "%.0f", value);
}

std::string ScaledText(double bytes) {
  if (!std::isfinite(bytes)) return "-";
  constexpr std::array<const char*, 5> kUnits = {"", " k", " M", " G", " T"};
  size_t unit = 0;
  while (bytes >= 999.5 && unit + 1 < kUnits.size()) {
    bytes /= 1000.0;
    ++unit;
  }
  if (bytes >= 1e6) return Format("%.0e T", bytes);
  return Format(unit > 0 && bytes < 99.95 ? "%.1f%s" : "%.0f%s", bytes, kUnits[unit]);
}

std::string LatencyText(double seconds) {
  if (!std::isfinite(seconds)) return "-";
  const double size = std::abs(seconds);
  if (size >= 1e6) return Format("%.0e s", seconds);
  if (size >= 0.9995) return Format(size < 99.5 ? "%.1f s" : "%.0f s", seconds);
  if (size > 0.0 && size < 0.0000995) return Format("%.0f us", 1e6 * seconds);
  return Format(size < 0.00995 ? "%.1f ms" : "%.0f ms", 1e3 * seconds);
}

}  // namespace vantage
