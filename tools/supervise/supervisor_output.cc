#include "tools/supervise/supervisor_output.h"

#include <array>
#include <regex>

namespace vantage {
namespace {

// Of interest to those alone who watch the supervisor itself.
bool IsOfItself(const std::string& text) {
  static const std::array<const char*, 7> starts = {"Included extra file",
                                                    "RPC interface 'supervisor' initialized",
                                                    "Server 'unix_http_server' running without",
                                                    "Set uid to user",
                                                    "supervisord started with pid",
                                                    "waiting for ",
                                                    "received SIG"};
  for (const char* start : starts) {
    if (text.starts_with(start)) return true;
  }
  return false;
}

}  // namespace

std::string SupervisorOutput::Read(const std::string& line) {
  static const std::regex form(R"(\d{4}-\d\d-\d\d (\d\d:\d\d:\d\d),\d+ [A-Z]+ (.*))");
  std::smatch parts;
  ended_.reset();
  if (!std::regex_match(line, parts, form)) return line;
  const std::string time = parts[1];
  const std::string text = parts[2];
  static const std::regex gave_up(R"(gave up: (\S+) entered FATAL state.*)");
  static const std::regex success(R"(success: (\S+) entered RUNNING state.*)");
  static const std::regex exited(R"(exited: (\S+) \((.*); (not )?expected\))");
  static const std::regex spawned(R"(spawned: '(\S+)' with pid (\d+))");
  std::smatch name;
  std::string said = text;
  if (std::regex_match(text, name, gave_up)) {
    if (!failed_) failed_ = name[1];
    said = name[1].str() + " is given up";
  } else if (std::regex_match(text, name, success)) {
    running_.insert(name[1]);
    said = name[1].str() + " runs";
  } else if (std::regex_match(text, name, spawned)) {
    said = name[1].str() + " starts (pid " + name[2].str() + ")";
  } else if (std::regex_match(text, name, exited)) {
    ended_ = name[1];
    said = name[1].str() + " has ended (" + name[2].str() + ")";
  } else if (IsOfItself(text)) {
    return "";
  }
  return time + " " + said;
}

}  // namespace vantage
