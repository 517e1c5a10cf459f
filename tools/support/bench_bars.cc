#include "tools/support/bench_bars.h"

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <vector>

#include "common/format.h"

namespace vantage {
namespace {

// Empty text leaves the bar without a limit. False: neither that nor a positive number.
bool ParseLimit(std::string text, BenchBar* bar) {
  if (text.empty()) return true;
  bar->is_peers = text == "peer";
  if (bar->is_peers) return !bar->peer.empty();
  bar->is_least = text.rfind(">=", 0) == 0;
  if (bar->is_least) text.erase(0, 2);
  char* end = nullptr;
  bar->limit = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0' && *bar->limit > 0.0;
}

}  // namespace

Result<std::map<std::string, BenchBar>> ReadBenchBars(const std::filesystem::path& file,
                                                      const std::string& part) {
  std::ifstream stream(file);
  if (!stream) return Error{ErrorCode::kNotFound, "bars " + file.string() + " can't be read"};
  std::map<std::string, BenchBar> bars;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (line.empty() || line[0] == '#') continue;
    const std::string place = Format("%s:%d: ", file.c_str(), number);
    std::vector<std::string> fields;
    std::istringstream columns(line + ",");
    for (std::string field; std::getline(columns, field, ',');) fields.push_back(field);
    if (fields.size() != 4) {
      return Error{ErrorCode::kCorrupt, place + "expected part,benchmark,bar,peer"};
    }
    if (fields[0] != part) continue;
    BenchBar bar;
    bar.peer = fields[3];
    if (!ParseLimit(fields[2], &bar)) {
      return Error{ErrorCode::kCorrupt,
                   place + "bar \"" + fields[2] +
                       "\", expected a positive number, or peer where there is one"};
    }
    bar.is_optional = fields[1].starts_with('?');
    bars[fields[1].substr(bar.is_optional ? 1 : 0)] = bar;
  }
  return bars;
}

}  // namespace vantage
