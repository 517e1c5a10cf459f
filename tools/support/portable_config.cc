#include "tools/support/portable_config.h"

#include <toml++/toml.h>

#include <algorithm>
#include <functional>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "common/format.h"
#include "nodes/toml_position.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

// Where the paths of a set-up are, "*" for any key. "oni:" is what a path may come after; "none" is
// no path but says that there is none.
constexpr const char* kPathKeys[] = {"camera.*.device",
                                     "camera.*.calibration",
                                     "camera.*.record_oni",
                                     "models.folder",
                                     "confusion.tables.*",
                                     "extrinsics.calibration",
                                     "fusion.state_file",
                                     "up.record",
                                     "up.log_folder"};
constexpr std::string_view kRecording = "oni:";
constexpr std::string_view kNone = "none";

struct Replacement {
  size_t begin = 0;  // Bytes of the text.
  size_t end = 0;
  std::string value;
};

// Calls `visit` for every text that a key names.
void VisitTexts(const toml::node& node,
                std::string_view keys,
                const std::function<void(const toml::value<std::string>&)>& visit) {
  if (keys.empty()) {
    if (const toml::value<std::string>* text = node.as_string()) visit(*text);
    return;
  }
  const toml::table* table = node.as_table();
  if (table == nullptr) return;
  const size_t dot = std::min(keys.find('.'), keys.size());
  const std::string_view first = keys.substr(0, dot);
  const std::string_view rest = keys.substr(std::min(dot + 1, keys.size()));
  for (const auto& [key, child] : *table) {
    if (first == "*" || key.str() == first) VisitTexts(child, rest, visit);
  }
}

// What stands for a text that may be a relative path; as it was if it is none.
std::string Absolute(const std::string& value, std::string_view keys, const fs::path& folder) {
  const bool is_device = keys.ends_with(".device");
  if (value.empty() || value == kNone || (is_device && !value.starts_with(kRecording))) {
    return value;
  }
  const std::string prefix(is_device ? kRecording : "");
  return prefix + (folder / value.substr(prefix.size())).lexically_normal().string();
}

}  // namespace

Result<std::string> PortableConfigText(const std::string& text, const fs::path& folder) {
  std::vector<Replacement> replacements;
  try {
    const toml::table root = toml::parse(text);
    for (const std::string_view keys : kPathKeys) {
      VisitTexts(root, keys, [&](const toml::value<std::string>& node) {
        const std::string value = Absolute(node.get(), keys, fs::absolute(folder));
        if (value == node.get()) return;
        std::ostringstream literal;
        literal << toml::value<std::string>(value);
        replacements.push_back({.begin = OffsetOf(text, node.source().begin),
                                .end = OffsetOf(text, node.source().end),
                                .value = literal.str()});
      });
    }
  } catch (const toml::parse_error& error) {
    return Error{ErrorCode::kCorrupt,
                 Format("configuration line %u: no valid TOML: %s",
                        static_cast<unsigned>(error.source().begin.line),
                        std::string(error.description()).c_str())};
  }
  // From the end, so that what is before stays where it was.
  std::ranges::sort(replacements, std::greater<>(), &Replacement::begin);
  std::string portable = text;
  for (const Replacement& each : replacements) {
    portable.replace(each.begin, each.end - each.begin, each.value);
  }
  return portable;
}

}  // namespace vantage
