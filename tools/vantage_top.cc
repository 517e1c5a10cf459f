// vantage-top: how the processes, cameras and channels of a set-up fare, for people at a terminal
// and, with --check, for scripts.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/event_log.h"
#include "bus/live_bus.h"
#include "common/format.h"
#include "nodes/command_line.h"
#include "nodes/config_reader.h"
#include "nodes/process.h"
#include "tools/monitor/expected_setup.h"
#include "tools/monitor/monitor_check.h"
#include "tools/monitor/monitor_json.h"
#include "tools/monitor/monitor_model.h"
#include "tools/monitor/monitor_screen.h"
#include "tools/monitor/terminal.h"
#include "tools/support/interrupt.h"

namespace vantage {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kSomethingWrong = 1;  // Exit codes.
constexpr int kBadInput = 2;
constexpr size_t kMostTold = 100;               // Lines of --check.
constexpr size_t kQueueBytes = 32U << 20U;      // Messages that wait while the screen is drawn.
constexpr int kMostAtOnce = 1000;               // Messages between two looks at the keys.
constexpr std::chrono::milliseconds kWait(50);  // For a message; keys are looked at between.

struct Arguments {
  std::string config;
  std::string url;
  std::string log;
  bool once = false;
  bool json = false;
  bool check = false;
  std::optional<double> seconds;  // s; default: 5 with --check, else 2
  double interval = 1.0;          // s
  std::string sort = "name";
  std::vector<std::string> max_p99;
  MonitorLimits limits;
};

// SIGINT, SIGTERM and SIGHUP are looked for, so that the terminal is put back. Made before any
// thread.
class Signals {
 public:
  Signals() {
    sigemptyset(&signals_);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals_, signal);
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
  }
  bool Came() {
    const timespec now{};
    if (!came_) came_ = sigtimedwait(&signals_, nullptr, &now) > 0;
    return came_;
  }

 private:
  sigset_t signals_{};
  bool came_ = false;
};

class Top {
 public:
  Top(Arguments arguments, ExpectedSetup expected)
      : arguments_(std::move(arguments)), expected_(std::move(expected)) {
    const std::vector<std::string> orders = {"name", "rate", "bandwidth", "lost", "age", "jitter"};
    state_.order =
        static_cast<ChannelOrder>(std::ranges::find(orders, arguments_.sort) - orders.begin());
  }

  Result<int> RunOnLog();
  Result<int> RunLive();

 private:
  Result<void> OpenBus();
  /// Takes in what comes until `deadline`, a signal, or a key.
  void Listen(Clock::time_point deadline);
  [[nodiscard]] std::vector<std::string> FindProblemsOf(const MonitorModel& model,
                                                        int64_t now) const {
    return FindProblems(model, expected_, arguments_.limits, now);
  }
  int Tell(int64_t now, std::vector<std::string> problems) const;
  int RunOnTerminal();

  Arguments arguments_;
  ExpectedSetup expected_;
  Signals signals_;
  ScreenState state_;
  MonitorModel model_;
  std::string where_;
  std::unique_ptr<LiveBus> bus_;
};

Result<int> Top::RunOnLog() {
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(arguments_.log);
  if (!reader) return reader.error();
  where_ = arguments_.log;
  while (const std::optional<LogEvent> event = (*reader)->Next()) {
    if (signals_.Came()) return kInterrupted;
    model_.Add(event->channel, event->utime, event->data);
  }
  std::vector<std::string> problems = FindProblemsOf(model_, model_.last_utime());
  const auto& damage = (*reader)->damage();
  if (damage.any()) problems.push_back("the log is damaged: " + damage.Describe());
  return Tell(model_.last_utime(), problems);
}

Result<void> Top::OpenBus() {
  LiveBus::Options options;
  if (!arguments_.config.empty()) {
    Result<ConfigReader> config = ConfigReader::Open(arguments_.config);
    if (!config) return config.error();
    options = ReadBusOptions(*config);
  }
  options.name = "top";
  options.version = VANTAGE_VERSION;
  if (!arguments_.url.empty()) options.url = arguments_.url;
  Result<std::unique_ptr<LiveBus>> bus = LiveBus::Create(options);
  if (!bus) return bus.error();
  bus_ = std::move(bus).value();
  where_ = bus_->url().substr(0, bus_->url().find('?'));
  return bus_->Tap(".*",
                   {SubscribeOptions::Keep::kAll, kQueueBytes},
                   [this](const Envelope& envelope, std::span<const std::byte> bytes) {
                     model_.Add(envelope.channel, envelope.receive_utime, bytes);
                   });
}

void Top::Listen(Clock::time_point deadline) {
  while (Clock::now() < deadline && !signals_.Came()) bus_->Dispatch(kWait);
}

int Top::Tell(int64_t now, std::vector<std::string> problems) const {
  if (arguments_.json) {
    std::fputs(MonitorJson(model_, problems, now).c_str(), stdout);
  } else if (arguments_.check) {
    if (problems.empty()) std::puts("ok");
    const size_t told = std::min(problems.size(), kMostTold);
    for (size_t i = 0; i < told; ++i) std::puts(problems[i].c_str());
    if (problems.size() > told) std::printf("and %zu more\n", problems.size() - told);
  } else {
    for (const ScreenLine& line : DrawSnapshot(model_, problems, where_, state_.order, now)) {
      std::puts(line.text.c_str());
    }
  }
  std::fflush(stdout);
  return arguments_.check && !problems.empty() ? kSomethingWrong : 0;
}

