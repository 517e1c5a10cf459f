// Starts, watches, restarts and stops the whole set-up that a configuration describes.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "common/format.h"
#include "nodes/command_line.h"
#include "tools/supervise/process_plan.h"
#include "tools/supervise/program_search.h"
#include "tools/supervise/run_folder.h"
#include "tools/supervise/supervisor.h"
#include "tools/supervise/supervisor_config.h"
#include "tools/supervise/systemd_units.h"
#include "tools/support/whole_file.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr int kBadInput = 2;

struct Options {
  std::string config;
  std::string folder;
  std::string process;
  bool background = false;
  bool follow = false;
  std::string print;
  std::string install_systemd;
};

// What is to be started and where.
struct SetUp {
  ProcessPlan plan;
  RunFolder run;
};

Result<SetUp> Load(const Options& options) {
  const fs::path programs = fs::read_symlink("/proc/self/exe").parent_path();
  Result<ProcessPlan> plan = MakeProcessPlan(options.config, programs);
  if (!plan) return plan.error();
  Result<RunFolder> run = ChooseRunFolder(plan->config, options.folder, plan->up.log_folder);
  if (!run) return run.error();
  return SetUp{*std::move(plan), *std::move(run)};
}

// Where a set-up runs, by its place alone: what is up can be stopped, whatever its file says by
// now.
Result<RunFolder> Locate(const Options& options) {
  fs::path logs;
  if (Result<ConfigReader> config = ConfigReader::Open(options.config)) {
    logs = ReadUpConfig(*config).log_folder;
  }
  return ChooseRunFolder(fs::weakly_canonical(fs::absolute(options.config)), options.folder, logs);
}

Result<int> Print(const SetUp& set_up, const std::string& what) {
  if (what == "supervisor") {
    const Result<std::string> config = SupervisorConfig(set_up.plan, set_up.run);
    if (!config) return config.error();
    std::fputs(config->c_str(), stdout);
    return 0;
  }
  for (const auto& [name, text] : SystemdUnits(set_up.plan, set_up.run)) {
    std::printf("# ---- %s\n%s\n", name.c_str(), text.c_str());
  }
  return 0;
}

Result<int> InstallSystemd(const SetUp& set_up, const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    return Error{ErrorCode::kNotFound,
                 folder.string() +
                     " is no folder, expected one for the units, such as "
                     "~/.config/systemd/user"};
  }
  for (const auto& [name, text] : SystemdUnits(set_up.plan, set_up.run)) {
    if (Result<void> written = WriteWholeFile(folder / name, text); !written) {
      return written.error();
    }
    std::printf("%s\n", (folder / name).c_str());
  }
  std::printf(
      "start with: systemctl --user daemon-reload && systemctl --user start vantage-%s.target\n",
      set_up.run.id.c_str());
  return 0;
}

// Becomes tail; comes back only where that fails.
Result<int> ShowLogs(const RunFolder& run, const std::string& process, bool follow) {
  std::vector<std::string> words = {"tail", "-n", "100"};
  if (follow) words.emplace_back("-F");
  words.emplace_back("--");
  std::error_code error;
  for (fs::directory_iterator entry(run.logs, error), end; !error && entry != end;
       entry.increment(error)) {
    const fs::path& file = entry->path();
    const bool wanted = process.empty() || file.stem() == process;
    if (wanted && file.extension() == ".log") words.push_back(file.string());
  }
  std::sort(std::ranges::find(words, "--") + 1, words.end());
  const std::optional<fs::path> tail = FindProgram("tail");
  if (words.back() == "--" || !tail) {
    return Error{ErrorCode::kNotFound,
                 Format("there is no log of %s in %s",
                        process.empty() ? "the set-up" : process.c_str(),
                        run.logs.c_str())};
  }
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  ::execv(tail->c_str(), pointers.data());
  return Error{ErrorCode::kIo, tail->string() + " can't be started"};
}

int Report(const Result<int>& done) {
  if (done) return *done;
  std::fprintf(stderr, "vantage-up: %s\n", done.error().message.c_str());
  return kBadInput;
}

int Run(int argc, char** argv) {
  Options options;
  CLI::App app("Starts, watches, restarts and stops the whole set-up of a configuration.",
               "vantage-up");
  app.set_version_flag("--version", VANTAGE_VERSION);
  const auto add_config = [&options](CLI::App* command) {
    command->add_option("config", options.config, "TOML file of the set-up");
    command->add_option("--folder",
                        options.folder,
                        "run folder; default: XDG_RUNTIME_DIR/vantage/NAME, or one in /tmp");
  };
  add_config(&app);
  app.add_flag("--daemon", options.background, "go on in the background once all have started");
  CLI::Option* print = app.add_option("--print", options.print, "show the files that would be made")
                           ->check(CLI::IsMember({"supervisor", "systemd"}));
  CLI::Option* install =
      app.add_option("--install-systemd", options.install_systemd, "write systemd's units into DIR")
          ->type_name("DIR");
  print->excludes(install);
  const auto add_command = [&](const char* name, const char* text, bool has_process) {
    CLI::App* command = app.add_subcommand(name, text);
    add_config(command);
    if (has_process) command->add_option("process", options.process, "one process; default: all");
    return command;
  };
  const CLI::App* status = add_command("status", "show the state of each process", false);
  const CLI::App* stop = add_command("stop", "end one process, or all in order", true);
  const CLI::App* restart = add_command("restart", "end and start one process, or all", true);
  CLI::App* logs = add_command("logs", "show the ends of logs", true);
  logs->add_flag("--follow,-f", options.follow, "go on showing what is written");
  if (const std::optional<int> code = ParseCommandLine(app, argc, argv)) return *code;
  if (options.config.empty()) {
    std::fprintf(stderr, "vantage-up: a config file is required; see vantage-up --help\n");
    return kBadInput;
  }

  if (logs->parsed() || status->parsed() || stop->parsed()) {
    const Result<RunFolder> run = Locate(options);
    if (!run) return Report(run.error());
    if (logs->parsed()) return Report(ShowLogs(*run, options.process, options.follow));
    const Result<Supervisor> supervisor = Supervisor::Find(*run);
    if (!supervisor) return Report(supervisor.error());
    return Report(status->parsed() ? supervisor->PrintStatus() : supervisor->Stop(options.process));
  }
  const Result<SetUp> set_up = Load(options);
  if (!set_up) return Report(set_up.error());
  if (!options.print.empty()) return Report(Print(*set_up, options.print));
  if (!options.install_systemd.empty()) {
    return Report(InstallSystemd(*set_up, options.install_systemd));
  }
  const Result<Supervisor> supervisor = Supervisor::Find(set_up->run);
  if (!supervisor) return Report(supervisor.error());
  if (restart->parsed()) return Report(supervisor->Restart(set_up->plan, options.process));
  return Report(options.background ? supervisor->RunInBackground(set_up->plan)
                                   : supervisor->RunInForeground(set_up->plan));
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) { return vantage::Run(argc, argv); }
