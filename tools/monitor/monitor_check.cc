#include "tools/monitor/monitor_check.h"

#include <algorithm>
#include <array>
#include <cinttypes>
#include <cmath>

#include "common/format.h"
#include "tools/monitor/shown_text.h"

namespace vantage {
namespace {

double Seconds(int64_t us) { return 1e-6 * static_cast<double>(us); }

template <size_t kSize>
std::string StateText(const std::array<const char*, kSize>& names, int state) {
  if (state < 0 || state >= static_cast<int>(kSize)) return "in an unknown state";
  return names[static_cast<size_t>(state)];
}

class Problems {
 public:
  Problems(const MonitorModel& model,
           const ExpectedSetup& expected,
           const MonitorLimits& limits,
           int64_t now)
      : model_(model), expected_(expected), limits_(limits), now_(now) {}

  std::vector<std::string> Find();

 private:
  void Tell(std::string sentence) { found_.push_back(std::move(sentence)); }
  void LookForExpected();
  void LookAtProcess(const std::string& name, const SeenProcess& process);
  void LookAtSilence(const std::string& who, const SeenProcess& process);
  void LookAtLosses(const std::string& who, const SeenProcess& process);
  void LookAtStages(const std::string& who, const process_status_t& status);
  void LookAtCamera(const std::string& name, const SeenCamera& camera);
  void LookAtHandEye(const std::string& name, const handeye_check_t& check);
  void LookAtChannel(const std::string& name, const SeenChannel& channel);
  void LookAtConfigs();

