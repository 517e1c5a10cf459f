// vantage-progress: tells what a running set-up does, as it happens, until it has found its
// objects.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "bus/live_bus.h"
#include "common/format.h"
#include "nodes/command_line.h"
#include "nodes/config_reader.h"
#include "nodes/process.h"
#include "tools/support/recorded_run.h"
#include "tools/support/report_setup.h"
#include "tools/support/run_metrics.h"
#include "vantage/arm_status_t.hpp"
#include "vantage/camera_status_v2_t.hpp"
#include "vantage/detections_v2_t.hpp"
#include "vantage/next_view_t.hpp"
#include "vantage/object_estimates_v3_t.hpp"
#include "vantage/process_status_t.hpp"

namespace vantage {
namespace {

constexpr int kTimeout = 3;         // Exit code.
constexpr size_t kMaxNames = 100;   // Of channels and processes: names come from outside.
constexpr double kSilentAfter = 5;  // s without a PROCESS_STATUS, which comes every second.
constexpr const char* kOwnName = "progress";

struct Arguments {
  std::string config;
  std::string url;
  double timeout = 0.0;  // s; 0: none
  bool until_finished = false;
};

using Clock = std::chrono::steady_clock;

class Progress {
 public:
  Progress(ReportSetup setup, double timeout)
      : setup_(std::move(setup)), timeout_(timeout), is_terminal_(isatty(STDOUT_FILENO) != 0) {}

  Result<void> Subscribe(Bus& bus);

  [[nodiscard]] bool finished() const { return finished_; }
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(Clock::now() - start_).count();
  }
  /// On a terminal, one line that is written over: time left, and who was heard.
  void ShowStatus() const;
  /// Which of those who should speak are silent, in one sentence.
  [[nodiscard]] std::string WhoIsSilent() const;

 private:
  template <class Message>
  Result<void> On(Bus& bus, const std::string& channel, void (Progress::*handler)(const Message&)) {
    return bus.Subscribe<Message>(
        channel, {}, [this, handler](const Envelope& envelope, const Message& message) {
          if (heard_.size() < kMaxNames) heard_.insert(envelope.channel);
          (this->*handler)(message);
        });
  }

  void OnProcess(const process_status_t& message);
  void OnCamera(const camera_status_v2_t& message);
  void OnArm(const arm_status_t& message);
  void OnNextView(const next_view_t& message);
  void OnObjects(const object_estimates_v3_t& message);
  void OnDetections(const detections_v2_t& /*message*/) { ++num_detections_; }
  void Say(const std::string& line) const;
  [[nodiscard]] std::string DescribeObject(const object_estimate_v3_t& object,
                                           const std::map<size_t, int32_t>& matches) const;

  ReportSetup setup_;
  double timeout_;
  bool is_terminal_;
  Clock::time_point start_ = Clock::now();
  std::set<std::string> heard_;
  struct Process {
    int64_t start_utime = 0;
    std::string state;
    double heard_at = 0.0;  // s
  };
  std::map<std::string, Process> processes_;  // By name.
  std::map<std::string, int> camera_states_;
  std::pair<int, int64_t> arm_state_{-1, -1};
  int64_t decision_ = -1;
  int num_viewpoints_ = 0;
  int64_t num_detections_ = 0;
  bool finished_ = false;
};

Result<void> Progress::Subscribe(Bus& bus) {
  const Result<void> all[] = {On(bus, "PROCESS_STATUS", &Progress::OnProcess),
                              On(bus, "CAMERA_.*_STATUS", &Progress::OnCamera),
                              On(bus, "ARM_STATUS", &Progress::OnArm),
                              On(bus, "NEXT_VIEW", &Progress::OnNextView),
                              On(bus, "DETECTIONS_.*", &Progress::OnDetections),
                              On(bus, "OBJECTS", &Progress::OnObjects)};
  for (const Result<void>& each : all) {
    if (!each) return each;
  }
  return {};
}

void Progress::Say(const std::string& line) const {
  // Names and reasons come from the bus: what would steer a terminal is shown as a question mark.
  std::string printable = line;
  for (char& c : printable) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  }
  if (is_terminal_) std::printf("\r\033[K");
  std::printf("%s\n", printable.c_str());
  std::fflush(stdout);
}

void Progress::ShowStatus() const {
  if (!is_terminal_) return;
  std::printf("\r\033[K%5.1f s", seconds());
  if (timeout_ > 0.0) std::printf(", %.0f s left", std::max(0.0, timeout_ - seconds()));
  std::printf(", %d views, %jd images searched", num_viewpoints_, intmax_t{num_detections_});
  std::fflush(stdout);
}

std::string Progress::WhoIsSilent() const {
  std::string silent;
  const auto expect = [&](const std::string& channel, const std::string& sender) {
    for (const std::string& heard : heard_) {
      if (heard.starts_with(channel)) return;
    }
    silent += (silent.empty() ? "nothing was heard on " : ", ") + channel + " (" + sender + ")";
  };
  expect("CAMERA_" + setup_.camera + "_STATUS", "the camera driver");
  expect("DETECTIONS_", "an estimator, e.g. vantage-ppf");
  expect("OBJECTS", "vantage-fusion");
  for (const auto& [name, process] : processes_) {
    const double silence = seconds() - process.heard_at;
    if (silence < kSilentAfter) continue;
    silent += Format("%sprocess %s has been silent for %.0f s",
                     silent.empty() ? "" : ", ",
                     name.c_str(),
                     silence);
  }
  if (silent.empty()) {
    silent =
        Format("all are heard, but the objects have not converged after %d views", num_viewpoints_);
  }
  return silent;
}

