#include "tools/replay/replay_config.h"

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

#include "common/format.h"
#include "nodes/extrinsics_config.h"
#include "nodes/fusion_config.h"
#include "nodes/ppf_config.h"
#include "nodes/shot_config.h"
#include "tools/support/log_config.h"
#include "tools/support/portable_config.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

// What the nodes of a rerun make of a configuration.
struct Effective {
  std::map<std::string, std::string> values;  // By key.
  std::optional<Error> error;                 // The first.
};

// Has one node read its tables.
template <class Read>
void Gather(const std::string& text, const std::string& name, const Read& read, Effective* all) {
  Result<ConfigReader> config = ConfigReader::Parse(text, name);
  if (!config) {
    if (!all->error) all->error = config.error();
    return;
  }
  if (const auto result = read(*config); !result && !all->error) all->error = result.error();
  std::istringstream lines(config->Effective());
  for (std::string line; std::getline(lines, line);) {
    const size_t equals = line.find(" = ");
    if (equals != std::string::npos) all->values[line.substr(0, equals)] = line.substr(equals + 3);
  }
}

Effective ReadAll(const std::string& text, const std::string& name, const ReplayOptions& options) {
  Effective all;
  for (const std::string& estimator : options.estimators) {
    if (estimator == "ppf") Gather(text, name, ReadPpfConfig, &all);
    if (estimator == "shot") Gather(text, name, ReadShotConfig, &all);
  }
  Gather(text, name, ReadFusionConfig, &all);
  if (options.with_extrinsics) Gather(text, name, ReadExtrinsicsConfig, &all);
  all.values.erase("fusion.state_file");  // A rerun starts from nothing and leaves nothing.
  return all;
}

// Whether a key, or what is below it, is among those that were read.
bool IsRead(const std::string& key, const std::map<std::string, std::string>& values) {
  for (auto at = values.lower_bound(key); at != values.end() && at->first.starts_with(key); ++at) {
    const std::string rest = at->first.substr(key.size());
    if (rest.empty() || rest.front() == '.' || rest.front() == '[') return true;
  }
  const size_t bracket = key.rfind('[');  // An element of a list of values.
  return bracket != std::string::npos && key.back() == ']' &&
         values.contains(key.substr(0, bracket));
}

Result<void> CheckAllRead(const std::vector<ConfigOverride>& overrides, const Effective& after) {
  for (const ConfigOverride& each : overrides) {
    if (IsRead(each.key, after.values)) continue;
    std::set<std::string> tables;
    for (const auto& [key, value] : after.values) {
      if (const size_t end = key.find_first_of(".["); end != std::string::npos) {
        tables.insert(Format("[%s]", key.substr(0, end).c_str()));
      }
    }
    std::string known;
    for (const std::string& table : tables) known += (known.empty() ? "" : ", ") + table;
    return Error{ErrorCode::kInvalidArgument,
                 Format("--set %s: nothing in this rerun reads it, expected a key of %s",
                        each.key.c_str(),
                        known.c_str())};
  }
  return {};
}

std::vector<std::string> Differences(const Effective& before, const Effective& after) {
  std::map<std::string, std::pair<std::string, std::string>> both;
  for (const auto& [key, value] : before.values) both[key].first = value;
  for (const auto& [key, value] : after.values) both[key].second = value;
  std::vector<std::string> lines;
  for (const auto& [key, values] : both) {
    const auto& [old_value, new_value] = values;
    if (old_value == new_value) continue;
    lines.push_back(Format("%s: %s -> %s",
                           key.c_str(),
                           old_value.empty() ? "absent" : old_value.c_str(),
                           new_value.empty() ? "absent" : new_value.c_str()));
  }
  return lines;
}

}  // namespace

Result<ReplayConfig> ResolveReplayConfig(const ReplayOptions& options,
                                         const std::string& file,
                                         const std::vector<ConfigOverride>& overrides) {
  const Result<ConfigReader> opened = OpenConfig(file, options.log);
  if (!opened) return opened.error();
  const fs::path here = fs::current_path();
  const fs::path folder = file.empty() ? here : fs::absolute(file).parent_path();
  const Result<std::string> own = PortableConfigText(opened->text(), folder);
  if (!own) return own.error();
  const Result<std::string> overridden = OverriddenConfigText(*own, overrides);
  if (!overridden) return overridden.error();
  // Paths of the command line start where it was given.
  Result<std::string> text = PortableConfigText(*overridden, here);
  if (!text) return text.error();

  ReplayConfig result;
  result.text = std::move(text).value();
  result.name = file.empty() ? options.log + " LOG_HEADER" : file;
  result.from_header = file.empty();
  const Effective after = ReadAll(result.text, result.name, options);
  if (after.error) return *after.error;
  if (Result<void> all_read = CheckAllRead(overrides, after); !all_read) return all_read.error();

  std::string baseline = *own;
  result.baseline = file.empty() ? "the log's LOG_HEADER" : file;
  if (const Result<ConfigReader> header = OpenConfig("", options.log); header && !file.empty()) {
    const Result<std::string> portable = PortableConfigText(header->text(), here);
    if (portable) {
      baseline = *portable;
      result.baseline = "the log's LOG_HEADER";
    }
  }
  if (baseline != result.text) {
    result.differences = Differences(ReadAll(baseline, result.baseline, options), after);
  }
  return result;
}

}  // namespace vantage
