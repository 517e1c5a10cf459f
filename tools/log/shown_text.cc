#include "tools/log/shown_text.h"

#include <array>
#include <ctime>

#include "common/format.h"
#include "common/time_range.h"

namespace vantage {
namespace {

std::string Text(int64_t utime, std::tm* (*convert)(const std::time_t*, std::tm*)) {
  if (!IsPlausibleUtime(utime)) return Format("%jd us", intmax_t{utime});
  const std::time_t seconds = utime / 1'000'000;
  std::tm parts{};
  convert(&seconds, &parts);
  std::array<char, 64> date{};
  std::array<char, 32> zone{};
  std::strftime(date.data(), date.size(), "%Y-%m-%d %H:%M:%S", &parts);
  std::strftime(zone.data(), zone.size(), "%Z", &parts);
  return Format("%s.%06jd %s", date.data(), intmax_t{utime % 1'000'000}, zone.data());
}

}  // namespace

std::string UtcText(int64_t utime) {
  std::string text = Text(utime, gmtime_r);
  const size_t zone = text.find("GMT");
  return zone == std::string::npos ? text : text.replace(zone, 3, "UTC");
}

std::string LocalTimeText(int64_t utime) { return Text(utime, localtime_r); }

std::string BytesText(int64_t bytes) {
  const auto value = static_cast<double>(bytes);
  if (bytes < 1000) return Format("%jd bytes", intmax_t{bytes});
  if (value < 1e6) return Format("%.1f kB", 1e-3 * value);
  if (value < 1e9) return Format("%.1f MB", 1e-6 * value);
  return Format("%.1f GB", 1e-9 * value);
}

std::string Printable(std::string_view text) {
  std::string shown;
  for (const char letter : text) {
    if (letter >= ' ' && letter <= '~') {
      shown += letter;
    } else {
      shown += Format("\\x%02x", static_cast<unsigned>(static_cast<unsigned char>(letter)));
    }
  }
  return shown;
}

}  // namespace vantage
