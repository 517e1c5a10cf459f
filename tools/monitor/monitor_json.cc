#include "tools/monitor/monitor_json.h"

#include <nlohmann/json.hpp>

#include "tools/monitor/monitor_check.h"

namespace vantage {
namespace {

using nlohmann::ordered_json;

// Both may come from outside: a difference of integers could overflow.
double SecondsSince(int64_t utime, int64_t now) {
  return 1e-6 * (static_cast<double>(now) - static_cast<double>(utime));
}

ordered_json ChannelJson(const channel_status_t& channel, const SeenProcess& process) {
  const auto found = process.losses.find(channel.channel);
  const ChannelLosses losses = found == process.losses.end() ? ChannelLosses{} : found->second;
  return {{"channel", channel.channel},
          {"num_received", channel.num_received},
          {"num_lost", channel.num_lost},
          {"num_overwritten", channel.num_overwritten},
          {"num_decode_errors", channel.num_decode_errors},
          {"lost_since_watched", losses.lost},
          {"decode_errors_since_watched", losses.decode_errors},
          {"age", channel.age},
          {"rate", channel.rate}};
}

ordered_json ProcessJson(const SeenProcess& process, int64_t now) {
  const process_status_t& status = process.status;
  ordered_json channels = ordered_json::array();
  for (const channel_status_t& channel : status.channels) {
    channels.push_back(ChannelJson(channel, process));
  }
  ordered_json stages = ordered_json::array();
  for (const stage_status_t& stage : status.stages) {
    stages.push_back({{"stage", stage.stage},
                      {"num_runs", stage.num_runs},
                      {"latency_p50", stage.latency_p50},
                      {"latency_p99", stage.latency_p99},
                      {"latency_max", stage.latency_max}});
  }
  return {{"name", status.name},
          {"host", status.host},
          {"pid", status.pid},
          {"version", status.version},
          {"config_hash", status.config_hash},
          {"start_utime", status.start_utime},
          {"state", status.state},
          {"age", SecondsSince(process.last_utime, now)},
          {"num_restarts", process.num_restarts},
          {"receive_buffer_requested", status.receive_buffer_requested},
          {"receive_buffer_granted", status.receive_buffer_granted},
          {"channels", channels},
          {"stages", stages}};
}

ordered_json CameraJson(const SeenCamera& camera, int64_t now) {
  const camera_status_v2_t& status = camera.status;
  return {{"name", status.name},
          {"serial", status.serial},
          {"state", CameraStateText(status.state)},
          {"message", status.message},
          {"num_captured", status.num_captured},
          {"num_published", status.num_published},
          {"num_dropped", status.num_dropped},
          {"num_missed", status.num_missed},
          {"num_reconnects", status.num_reconnects},
          {"fps", status.fps},
          {"latency", status.latency},
          {"clock_offset", status.clock_offset},
          {"age", SecondsSince(camera.last_utime, now)}};
}

}  // namespace

std::string MonitorJson(const MonitorModel& model,
                        const std::vector<std::string>& problems,
                        int64_t now) {
  ordered_json json = {{"ok", problems.empty()}, {"utime", now}, {"problems", problems}};
  json["processes"] = ordered_json::array();
  for (const auto& [name, process] : model.processes()) {
    json["processes"].push_back(ProcessJson(process, now));
  }
  json["cameras"] = ordered_json::array();
  for (const auto& [name, camera] : model.cameras()) {
    json["cameras"].push_back(CameraJson(camera, now));
  }
  json["arms"] = ordered_json::array();
  for (const auto& [name, arm] : model.arms()) {
    json["arms"].push_back({{"name", name},
                            {"state", ArmStateText(arm.status.state)},
                            {"view_seq", arm.status.view_seq},
                            {"remaining", arm.status.remaining},
                            {"reason", arm.status.reason},
                            {"age", SecondsSince(arm.last_utime, now)}});
  }
  json["hand_eye"] = ordered_json::array();
  for (const auto& [name, seen] : model.hand_eyes()) {
    json["hand_eye"].push_back({{"camera", name},
                                {"state", HandEyeStateText(seen.check.state)},
                                {"rotation", seen.check.rotation},
                                {"translation", seen.check.translation},
                                {"num_views", seen.check.num_views},
                                {"reason", seen.check.reason},
                                {"age", SecondsSince(seen.last_utime, now)}});
  }
  json["channels"] = ordered_json::array();
  for (const auto& [name, channel] : model.channels()) {
    json["channels"].push_back({{"channel", name},
                                {"type", channel.type},
                                {"num_messages", channel.num_messages},
                                {"num_bytes", channel.num_bytes},
                                {"num_lost", channel.num_lost},
                                {"num_malformed", channel.num_malformed},
                                {"rate", channel.arrivals.Rate(now)},
                                {"bandwidth", channel.arrivals.Bandwidth(now)},
                                {"jitter", channel.arrivals.Jitter()},
                                {"age", SecondsSince(channel.last_utime, now)}});
  }
  return json.dump(2, ' ', true, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace vantage
