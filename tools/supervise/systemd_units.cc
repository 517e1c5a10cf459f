#include "tools/supervise/systemd_units.h"

#include <cstdlib>

#include "common/format.h"

namespace vantage {
namespace {

// Within double quotes, as systemd.syntax(7) and "Specifiers" of systemd.unit(5) have it.
std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (c == '%') quoted += '%';
    quoted += c;
  }
  quoted += '"';
  return quoted;
}

std::string UnitName(const RunFolder& run, const std::string& process) {
  return Format("vantage-%s-%s.service", run.id.c_str(), process.c_str());
}

std::string TargetName(const RunFolder& run) { return Format("vantage-%s.target", run.id.c_str()); }

std::string Service(const ProcessPlan& plan, const PlannedProcess& process, const RunFolder& run) {
  const UpConfig& up = plan.up;
  std::string text = "# Made by vantage-up from " + plan.config.string() + "\n[Unit]\n";
  text += "Description=" + process.name + " of the Vantage set-up " + run.id + "\n";
  text += "PartOf=" + TargetName(run) + "\n";
  // The order of stopping is the reverse of this one.
  std::string after;
  for (const PlannedProcess& other : plan.processes) {
    if (other.stage < process.stage) after += UnitName(run, other.name) + " ";
  }
  if (!after.empty()) text += "After=" + after + "\n";
  const int attempts = up.start_retries + 1;
  // So many starts within the time that as many failing ones take at most.
  text += Format(
      "StartLimitBurst=%d\nStartLimitIntervalSec=%d\n", attempts, (up.start_s + 2) * attempts);
  text += "\n[Service]\nType=exec\n";
  text += "WorkingDirectory=" + plan.config.parent_path().string() + "\n";
  if (const char* url = std::getenv("LCM_DEFAULT_URL"); url != nullptr) {
    text += "Environment=" + Quoted(std::string("LCM_DEFAULT_URL=") + url) + "\n";
  }
  for (const auto& [name, value] : process.environment) {
    std::string setting = name;
    setting += "=" + value;
    text += "Environment=" + Quoted(setting) + "\n";
  }
  text += "ExecStart=" + SystemdCommand(process.command) + "\n";
  if (process.nice != 0) text += Format("Nice=%d\n", process.nice);
  // A full disk ends the recording alone: only a crash is mended.
  const bool is_recorder = process.stage == UpStage::kRecorder;
  text += Format("Restart=%s\nRestartSec=1\nTimeoutStopSec=%d\n",
                 is_recorder ? "on-abnormal" : "always",
                 up.stop_s);
  return text;
}

}  // namespace

std::string SystemdCommand(const std::vector<std::string>& words) {
  std::string line;
  // No quotes may be in the program's own name.
  if (words.front().find_first_of("\"'\\") != std::string::npos) line = "/usr/bin/env";
  for (const std::string& word : words) {
    if (!line.empty()) line += ' ';
    std::string without_variables;
    for (const char c : word) {
      if (c == '$' && !line.empty()) without_variables += '$';  // In arguments alone.
      without_variables += c;
    }
    line += Quoted(without_variables);
  }
  return line;
}

std::map<std::string, std::string> SystemdUnits(const ProcessPlan& plan, const RunFolder& run) {
  std::map<std::string, std::string> units;
  std::string target = "# Made by vantage-up from " + plan.config.string() + "\n[Unit]\n";
  target += "Description=The Vantage set-up " + run.id + "\nWants=";
  for (const PlannedProcess& process : plan.processes) {
    const std::string name = UnitName(run, process.name);
    target += name;
    target += ' ';
    units[name] = Service(plan, process, run);
  }
  target += "\n\n[Install]\nWantedBy=default.target\n";
  units[TargetName(run)] = target;
  return units;
}

}  // namespace vantage
