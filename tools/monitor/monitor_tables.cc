#include "tools/monitor/monitor_tables.h"

#include <algorithm>
#include <cinttypes>
#include <ctime>

#include "common/format.h"
#include "common/so3.h"
#include "tools/monitor/monitor_check.h"
#include "tools/monitor/shown_text.h"

namespace vantage {
namespace {

using Style = ScreenLine::Style;

// Both may come from outside: a difference of integers could overflow.
double SecondsSince(int64_t utime, int64_t now) {
  return 1e-6 * (static_cast<double>(now) - static_cast<double>(utime));
}

// Of a count that comes from outside: short enough for its column.
std::string CountText(int64_t count) {
  if (count >= -9999 && count <= 99999) return Format("%" PRId64, count);
  return ScaledText(static_cast<double>(count));
}

std::string AgeText(double seconds) {
  if (!(seconds >= 0.0)) return "-";
  return seconds < 100.0 ? NumberText(seconds) : DurationText(seconds);
}

std::string ClockText(int64_t utime) {
  const std::time_t seconds = utime / 1'000'000;
  std::tm parts{};
  if (utime <= 0 || localtime_r(&seconds, &parts) == nullptr) return "-";
  return Format("%02d:%02d:%02d", parts.tm_hour, parts.tm_min, parts.tm_sec);
}

std::string DateText(int64_t utime) {
  const std::time_t seconds = utime / 1'000'000;
  std::tm parts{};
  if (utime <= 0 || localtime_r(&seconds, &parts) == nullptr) return "-";
  char text[40];
  return strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S", &parts) > 0 ? text : "-";
}

std::string HashText(const MonitorModel& model, const process_status_t& status) {
  if (status.config_hash.empty()) return "-";
  const bool differs = status.config_hash != model.CommonConfigHash() && !IsWatcher(status.name);
  return Shown(status.config_hash.substr(0, 6)) + (differs ? "*" : "");
}

ScreenLine ProcessLine(const MonitorModel& model, const SeenProcess& process, int64_t now) {
  const process_status_t& status = process.status;
  ChannelLosses all;
  for (const auto& [channel, losses] : process.losses) {
    all.lost += losses.lost;
    all.overwritten += losses.overwritten;
    all.decode_errors += losses.decode_errors;
  }
  double p99 = 0.0;
  for (const stage_status_t& stage : status.stages) p99 = std::max(p99, stage.latency_p99);
  const bool is_small = status.receive_buffer_granted < status.receive_buffer_requested;
  const double age = SecondsSince(process.last_utime, now);
  ScreenLine line;
  line.text = Padded(status.name, 11) +
              Format(" %7d %8s %4s %5s %5s %4s %7s %6s%s %7s ",
                     status.pid,
                     DurationText(SecondsSince(status.start_utime, process.last_utime)).c_str(),
                     AgeText(age).c_str(),
                     CountText(all.lost).c_str(),
                     CountText(all.overwritten).c_str(),
                     CountText(all.decode_errors).c_str(),
                     status.stages.empty() ? "-" : LatencyText(p99).c_str(),
                     ScaledText(status.receive_buffer_granted).c_str(),
                     is_small ? "!" : " ",
                     HashText(model, status).c_str()) +
              Shown(status.state);
  const bool is_wrong = status.state != "ok" || age > MonitorLimits().max_silence || is_small;
  line.style = is_wrong && !IsWatcher(status.name) ? Style::kWrong : Style::kPlain;
  return line;
}

std::string Counted(size_t count, const char* one, const char* many) {
  return Format("%zu %s", count, count == 1 ? one : many);
}

ScreenLine Heading(std::string text) { return {std::move(text), Style::kHeading}; }

}  // namespace

ScreenLine TitleLine(const MonitorModel& model, const std::string& where, int64_t now) {
  double bandwidth = 0.0;
  for (const auto& [name, channel] : model.channels()) bandwidth += channel.arrivals.Bandwidth(now);
  return Heading(Format("vantage-top  %s  %s, %s, %s, %sB/s  %s",
                        ClockText(now).c_str(),
                        Counted(model.processes().size(), "process", "processes").c_str(),
                        Counted(model.cameras().size(), "camera", "cameras").c_str(),
                        Counted(model.channels().size(), "channel", "channels").c_str(),
                        ScaledText(bandwidth).c_str(),
                        Shown(where, 100).c_str()));
}

std::vector<ScreenLine> ProcessTable(const MonitorModel& model, int64_t now) {
  std::vector<ScreenLine> lines = {
      Heading("PROCESS         PID       UP  AGE  LOST OVERW  ERR     P99 BUFFER   CONFIG STATE")};
  for (const auto& [name, process] : model.processes()) {
    lines.push_back(ProcessLine(model, process, now));
  }
  return lines;
}

std::vector<ScreenLine> ProcessDetails(const MonitorModel& model,
                                       const SeenProcess& process,
                                       int64_t now) {
  const process_status_t& status = process.status;
  std::vector<ScreenLine> lines;
  lines.push_back(Heading(Format("%s on %s, pid %d, version %s, up since %s, config %s",
                                 Shown(status.name, 64).c_str(),
                                 Shown(status.host, 64).c_str(),
                                 status.pid,
                                 Shown(status.version, 32).c_str(),
                                 DateText(status.start_utime).c_str(),
                                 HashText(model, status).c_str())));
  lines.push_back({Format("state: %s", Shown(status.state).c_str()),
                   status.state == "ok" ? Style::kPlain : Style::kWrong});
  lines.push_back(
      {Format("last status %s s ago; receive buffer %d of %d bytes; started again %d "
              "times",
              AgeText(SecondsSince(process.last_utime, now)).c_str(),
              status.receive_buffer_granted,
              status.receive_buffer_requested,
              process.num_restarts)});
  if (!status.channels.empty()) {
    lines.push_back(
        Heading("  HEARS                               RECEIVED     HZ  LOST OVERW  ERR   AGE"));
  }
  for (const channel_status_t& channel : status.channels) {
    const bool is_wrong = channel.num_lost > 0 || channel.num_decode_errors > 0;
    lines.push_back({"  " + Padded(channel.channel, 34) +
                         Format(" %9s %6s %5s %5s %4s %5s",
                                CountText(channel.num_received).c_str(),
                                NumberText(channel.rate).c_str(),
                                CountText(channel.num_lost).c_str(),
                                CountText(channel.num_overwritten).c_str(),
                                CountText(channel.num_decode_errors).c_str(),
                                AgeText(channel.age).c_str()),
                     is_wrong ? Style::kWrong : Style::kPlain});
  }
  if (!status.stages.empty()) {
    lines.push_back(
        Heading("  STAGE                                   RUNS     P50     P99     MAX"));
  }
  for (const stage_status_t& stage : status.stages) {
    lines.push_back({"  " + Padded(stage.stage, 34) +
                     Format(" %9s %7s %7s %7s",
                            CountText(stage.num_runs).c_str(),
                            LatencyText(stage.latency_p50).c_str(),
                            LatencyText(stage.latency_p99).c_str(),
                            LatencyText(stage.latency_max).c_str())});
  }
  return lines;
}

std::vector<ScreenLine> CameraTable(const MonitorModel& model, int64_t now) {
  if (model.cameras().empty()) return {};
  std::vector<ScreenLine> lines = {Heading(
      "CAMERA        STATE       FPS  SENT DROPPED MISSED LATENCY    OFFSET   AGE  MESSAGE")};
  for (const auto& [name, camera] : model.cameras()) {
    const camera_status_v2_t& status = camera.status;
    const bool streams = status.state == camera_status_v2_t::STREAMING;
    lines.push_back({Padded(name, 13) + " " + Padded(CameraStateText(status.state), 9) +
                         Format(" %5s %5s %7s %6s %7s %9s %5s  ",
                                NumberText(status.fps).c_str(),
                                CountText(status.num_published).c_str(),
                                CountText(status.num_dropped).c_str(),
                                CountText(status.num_missed).c_str(),
                                LatencyText(status.latency).c_str(),
                                LatencyText(status.clock_offset).c_str(),
                                AgeText(SecondsSince(camera.last_utime, now)).c_str()) +
                         Shown(status.message),
                     streams ? Style::kPlain : Style::kWrong});
  }
  return lines;
}

std::vector<ScreenLine> ArmLines(const MonitorModel& model, int64_t now) {
  std::vector<ScreenLine> lines;
  for (const auto& [name, arm] : model.arms()) {
    const arm_status_t& status = arm.status;
    lines.push_back({Format("arm of %s: %s, %s s left, view %" PRId64 ", %s s ago  %s",
                            Shown(name, 32).c_str(),
                            ArmStateText(status.state).c_str(),
                            NumberText(status.remaining).c_str(),
                            status.view_seq,
                            AgeText(SecondsSince(arm.last_utime, now)).c_str(),
                            Shown(status.reason).c_str())});
  }
  for (const auto& [name, seen] : model.hand_eyes()) {
    const handeye_check_t& check = seen.check;
    const bool is_wrong =
        check.state != handeye_check_t::HOLDS && check.state != handeye_check_t::UNKNOWN;
    lines.push_back({Format("hand-eye of %s: %s by %s, %s deg, %s mm off in %d views  %s",
                            Shown(name, 32).c_str(),
                            HandEyeStateText(check.state).c_str(),
                            Shown(check.source, 16).c_str(),
                            NumberText(check.rotation / kDegree).c_str(),
                            NumberText(1e3 * check.translation).c_str(),
                            check.num_views,
                            Shown(check.reason).c_str()),
                     is_wrong ? Style::kWrong : Style::kPlain});
  }
  return lines;
}

std::vector<ScreenLine> ChannelTable(const MonitorModel& model, ChannelOrder order, int64_t now) {
  struct Row {
    double key;
    std::string name;
    const SeenChannel* channel;
  };
  std::vector<Row> rows;
  for (const auto& [name, channel] : model.channels()) {
    const double keys[] = {0.0,
                           channel.arrivals.Rate(now),
                           channel.arrivals.Bandwidth(now),
                           static_cast<double>(channel.num_lost),
                           SecondsSince(channel.last_utime, now),
                           channel.arrivals.Jitter()};
    rows.push_back({keys[static_cast<size_t>(order)], name, &channel});
  }
  std::ranges::stable_sort(rows, [](const Row& a, const Row& b) { return a.key > b.key; });
  std::vector<ScreenLine> lines = {
      Heading("CHANNEL                  TYPE                    HZ     B/S  LOST    AGE  JITTER")};
  for (const auto& [key, name, channel] : rows) {
    const bool is_wrong = channel->num_lost > 0 || channel->num_malformed > 0;
    lines.push_back({Padded(name, 24) + " " + Padded(channel->type, 19) +
                         Format(" %6s %7s %5s %6s %7s",
                                NumberText(channel->arrivals.Rate(now)).c_str(),
                                ScaledText(channel->arrivals.Bandwidth(now)).c_str(),
                                CountText(channel->num_lost).c_str(),
                                AgeText(SecondsSince(channel->last_utime, now)).c_str(),
                                LatencyText(channel->arrivals.Jitter()).c_str()),
                     is_wrong ? Style::kWrong : Style::kPlain});
  }
  return lines;
}

const char* OrderName(ChannelOrder order) {
  constexpr const char* kNames[] = {"name", "rate", "bandwidth", "lost", "age", "jitter"};
  return kNames[static_cast<size_t>(order)];
}

}  // namespace vantage
