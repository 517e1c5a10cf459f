#include "tools/monitor/monitor_model.h"

#include <algorithm>
#include <cinttypes>
#include <utility>

#include "bus/message_check.h"
#include "bus/message_schema.h"
#include "bus/wire.h"
#include "common/format.h"
#include "tools/support/message_seq.h"

namespace vantage {
namespace {

constexpr size_t kLongestName = 200;                     // Characters.
constexpr int64_t kLatestUtime = 7'258'118'400'000'000;  // us: the year 2200.

void Shorten(std::string* text) {
  if (text->size() > kLongestName) text->resize(kLongestName);
}

void Shorten(process_status_t* status) {
  for (std::string* text :
       {&status->name, &status->host, &status->version, &status->config_hash, &status->state}) {
    Shorten(text);
  }
  if (status->channels.size() > MonitorModel::kMaxOfProcess) {
    status->channels.resize(MonitorModel::kMaxOfProcess);
  }
  if (status->stages.size() > MonitorModel::kMaxOfProcess) {
    status->stages.resize(MonitorModel::kMaxOfProcess);
  }
  status->num_channels = static_cast<int32_t>(status->channels.size());
  status->num_stages = static_cast<int32_t>(status->stages.size());
  for (channel_status_t& each : status->channels) Shorten(&each.channel);
  for (stage_status_t& each : status->stages) Shorten(&each.stage);
}

/// How far a counter went on; one that went back began anew. Both come from outside.
int64_t Growth(int64_t before, int64_t now) {
  if (before < 0 || now < before) before = 0;
  return std::max<int64_t>(now, 0) - before;
}

void AddTo(int64_t* sum, int64_t more) {
  constexpr int64_t kLargest = int64_t{1} << 61;
  *sum = std::min(*sum, kLargest) + std::min(more, kLargest);
}

const channel_status_t* FindChannel(const process_status_t& status, const std::string& channel) {
  const auto found = std::ranges::find(status.channels, channel, &channel_status_t::channel);
  return found == status.channels.end() ? nullptr : &*found;
}

void AddLosses(const process_status_t& before, const process_status_t& now, SeenProcess* process) {
  for (const channel_status_t& channel : now.channels) {
    const channel_status_t none{};
    const channel_status_t* last = FindChannel(before, channel.channel);
    if (last == nullptr) last = &none;
    if (process->losses.size() >= MonitorModel::kMaxOfProcess &&
        !process->losses.contains(channel.channel)) {
      continue;
    }
    ChannelLosses& losses = process->losses[channel.channel];
    AddTo(&losses.lost, Growth(last->num_lost, channel.num_lost));
    AddTo(&losses.overwritten, Growth(last->num_overwritten, channel.num_overwritten));
    AddTo(&losses.decode_errors, Growth(last->num_decode_errors, channel.num_decode_errors));
  }
}

}  // namespace

void MonitorModel::Add(const std::string& channel,
                       int64_t utime,
                       std::span<const std::byte> bytes) {
  // A damaged log may say any time: differences must not overflow.
  utime = std::clamp<int64_t>(utime, 0, kLatestUtime);
  if (first_utime_ == 0) first_utime_ = utime;
  last_utime_ = std::max(last_utime_, utime);
  SeenChannel* seen = Find(channel.substr(0, kLongestName), kMaxChannels, &channels_);
  if (seen == nullptr) return;
  const bool has_fingerprint = bytes.size() >= sizeof(int64_t);
  const int64_t fingerprint = has_fingerprint ? LoadBigEndian<int64_t>(bytes) : 0;
  const MessageSchema* schema = has_fingerprint ? FindSchema(fingerprint) : nullptr;
  const std::string type = !has_fingerprint ? "(too short)"
                           : schema != nullptr
                               ? std::string(schema->name)
                               : Format("%016" PRIx64, static_cast<uint64_t>(fingerprint));
  if (seen->num_messages == 0) seen->type = type;
  if (seen->type != type) seen->type = "(several)";
  ++seen->num_messages;
  seen->num_bytes += static_cast<int64_t>(bytes.size());
  seen->last_utime = utime;
  seen->arrivals.Add(utime, bytes.size());
  if (schema == nullptr) return;
  if (!CheckMessageBytes(type, bytes)) {
    ++seen->num_malformed;
    return;
  }
  if (const std::optional<MessageSeq> seq = FindMessageSeq(channel, bytes)) {
    seen->num_lost += sequence_.Add(seq->sender, seq->seq, 0);
  }
  Look(type, utime, bytes);
}

template <class Seen>
Seen* MonitorModel::Find(const std::string& name, size_t most, std::map<std::string, Seen>* all) {
  const auto found = all->find(name);
  if (found != all->end()) return &found->second;
  if (all->size() >= most) {
    ++num_not_kept_;
    return nullptr;
  }
  return &(*all)[name];
}

void MonitorModel::Look(const std::string& type, int64_t utime, std::span<const std::byte> bytes) {
  if (type == process_status_t::getTypeName()) {
    if (Result<process_status_t> status = DecodeChecked<process_status_t>(bytes)) {
      AddProcess(std::move(status).value(), utime);
    }
  } else if (type == camera_status_v2_t::getTypeName()) {
    if (Result<camera_status_v2_t> status = DecodeChecked<camera_status_v2_t>(bytes)) {
      AddCamera(std::move(status).value(), utime);
    }
  } else if (type == arm_status_t::getTypeName()) {
    if (Result<arm_status_t> status = DecodeChecked<arm_status_t>(bytes)) {
      Shorten(&status->name);
      Shorten(&status->reason);
      if (SeenArm* arm = Find(status->name, kMaxDevices, &arms_)) *arm = {*status, utime};
    }
  } else if (type == handeye_check_t::getTypeName()) {
    if (Result<handeye_check_t> check = DecodeChecked<handeye_check_t>(bytes)) {
      Shorten(&check->camera);
      Shorten(&check->source);
      Shorten(&check->reason);
      if (SeenHandEye* seen = Find(check->camera, kMaxDevices, &hand_eyes_))
        *seen = {*check, utime};
    }
  }
}

void MonitorModel::AddProcess(process_status_t status, int64_t utime) {
  Shorten(&status);
  const bool is_new = !processes_.contains(status.name);
  SeenProcess* process = Find(status.name, kMaxProcesses, &processes_);
  if (process == nullptr) return;
  // Of the counters of one that was there before the watch, only what is added counts.
  const bool began_before = is_new && status.start_utime < first_utime_;
  const bool is_other =
      !is_new && (status.start_utime != process->status.start_utime ||
                  status.pid != process->status.pid || status.host != process->status.host);
  if (is_other && status.start_utime < process->status.start_utime) ++process->num_conflicts;
  if (is_other && status.start_utime >= process->status.start_utime) ++process->num_restarts;
  const bool is_unclear = is_other && process->num_conflicts > 0;
  if (!is_new) {
    process->longest_silence = std::max(process->longest_silence, utime - process->last_utime);
    if (status.state != "ok" && (process->status.state == "ok" || !process->fault.empty())) {
      process->fault = status.state;
    }
  }
  const process_status_t before = began_before || is_unclear ? status
                                  : is_new || is_other       ? process_status_t{}
                                                             : process->status;
  AddLosses(before, status, process);
  process->status = std::move(status);
  process->last_utime = utime;
}

void MonitorModel::AddCamera(camera_status_v2_t status, int64_t utime) {
  Shorten(&status.name);
  Shorten(&status.serial);
  Shorten(&status.message);
  const bool is_new = !cameras_.contains(status.name);
  SeenCamera* camera = Find(status.name, kMaxDevices, &cameras_);
  if (camera == nullptr) return;
  if (!is_new) {
    const camera_status_v2_t& before = camera->status;
    AddTo(&camera->num_captured, Growth(before.num_captured, status.num_captured));
    AddTo(&camera->num_missed, Growth(before.num_missed, status.num_missed));
    if (before.state == camera_status_v2_t::STREAMING &&
        status.state != camera_status_v2_t::STREAMING) {
      ++camera->num_interruptions;
    }
  }
  camera->status = std::move(status);
  camera->last_utime = utime;
}

std::string MonitorModel::CommonConfigHash() const {
  std::map<std::string, int> votes;
  for (const auto& [name, process] : processes_) {
    if (!process.status.config_hash.empty() && !IsWatcher(name))
      ++votes[process.status.config_hash];
  }
  const auto most = std::ranges::max_element(
      votes, [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == votes.end() ? std::string() : most->first;
}

bool IsWatcher(const std::string& process_name) {
  for (const char* name : {"top", "progress", "doctor", "viewer", "recorder"}) {
    if (process_name == name) return true;
  }
  return false;
}

}  // namespace vantage