Result<int> Top::RunLive() {
  if (Result<void> open = OpenBus(); !open) return open.error();
  const auto seconds = [](double s) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s));
  };
  if (arguments_.check || arguments_.json || arguments_.once) {
    Listen(Clock::now() + seconds(arguments_.seconds.value_or(arguments_.check ? 5.0 : 2.0)));
    if (signals_.Came()) return kInterrupted;
    const int64_t now = bus_->NowUtime();
    return Tell(now, FindProblemsOf(model_, now));
  }
  if (Terminal::IsThere()) return RunOnTerminal();
  while (!signals_.Came() && std::ferror(stdout) == 0) {
    Listen(Clock::now() + seconds(arguments_.interval));
    if (signals_.Came()) break;
    const int64_t now = bus_->NowUtime();
    Tell(now, FindProblemsOf(model_, now));
    std::puts("");
  }
  return 0;
}

int Top::RunOnTerminal() {
  Terminal terminal;
  MonitorModel paused;
  int64_t paused_at = 0;
  ScreenSize drawn{0, 0};
  auto next = Clock::now();
  while (!signals_.Came() && !state_.wants_to_quit) {
    bus_->Dispatch(kWait);
    for (int i = 0; i < kMostAtOnce && bus_->Dispatch(std::chrono::milliseconds(0)); ++i) {
    }
    const std::string keys = terminal.ReadKeys();
    const bool was_paused = state_.is_paused;
    ApplyKeys(keys, (was_paused ? paused : model_).processes().size(), &state_);
    if (state_.is_paused && !was_paused) {
      paused = model_;
      paused_at = bus_->NowUtime();
    }
    const ScreenSize size = terminal.size();
    const bool resized = size.rows != drawn.rows || size.columns != drawn.columns;
    if (keys.empty() && !resized && Clock::now() < next) continue;
    const MonitorModel& shown = state_.is_paused ? paused : model_;
    const int64_t now = state_.is_paused ? paused_at : bus_->NowUtime();
    terminal.Show(DrawScreen(shown, FindProblemsOf(shown, now), where_, state_, size, now));
    drawn = size;
    if (Clock::now() >= next) {
      next =
          Clock::now() + std::chrono::milliseconds(static_cast<int64_t>(1e3 * arguments_.interval));
    }
  }
  return 0;
}

// "match=0.5" of --max-p99.
Result<void> ReadStageLimits(const std::vector<std::string>& texts,
                             std::map<std::string, double>* limits) {
  for (const std::string& text : texts) {
    const size_t equals = text.rfind('=');
    double seconds = -1.0;
    if (equals != std::string::npos && equals > 0 &&
        CLI::detail::lexical_cast(text.substr(equals + 1), seconds) && std::isfinite(seconds) &&
        seconds > 0.0) {
      (*limits)[text.substr(0, equals)] = seconds;
      continue;
    }
    return Error{
        ErrorCode::kInvalidArgument,
        Format("--max-p99 is '%s', expected STAGE=SECONDS such as match=0.5", text.c_str())};
  }
  return {};
}

Result<int> Run(Arguments arguments) {
  if (Result<void> read = ReadStageLimits(arguments.max_p99, &arguments.limits.max_p99); !read) {
    return read.error();
  }
  ExpectedSetup expected;
  if (!arguments.config.empty()) {
    Result<ExpectedSetup> setup = ReadExpectedSetup(arguments.config);
    if (!setup) return setup.error();
    expected = std::move(setup).value();
  }
  const bool on_log = !arguments.log.empty();
  Top top(std::move(arguments), std::move(expected));
  return on_log ? top.RunOnLog() : top.RunLive();
}

void AddOptions(CLI::App& app, Arguments* arguments) {
  app.set_version_flag("--version", VANTAGE_VERSION);
  app.add_option(
      "--config,-c", arguments->config, "TOML file of the set-up: whom to expect, and [bus]");
  CLI::Option* url = app.add_option(
      "--lcm-url", arguments->url, "LCM URL; default: [bus] url, then LCM_DEFAULT_URL");
  app.add_option("--log", arguments->log, "look at a recording: the state at its end")
      ->excludes(url);
  app.add_flag("--once", arguments->once, "print one snapshot");
  app.add_flag("--json", arguments->json, "print one snapshot as JSON");
  app.add_flag("--check",
               arguments->check,
               "print what is wrong and exit with 1, or print ok and exit with 0");
  app.add_option("--seconds",
                 arguments->seconds,
                 "how long to listen; default 5 with --check, 2 with --once and --json")
      ->check(CLI::Range(0.1, 86400.0));
  app.add_option("--interval", arguments->interval, "s between updates")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  app.add_option("--sort", arguments->sort, "of the channels")
      ->check(CLI::IsMember({"name", "rate", "bandwidth", "lost", "age", "jitter"}))
      ->capture_default_str();
  MonitorLimits* limits = &arguments->limits;
  app.add_option("--max-silence", limits->max_silence, "s without a status of a process or camera")
      ->check(CLI::Range(1.0, 86400.0))
      ->capture_default_str();
  app.add_option("--max-lost", limits->max_lost, "messages lost of one channel during the watch")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--max-decode-errors", limits->max_decode_errors, "of one channel, likewise")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--max-missed", limits->max_missed, "share of a camera's frames that never came")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_option(
         "--max-camera-latency", limits->max_camera_latency, "s from exposure to publication")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option(
      "--max-p99", arguments->max_p99, "STAGE=SECONDS: p99 of a stage's latency; may be repeated");
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  vantage::Arguments arguments;
  CLI::App app("How a running set-up fares.", "vantage-top");
  vantage::AddOptions(app, &arguments);
  if (const std::optional<int> code = vantage::ParseCommandLine(app, argc, argv)) return *code;
  const vantage::Result<int> code = vantage::Run(arguments);
  if (code) return *code;
  std::fprintf(stderr, "vantage-top: %s\n", code.error().message.c_str());
  return vantage::kBadInput;
}
