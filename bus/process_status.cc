#include "bus/process_status.h"

#include <algorithm>
#include <vector>

namespace vantage {
namespace {

constexpr std::chrono::seconds kReportInterval(5);
constexpr std::chrono::milliseconds kShortestWindow(500);

double Seconds(ProcessStatus::Clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

}  // namespace

void ProcessStatus::AddChannel(const std::string& channel) {
  const std::lock_guard lock(mutex_);
  Find(channel);
}

void ProcessStatus::RecordReceived(const std::string& channel, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  Channel& entry = Find(channel);
  ++entry.status.num_received;
  entry.last = now;
}

void ProcessStatus::RecordLost(const std::string& channel, int64_t count) {
  const std::lock_guard lock(mutex_);
  Find(channel).status.num_lost += count;
}

void ProcessStatus::RecordOverwritten(const std::string& channel) {
  const std::lock_guard lock(mutex_);
  ++Find(channel).status.num_overwritten;
}

bool ProcessStatus::RecordDecodeError(const std::string& channel, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  Channel& entry = Find(channel);
  ++entry.status.num_decode_errors;
  if (entry.reported && now - entry.last_report < kReportInterval) return false;
  entry.reported = true;
  entry.last_report = now;
  return true;
}

void ProcessStatus::RecordStage(const std::string& stage, double seconds) {
  const std::lock_guard lock(mutex_);
  Stage& entry = stages_[stage];
  entry.latest[static_cast<size_t>(entry.num_runs) % kWindow] = seconds;
  entry.longest = entry.num_runs == 0 ? seconds : std::max(entry.longest, seconds);
  ++entry.num_runs;
}

void ProcessStatus::SetState(const std::string& state) {
  const std::lock_guard lock(mutex_);
  state_ = state;
}

void ProcessStatus::Fill(Clock::time_point now, process_status_t* message) {
  const std::lock_guard lock(mutex_);
  const bool closes_window = now - window_start_ >= kShortestWindow;
  message->state = state_;
  message->channels.clear();
  for (auto& [name, entry] : channels_) {
    channel_status_t& status = entry.status;
    if (closes_window) {
      status.rate = static_cast<double>(status.num_received - entry.received_at_window) /
                    Seconds(now - window_start_);
      entry.received_at_window = status.num_received;
    }
    status.age = status.num_received == 0 ? -1.0 : std::max(0.0, Seconds(now - entry.last));
    message->channels.push_back(status);
  }
  if (closes_window) window_start_ = now;
  message->num_channels = static_cast<int32_t>(message->channels.size());
  message->stages.clear();
  for (const auto& [name, stage] : stages_) message->stages.push_back(Summarize(name, stage));
  message->num_stages = static_cast<int32_t>(message->stages.size());
}

ProcessStatus::Channel& ProcessStatus::Find(const std::string& channel) {
  const bool is_full = channels_.size() >= kMaxChannels && !channels_.contains(channel);
  const std::string& key = is_full ? "(others)" : channel;
  const auto [entry, is_new] = channels_.try_emplace(key);
  if (is_new) entry->second.status.channel = key;
  return entry->second;
}

stage_status_t ProcessStatus::Summarize(const std::string& name, const Stage& stage) {
  const auto count = std::min(static_cast<size_t>(stage.num_runs), kWindow);
  std::vector<double> sorted(stage.latest.begin(),
                             stage.latest.begin() + static_cast<std::ptrdiff_t>(count));
  std::ranges::sort(sorted);
  // The nearest rank: the smallest value that the given share of all does not exceed.
  const auto percentile = [&](size_t percent) {
    return sorted[std::max<size_t>((count * percent + 99) / 100, 1) - 1];
  };
  stage_status_t status{};
  status.stage = name;
  status.num_runs = stage.num_runs;
  status.latency_p50 = percentile(50);
  status.latency_p99 = percentile(99);
  status.latency_max = stage.longest;
  return status;
}

}  // namespace vantage
