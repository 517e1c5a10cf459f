#include "nodes/up_config.h"

#include <algorithm>
#include <set>

namespace vantage {
namespace {

constexpr size_t kLongestName = 64;

// What a process may be called on the bus; "all" means all of them to supervisorctl.
bool IsName(const std::string& name) {
  return !name.empty() && name.size() <= kLongestName && name != "all" &&
         std::ranges::all_of(name, [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                  c == '_' || c == '-' || c == '.';
         });
}

UpProcess ReadProcess(ConfigReader::Table& table, std::set<std::string>* names) {
  UpProcess process;
  table.Require("name");
  table.Read("name", &process.name);
  table.Read("start", &process.start);
  table.Read("command", &process.command);
  table.Read("arguments", &process.arguments);
  table.Read("nice", &process.nice, -20, 19);
  if (table.Has("name") && !IsName(process.name)) {
    table.Fail("name", "expected 1 to 64 letters, digits, '_', '-' or '.', and not \"all\"");
  }
  if (!names->insert(process.name).second) {
    table.Fail("name", "expected one [[up.process]] of each name");
  }
  if (table.Has("command") && (process.command.empty() || process.command.front().empty())) {
    table.Fail("command", "expected the program, then its arguments");
  }
  return process;
}

}  // namespace

UpConfig ReadUpConfig(ConfigReader& config) {
  UpConfig up;
  ConfigReader::Table table = config.Root().Sub("up");
  table.ReadPath("record", &up.record);
  table.ReadPath("log_folder", &up.log_folder);
  table.Read("log_size_mb", &up.log_size_mb, 1, 10000);
  table.Read("log_files", &up.log_files, 1, 1000);
  table.Read("start_s", &up.start_s, 2, 600);  // The supervisor looks once a second.
  table.Read("start_retries", &up.start_retries, 0, 1000);
  table.Read("stop_s", &up.stop_s, 1, 600);
  std::set<std::string> names;
  for (ConfigReader::Table& process : table.SubTables("process")) {
    up.processes.push_back(ReadProcess(process, &names));
  }
  return up;
}

}  // namespace vantage