  const MonitorModel& model_;
  const ExpectedSetup& expected_;
  const MonitorLimits& limits_;
  int64_t now_;
  std::vector<std::string> found_;
};

std::vector<std::string> Problems::Find() {
  LookForExpected();
  for (const auto& [name, process] : model_.processes()) {
    if (!IsWatcher(name)) LookAtProcess(name, process);
  }
  LookAtConfigs();
  for (const auto& [name, camera] : model_.cameras()) LookAtCamera(name, camera);
  for (const auto& [name, seen] : model_.hand_eyes()) LookAtHandEye(name, seen.check);
  for (const auto& [name, channel] : model_.channels()) LookAtChannel(name, channel);
  if (model_.num_not_kept() > 0) {
    Tell(Format("the bus has more channels, processes or cameras than are watched: %" PRId64
                " messages were left aside",
                model_.num_not_kept()));
  }
  return found_;
}

void Problems::LookForExpected() {
  const bool has_process = std::ranges::any_of(
      model_.processes(), [](const auto& each) { return !IsWatcher(each.first); });
  if (!has_process && expected_.processes.empty()) {
    Tell("no process was heard: nothing came on PROCESS_STATUS");
  }
  for (const std::string& name : expected_.processes) {
    if (model_.processes().contains(name)) continue;
    Tell(Format("process %s was never heard, but the configuration has it", Shown(name).c_str()));
  }
  for (const std::string& name : expected_.cameras) {
    if (model_.cameras().contains(name)) continue;
    Tell(Format("camera %s was never heard, but the configuration has it", Shown(name).c_str()));
  }
}

void Problems::LookAtProcess(const std::string& name, const SeenProcess& process) {
  const process_status_t& status = process.status;
  const std::string who = "process " + Shown(name, 64);
  LookAtSilence(who, process);
  if (process.num_conflicts > 0) {
    Tell(Format("%s: two processes have this name, the last with pid %d on %s",
                who.c_str(),
                status.pid,
                Shown(status.host, 64).c_str()));
  } else if (process.num_restarts > 0) {
    Tell(Format("%s: started again%s, its pid is now %d",
                who.c_str(),
                process.num_restarts > 1 ? Format(" %d times", process.num_restarts).c_str() : "",
                status.pid));
  }
  if (status.state != "ok") {
    Tell(Format("%s: %s", who.c_str(), Shown(status.state).c_str()));
  } else if (!process.fault.empty()) {
    Tell(Format("%s: it is ok again, but was not: %s", who.c_str(), Shown(process.fault).c_str()));
  }
  if (status.receive_buffer_granted < status.receive_buffer_requested) {
    Tell(
        Format("%s: it asked for a receive buffer of %d bytes and was granted %d; run: sysctl -w "
               "net.core.rmem_max=%d",
               who.c_str(),
               status.receive_buffer_requested,
               status.receive_buffer_granted,
               status.receive_buffer_requested));
  }
  LookAtLosses(who, process);
  LookAtStages(who, status);
}

void Problems::LookAtSilence(const std::string& who, const SeenProcess& process) {
  const double silence = Seconds(now_ - process.last_utime);
  if (silence > limits_.max_silence) {
    Tell(Format("%s: silent for %.1f s (pid %d on %s)",
                who.c_str(),
                silence,
                process.status.pid,
                Shown(process.status.host, 64).c_str()));
  } else if (Seconds(process.longest_silence) > limits_.max_silence && process.num_restarts == 0) {
    Tell(Format("%s: it was silent for %.1f s", who.c_str(), Seconds(process.longest_silence)));
  }
}

void Problems::LookAtLosses(const std::string& who, const SeenProcess& process) {
  for (const auto& [channel, losses] : process.losses) {
    if (losses.lost > limits_.max_lost) {
      Tell(Format("%s: %" PRId64 " messages of %s were lost",
                  who.c_str(),
                  losses.lost,
                  Shown(channel, 64).c_str()));
    }
    if (losses.decode_errors > limits_.max_decode_errors) {
      Tell(Format("%s: %" PRId64 " messages of %s could not be decoded",
                  who.c_str(),
                  losses.decode_errors,
                  Shown(channel, 64).c_str()));
    }
  }
}

void Problems::LookAtStages(const std::string& who, const process_status_t& status) {
  for (const stage_status_t& stage : status.stages) {
    const auto limit = limits_.max_p99.find(stage.stage);
    // What is no number is over any limit.
    if (limit == limits_.max_p99.end() || stage.latency_p99 <= limit->second) continue;
    Tell(Format("%s: p99 of stage %s is %s, over the limit of %s",
                who.c_str(),
                Shown(stage.stage, 64).c_str(),
                LatencyText(stage.latency_p99).c_str(),
                LatencyText(limit->second).c_str()));
  }
}

void Problems::LookAtCamera(const std::string& name, const SeenCamera& camera) {
  const camera_status_v2_t& status = camera.status;
  const std::string who = "camera " + Shown(name, 64);
  const double silence = Seconds(now_ - camera.last_utime);
  if (silence > limits_.max_silence) {
    Tell(Format("%s: silent for %.1f s", who.c_str(), silence));
  }
  if (status.state != camera_status_v2_t::STREAMING) {
    Tell(Format("%s: %s%s%s",
                who.c_str(),
                CameraStateText(status.state).c_str(),
                status.message.empty() ? "" : ": ",
                Shown(status.message).c_str()));
  } else if (camera.num_interruptions > 0) {
    Tell(Format(
        "%s: it streams again, but stopped %d times", who.c_str(), camera.num_interruptions));
  }
  const auto missed = static_cast<double>(camera.num_missed);
  const double all = missed + static_cast<double>(camera.num_captured);
  if (missed > limits_.max_missed * all) {
    Tell(Format("%s: %.0f of %.0f frames never came from the device", who.c_str(), missed, all));
  }
  if (!(status.latency <= limits_.max_camera_latency)) {
    Tell(Format("%s: the latency is %s, over the limit of %s",
                who.c_str(),
                LatencyText(status.latency).c_str(),
                LatencyText(limits_.max_camera_latency).c_str()));
  }
}

void Problems::LookAtHandEye(const std::string& name, const handeye_check_t& check) {
  if (check.state == handeye_check_t::HOLDS || check.state == handeye_check_t::UNKNOWN) return;
  Tell(Format("hand-eye calibration of camera %s: %s%s%s",
              Shown(name, 64).c_str(),
              HandEyeStateText(check.state).c_str(),
              check.reason.empty() ? "" : ": ",
              Shown(check.reason).c_str()));
}

void Problems::LookAtChannel(const std::string& name, const SeenChannel& channel) {
  if (channel.num_lost > limits_.max_lost) {
    Tell(Format("channel %s: %" PRId64 " messages did not arrive here",
                Shown(name, 64).c_str(),
                channel.num_lost));
  }
  if (channel.num_malformed > limits_.max_decode_errors) {
    Tell(Format("channel %s: %" PRId64 " messages are malformed",
                Shown(name, 64).c_str(),
                channel.num_malformed));
  }
  if (channel.type == "(several)") {
    Tell(Format("channel %s: messages of several types", Shown(name, 64).c_str()));
  }
}

void Problems::LookAtConfigs() {
  const bool is_given = !expected_.config_hash.empty();
  const std::string common = is_given ? expected_.config_hash : model_.CommonConfigHash();
  for (const auto& [name, process] : model_.processes()) {
    const std::string& hash = process.status.config_hash;
    if (IsWatcher(name) || hash.empty() || hash == common) continue;
    Tell(Format("process %s: it runs with another configuration (%s) than %s (%s)",
                Shown(name, 64).c_str(),
                Shown(hash, 32).c_str(),
                is_given ? "the one given" : "the others",
                Shown(common, 32).c_str()));
  }
}

}  // namespace

std::vector<std::string> FindProblems(const MonitorModel& model,
                                      const ExpectedSetup& expected,
                                      const MonitorLimits& limits,
                                      int64_t now) {
  return Problems(model, expected, limits, now).Find();
}

std::string CameraStateText(int state) {
  return StateText<5>({"searching", "opening", "streaming", "stalled", "lost"}, state);
}
std::string ArmStateText(int state) {
  return StateText<3>({"resting", "moving", "refused"}, state);
}
std::string HandEyeStateText(int state) {
  return StateText<4>({"unknown", "holds", "drifted", "distorted"}, state);
}

}  // namespace vantage