void Progress::OnProcess(const process_status_t& message) {
  if (message.name == kOwnName) return;
  const bool known = processes_.contains(message.name);
  if (!known && processes_.size() >= kMaxNames) return;
  Process& process = processes_[message.name];
  process.heard_at = seconds();
  if (!known) {
    Say(Format("process %s is up (pid %d, receive buffer %d bytes)",
               message.name.c_str(),
               message.pid,
               message.receive_buffer_granted));
  } else if (process.start_utime != message.start_utime) {
    Say(Format("process %s was started again (pid %d)", message.name.c_str(), message.pid));
  }
  process.start_utime = message.start_utime;
  if (process.state != message.state && (message.state != "ok" || !process.state.empty())) {
    Say(Format("process %s: %s", message.name.c_str(), message.state.c_str()));
  }
  process.state = message.state;
}

void Progress::OnCamera(const camera_status_v2_t& message) {
  static const char* const kNames[] = {"searching", "opening", "streaming", "stalled", "lost"};
  const auto known = camera_states_.find(message.name);
  if (known != camera_states_.end() && known->second == message.state) return;
  camera_states_[message.name] = message.state;
  const bool valid = message.state >= 0 && message.state < 5;
  Say(Format("camera %s: %s%s%s",
             message.name.c_str(),
             valid ? kNames[message.state] : "in an unknown state",
             message.message.empty() ? "" : ": ",
             message.message.c_str()));
}

void Progress::OnArm(const arm_status_t& message) {
  const std::pair<int, int64_t> state{message.state, message.view_seq};
  if (state == arm_state_) return;
  arm_state_ = state;
  if (message.state == arm_status_t::MOVING) {
    Say(Format("arm: moving, %.1f s", message.remaining));
  } else if (message.state == arm_status_t::REFUSED) {
    Say(Format("arm: refuses the view: %s", message.reason.c_str()));
  }
}

void Progress::OnNextView(const next_view_t& message) {
  if (message.seq == decision_) return;
  decision_ = message.seq;
  Say(Format("next view: %s", message.reason.c_str()));
}

std::string Progress::DescribeObject(const object_estimate_v3_t& object,
                                     const std::map<size_t, int32_t>& matches) const {
  std::string text = object.model_id;
  const std::optional<Pose> pose = EstimatedPose(object);
  for (const auto& [truth, instance] : matches) {
    if (instance != object.instance_id || !pose) continue;
    const auto model = setup_.models.find(object.model_id);
    if (model == setup_.models.end()) continue;
    const PoseError error = ErrorOf(model->second, *pose, setup_.truth[truth].T_world_object);
    text += Format(" %.2f deg %.1f mm", error.angle / kDegree, 1e3 * error.distance);
  }
  if (object.last_change >= 0.0) text += Format(" (moved %.2f deg)", object.last_change / kDegree);
  if (object.state == object_estimate_v3_t::TENTATIVE) text += " (seen once)";
  return text;
}

void Progress::OnObjects(const object_estimates_v3_t& message) {
  if (message.num_viewpoints != num_viewpoints_) {
    num_viewpoints_ = message.num_viewpoints;
    const std::map<size_t, int32_t> matches = MatchToTruth(message, setup_);
    std::string line = Format("view %d:", num_viewpoints_);
    for (const object_estimate_v3_t& object : message.objects) {
      line += "  " + DescribeObject(object, matches);
    }
    Say(line + (message.objects.empty() ? " nothing found" : ""));
  }
  finished_ = message.finished != 0;
}

int Fail(const Error& error) {
  std::fprintf(stderr, "vantage-progress: %s\n", error.message.c_str());
  return 2;
}

int Run(const Arguments& arguments) {
  Result<ReportSetup> setup = LoadReportSetup(arguments.config);
  if (!setup) return Fail(setup.error());
  Result<ConfigReader> config = ConfigReader::Open(arguments.config);
  if (!config) return Fail(config.error());
  LiveBus::Options options = ReadBusOptions(*config);
  options.name = kOwnName;
  if (!arguments.url.empty()) options.url = arguments.url;
  Result<std::unique_ptr<LiveBus>> bus = LiveBus::Create(options);
  if (!bus) return Fail(bus.error());
  Progress progress(std::move(setup).value(), arguments.timeout);
  if (Result<void> subscribed = progress.Subscribe(**bus); !subscribed) {
    return Fail(subscribed.error());
  }
  while (true) {
    (*bus)->Dispatch(std::chrono::milliseconds(100));
    progress.ShowStatus();
    if (arguments.until_finished && progress.finished()) break;
    if (arguments.timeout > 0.0 && progress.seconds() > arguments.timeout) {
      std::fprintf(stderr,
                   "%svantage-progress: not finished within %.0f s: %s\n",
                   isatty(STDOUT_FILENO) != 0 ? "\n" : "",
                   arguments.timeout,
                   progress.WhoIsSilent().c_str());
      return kTimeout;
    }
  }
  std::printf("%sfinished after %.1f s\n",
              isatty(STDOUT_FILENO) != 0 ? "\r\033[K" : "",
              progress.seconds());
  return 0;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  vantage::Arguments arguments;
  CLI::App app("Tells what a running set-up does, as it happens", "vantage-progress");
  app.add_option("--config,-c", arguments.config, "TOML file of the set-up")->required();
  app.add_option("--lcm-url", arguments.url, "LCM URL; default: [bus] url, then LCM_DEFAULT_URL");
  app.add_option("--timeout", arguments.timeout, "give up after so many seconds (exit code 3)")
      ->check(CLI::PositiveNumber);
  app.add_flag("--until-finished", arguments.until_finished, "end when all objects are found");
  if (const std::optional<int> code = vantage::ParseCommandLine(app, argc, argv)) return *code;
  return vantage::Run(arguments);
}
