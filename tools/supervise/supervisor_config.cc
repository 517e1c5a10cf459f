#include "tools/supervise/supervisor_config.h"

#include <unistd.h>

#include <cctype>
#include <optional>

#include "common/format.h"
#include "tools/supervise/program_search.h"

namespace vantage {
namespace {

std::string WithoutExpansion(const std::string& text) {
  std::string escaped;
  for (const char c : text) escaped += c == '%' ? std::string("%%") : std::string(1, c);
  return escaped;
}

// Before the process itself: it ends with the supervisor, whatever befalls that; it has its folder
// and environment. All as words of the command, which can be quoted; the supervisor's own keys for
// them can't.
Result<std::vector<std::string>> Wrapped(const PlannedProcess& process, const std::string& folder) {
  std::vector<std::string> words;
  for (const char* name : {"setpriv", "env", "nice"}) {
    const std::optional<std::filesystem::path> found = FindProgram(name);
    if (!found) {
      return Error{ErrorCode::kNotFound,
                   Format("%s is not installed, expected it of util-linux and coreutils", name)};
    }
    words.push_back(found->string());
  }
  std::vector<std::string> command = {words[0], "--pdeathsig", "TERM", words[1], "-C", folder};
  for (const auto& [name, value] : process.environment) {
    std::string setting = name;
    setting += "=" + value;
    command.push_back(setting);
  }
  // Always: env takes a program with '=' in its path for a setting.
  command.insert(command.end(), {words[2], "-n", std::to_string(process.nice)});
  command.insert(command.end(), process.command.begin(), process.command.end());
  return command;
}

Result<std::string> ProgramSection(const PlannedProcess& process,
                                   const ProcessPlan& plan,
                                   const RunFolder& run) {
  const Result<std::vector<std::string>> words =
      Wrapped(process, plan.config.parent_path().string());
  if (!words) return words.error();
  const UpConfig& up = plan.up;
  std::string text = "\n[program:" + process.name + "]\n";
  text += "command=" + SupervisorCommand(*words) + "\n";
  text += Format("priority=%d\n", 100 * (static_cast<int>(process.stage) + 1));
  // A recording that a full disk ended, once it had begun, ends alone: only a crash is mended.
  text += process.stage == UpStage::kRecorder ? "autorestart=unexpected\nexitcodes=0,1,2\n"
                                              : "autorestart=true\n";
  text += Format("startsecs=%d\nstartretries=%d\n", up.start_s, up.start_retries);
  text += Format("stopsignal=TERM\nstopwaitsecs=%d\n", up.stop_s);
  text += "stopasgroup=true\nkillasgroup=true\nredirect_stderr=true\n";
  text +=
      "stdout_logfile=" + WithoutExpansion((run.log_link() / (process.name + ".log")).string()) +
      "\n";
  text += Format(
      "stdout_logfile_maxbytes=%dMB\nstdout_logfile_backups=%d\n", up.log_size_mb, up.log_files);
  return text;
}

}  // namespace

std::string SupervisorCommand(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) {
    if (!line.empty()) line += ' ';
    if (word.empty()) line += "''";
    for (const char c : word) {
      const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 ||
                         (static_cast<unsigned char>(c) & 0x80U) != 0 ||
                         std::string("/._-=:,+@").find(c) != std::string::npos;
      // Each by itself: within quotes a blank before ';' would begin a comment.
      if (!plain && c != '%') line += '\\';
      line += c == '%' ? std::string("%%") : std::string(1, c);
    }
  }
  return line;
}

Result<std::string> SupervisorConfig(const ProcessPlan& plan, const RunFolder& run) {
  const UpConfig& up = plan.up;
  std::string text =
      "; Made by vantage-up for the set-up " + run.id + "; made anew at each start.\n";
  text += "[unix_http_server]\n";
  text += "file=" + WithoutExpansion(run.socket().string()) + "\nchmod=0700\n";
  text += "\n[supervisord]\n";
  text += "logfile=" + WithoutExpansion((run.log_link() / "supervisord.log").string()) + "\n";
  text += Format("logfile_maxbytes=%dMB\nlogfile_backups=%d\n", up.log_size_mb, up.log_files);
  text += "pidfile=" + WithoutExpansion(run.pid_file().string()) + "\n";
  text += "childlogdir=" + WithoutExpansion(run.folder.string()) + "\n";
  text += "identifier=" + run.id + "\nnocleanup=true\n";
  if (getuid() == 0) text += "user=root\n";
  text += "\n[rpcinterface:supervisor]\n";
  text += "supervisor.rpcinterface_factory=supervisor.rpcinterface:make_main_rpcinterface\n";
  text += "\n[supervisorctl]\n";
  text += "serverurl=unix://" + WithoutExpansion(run.socket().string()) + "\n";
  for (const PlannedProcess& process : plan.processes) {
    const Result<std::string> section = ProgramSection(process, plan, run);
    if (!section) return section.error();
    text += *section;
  }
  return text;
}

}  // namespace vantage
