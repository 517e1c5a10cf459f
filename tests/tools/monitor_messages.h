#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bus/message_check.h"
#include "tools/monitor/monitor_model.h"
#include "tools/monitor/monitor_screen.h"

namespace vantage {

constexpr int64_t kSecond = 1'000'000;               // us
constexpr int64_t kStart = 1'700'000'000 * kSecond;  // us since the epoch

/// Of a process that is well, started a minute before kStart, with a channel and a stage.
inline process_status_t MadeProcess(const std::string& name) {
  process_status_t status{};
  status.utime = kStart;
  status.seq = 1;
  status.name = name;
  status.host = "robot";
  status.pid = 100;
  status.version = "0.1.0";
  status.config_hash = "3a02334f5b6c7d8e";
  status.start_utime = kStart - 60 * kSecond;
  status.state = "ok";
  status.receive_buffer_requested = 4194304;
  status.receive_buffer_granted = 4194304;
  channel_status_t channel{};
  channel.channel = "CAMERA_XTION";
  channel.num_received = 600;
  channel.age = 0.05;
  channel.rate = 10.0;
  status.channels = {channel};
  status.num_channels = 1;
  stage_status_t stage{};
  stage.stage = "match";
  stage.num_runs = 50;
  stage.latency_p50 = 0.02;
  stage.latency_p99 = 0.03;
  stage.latency_max = 0.04;
  status.stages = {stage};
  status.num_stages = 1;
  return status;
}

/// Of a camera that streams.
inline camera_status_v2_t MadeCamera(const std::string& name) {
  camera_status_v2_t status{};
  status.utime = kStart;
  status.seq = 1;
  status.name = name;
  status.serial = "S1";
  status.state = camera_status_v2_t::STREAMING;
  status.num_captured = 1000;
  status.fps = 30.0;
  status.latency = 0.002;
  return status;
}

template <class Message>
void Send(MonitorModel* model, const std::string& channel, const Message& message, int64_t utime) {
  model->Add(channel, utime, Encode(message));
}

inline std::string TextOf(const std::vector<ScreenLine>& lines) {
  std::string text;
  for (const ScreenLine& line : lines) text += line.text + "\n";
  return text;
}

}  // namespace vantage
