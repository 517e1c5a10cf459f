#include "tools/supervise/supervisor.h"

#include <poll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <optional>
#include <sstream>
#include <thread>

#include "common/format.h"
#include "tools/supervise/child_process.h"
#include "tools/supervise/program_search.h"
#include "tools/supervise/supervisor_config.h"
#include "tools/supervise/supervisor_output.h"
#include "tools/support/whole_file.h"

namespace vantage {
namespace {

constexpr int kFailed = 1;

// The last line with text in it of the end of a file; empty where there is none.
std::string LastLine(const std::filesystem::path& file) {
  constexpr std::streamoff kEnd = 4096;
  std::ifstream stream(file, std::ios::binary | std::ios::ate);
  const std::streamoff size = stream.tellg();
  if (!stream || size <= 0) return "";
  stream.seekg(std::max<std::streamoff>(0, size - kEnd));
  std::string last;
  for (std::string line; std::getline(stream, line);) {
    if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
  }
  return last;
}

void Say(const std::string& text) {
  std::printf("%s\n", text.c_str());
  std::fflush(stdout);
}

// SIGINT, SIGTERM and SIGHUP as a file to read. Errors: the system refuses.
Result<int> StopSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal);
  sigprocmask(SIG_BLOCK, &signals, nullptr);
  const int descriptor = signalfd(-1, &signals, SFD_CLOEXEC);
  if (descriptor >= 0) return descriptor;
  return Error{ErrorCode::kIo, "signals can't be waited for"};
}

// Reads what is there and says each whole line; false at the end.
bool ReadLines(int descriptor,
               const std::filesystem::path& logs,
               std::string* rest,
               SupervisorOutput* output) {
  std::array<char, 4096> buffer{};
  const ssize_t got = read(descriptor, buffer.data(), buffer.size());
  if (got <= 0) return false;
  rest->append(buffer.data(), static_cast<size_t>(got));
  for (size_t end = rest->find('\n'); end != std::string::npos; end = rest->find('\n')) {
    std::string text = output->Read(rest->substr(0, end));
    if (output->ended())
      text += "; its last words: " + LastLine(logs / (*output->ended() + ".log"));
    if (!text.empty()) Say(text);
    rest->erase(0, end + 1);
  }
  return true;
}

// Shows what the supervisor says until it ends; ends it after a signal or a failure.
SupervisorOutput Watch(const ChildProcess& child,
                       int signals,
                       const std::filesystem::path& logs,
                       size_t num_processes) {
  SupervisorOutput output;
  std::string rest;
  bool stopping = false;
  bool told = false;
  const auto stop = [&](const char* why) {
    if (stopping) return;
    stopping = true;
    Say(why);
    kill(child.pid, SIGTERM);
  };
  for (;;) {
    std::array<pollfd, 2> waited = {{{child.output, POLLIN, 0}, {signals, POLLIN, 0}}};
    if (poll(waited.data(), waited.size(), -1) < 0) continue;
    if (waited[1].revents != 0) {
      signalfd_siginfo ignored{};
      if (read(signals, &ignored, sizeof(ignored)) > 0) stop("stopping all, in order");
    }
    if (waited[0].revents != 0 && !ReadLines(child.output, logs, &rest, &output)) return output;
    if (output.failed()) stop("stopping the others, in order");
    if (!told && output.running().size() == num_processes) {
      told = true;
      Say(Format("all %zu run", num_processes));
    }
  }
}

struct ProcessState {
  std::string name;
  std::string state;
};

std::vector<ProcessState> ParseStatus(const std::string& text) {
  std::vector<ProcessState> states;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    ProcessState state;
    if (words >> state.name >> state.state) states.push_back(state);
  }
  return states;
}

bool HasState(const std::vector<ProcessState>& states, const std::string& state) {
  return std::ranges::any_of(states, [&](const ProcessState& each) { return each.state == state; });
}

std::string Names(const ProcessPlan& plan) {
  std::string names;
  for (const PlannedProcess& process : plan.processes) {
    names += (names.empty() ? "" : ", ") + process.name;
  }
  return names;
}

}  // namespace

Result<Supervisor> Supervisor::Find(const RunFolder& run) {
  const std::optional<std::filesystem::path> daemon = FindProgram("supervisord");
  const std::optional<std::filesystem::path> control = FindProgram("supervisorctl");
  if (daemon && control) return Supervisor(run, daemon->string(), control->string());
  return Error{ErrorCode::kNotFound,
               "supervisord is not installed; install it with: apt-get install supervisor"};
}

Result<void> Supervisor::Prepare(const ProcessPlan& plan) const {
  const Result<std::string> config = SupervisorConfig(plan, run_);
  if (!config) return config.error();
  if (Result<void> taken = TakeRunFolder(run_); !taken) return taken;
  if (IsUp(run_)) {
    return Error{ErrorCode::kUnavailable,
                 Format("%s is up already, in %s; expected it to be down: vantage-up stop %s",
                        plan.config.c_str(),
                        run_.folder.c_str(),
                        plan.config.c_str())};
  }
  if (Result<void> made = MakeLogFolder(run_); !made) return made;
  if (Result<void> written = WriteWholeFile(run_.config(), *config); !written) return written;
  Say(Format("%s: %s; logs in %s", plan.config.c_str(), Names(plan).c_str(), run_.logs.c_str()));
  return {};
}

Result<int> Supervisor::RunInForeground(const ProcessPlan& plan) const {
  if (Result<void> prepared = Prepare(plan); !prepared) return prepared.error();
  const Result<int> signals = StopSignals();
  if (!signals) return signals.error();
  const Result<ChildProcess> child = StartChild({daemon_, "-n", "-c", run_.config().string()});
  if (!child) return child.error();
  const SupervisorOutput output = Watch(*child, *signals, run_.logs, plan.processes.size());
  const int code = WaitForChild(*child);
  if (output.failed()) {
    TellFailure(*output.failed());
    return kFailed;
  }
  if (code != 0) {
    std::fprintf(stderr,
                 "vantage-up: supervisord has ended by itself (exit code %d), and with it the "
                 "processes; see %s\n",
                 code,
                 (run_.logs / "supervisord.log").c_str());
    return kFailed;
  }
  Say("all have ended");
  return 0;
}

Result<int> Supervisor::RunInBackground(const ProcessPlan& plan) const {
  if (Result<void> prepared = Prepare(plan); !prepared) return prepared.error();
  const Result<ChildOutput> started = RunChild({daemon_, "-c", run_.config().string()});
  if (!started) return started.error();
  if (started->exit_code != 0) {
    return Error{ErrorCode::kUnavailable, "supervisord did not start: " + started->text};
  }
  return WaitUntilSettled();
}

Result<int> Supervisor::WaitUntilSettled() const {
  for (;;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    const Result<std::string> status = Control({"status"});
    if (!status) return status.error();
    const std::vector<ProcessState> states = ParseStatus(*status);
    for (const ProcessState& each : states) {
      if (each.state != "FATAL") continue;
      if (Result<int> stopped = Stop(""); !stopped) return stopped;
      TellFailure(each.name);
      return kFailed;
    }
    if (HasState(states, "STARTING") || HasState(states, "BACKOFF")) continue;
    std::printf("%s", status->c_str());
    return 0;
  }
}

void Supervisor::TellFailure(const std::string& name) const {
  const std::string log = (run_.log_link() / (name + ".log")).string();
  const std::string last = LastLine(log);
  std::fprintf(stderr,
               "vantage-up: %s does not stay up; %s (%s)\n",
               name.c_str(),
               last.empty() ? "it said nothing" : ("its last words: " + last).c_str(),
               log.c_str());
}

Result<void> Supervisor::CheckUp() const {
  if (IsUp(run_)) return {};
  return Error{ErrorCode::kNotFound,
               Format("the set-up is not up: no supervisor serves %s", run_.socket().c_str())};
}

Result<std::string> Supervisor::Control(const std::vector<std::string>& words) const {
  std::vector<std::string> command = {control_, "-c", run_.config().string()};
  command.insert(command.end(), words.begin(), words.end());
  const Result<ChildOutput> output = RunChild(command);
  if (!output) return output.error();
  return output->text;
}

Result<int> Supervisor::PrintStatus() const {
  if (Result<void> up = CheckUp(); !up) return up.error();
  const Result<std::string> status = Control({"status"});
  if (!status) return status.error();
  std::printf("%s", status->c_str());
  const std::vector<ProcessState> states = ParseStatus(*status);
  const bool all = std::ranges::all_of(states, [](const ProcessState& each) {
    return each.state == "RUNNING" || each.state == "STARTING";
  });
  return all && !states.empty() ? 0 : kFailed;
}

Result<int> Supervisor::Stop(const std::string& name) const {
  if (Result<void> up = CheckUp(); !up) return up.error();
  const Result<std::string> said = name.empty() ? Control({"shutdown"}) : Control({"stop", name});
  if (!said) return said.error();
  if (!name.empty()) {
    std::printf("%s", said->c_str());
    return said->find("ERROR") == std::string::npos ? 0 : kFailed;
  }
  // The supervisor gives each process its time and then kills it, so this ends.
  while (IsUp(run_)) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  Say("all have ended");
  return 0;
}

Result<int> Supervisor::Restart(const ProcessPlan& plan, const std::string& name) const {
  if (Result<void> up = CheckUp(); !up) return up.error();
  if (!name.empty()) {
    const Result<std::string> said = Control({"restart", name});
    if (!said) return said.error();
    std::printf("%s", said->c_str());
    return said->find(name + ": started") != std::string::npos ? 0 : kFailed;
  }
  const Result<std::string> config = SupervisorConfig(plan, run_);
  if (!config) return config.error();
  const Result<std::string> status = Control({"status"});
  if (!status) return status.error();
  std::vector<std::string> stop = {"stop"};  // One after the other, those who ask first.
  const std::vector<ProcessState> states = ParseStatus(*status);
  for (auto process = plan.processes.rbegin(); process != plan.processes.rend(); ++process) {
    const bool is_up = std::ranges::any_of(
        states, [&](const ProcessState& each) { return each.name == process->name; });
    if (is_up) stop.push_back(process->name);
  }
  if (stop.size() > 1) {
    if (const Result<std::string> stopped = Control(stop); !stopped) return stopped.error();
  }
  if (Result<void> made = MakeLogFolder(run_); !made) return made.error();
  if (Result<void> written = WriteWholeFile(run_.config(), *config); !written) {
    return written.error();
  }
  for (const char* step : {"update", "start"}) {
    std::vector<std::string> words = {step};
    if (words.front() == "start") words.emplace_back("all");
    if (const Result<std::string> done = Control(words); !done) return done.error();
  }
  return WaitUntilSettled();
}

}  // namespace vantage
