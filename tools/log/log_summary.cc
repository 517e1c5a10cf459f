#include "tools/log/log_summary.h"

#include <algorithm>
#include <string_view>

#include "bus/message_check.h"
#include "common/format.h"
#include "common/time_range.h"
#include "tools/support/hash.h"
#include "tools/support/message_seq.h"
#include "vantage/log_header_t.hpp"

namespace vantage {

double ChannelSummary::RateHz() const {
  const double span = 1e-6 * (static_cast<double>(last_utime) - static_cast<double>(first_utime));
  return num_events > 1 && span > 0.0 ? static_cast<double>(num_events - 1) / span : 0.0;
}

void ChannelSummary::Count(int64_t utime, size_t data_bytes) {
  // Times that are none are for `vantage-log check`; here they would drown the others.
  if (IsPlausibleUtime(utime)) {
    const bool is_first = last_utime == 0;
    const int64_t gap = is_first ? 0 : utime - last_utime;
    if (gap > longest_gap) {
      longest_gap = gap;
      gap_utime = last_utime;
    }
    first_utime = is_first ? utime : std::min(first_utime, utime);
    last_utime = std::max(last_utime, utime);
  }
  const auto bytes = static_cast<int64_t>(data_bytes);
  ++num_events;
  num_bytes += bytes;
  largest_bytes = std::max(largest_bytes, bytes);
}

void LogSummary::Add(const LogEventView& event) {
  if (all_.num_events > 0 && event.utime < previous_utime_) ++num_out_of_order_;
  previous_utime_ = event.utime;
  all_.Count(event.utime, event.data.size());
  if (event.channel == kLogHeaderChannel && !origin_) ReadOrigin(event);
  auto entry = channels_.find(event.channel);
  if (entry == channels_.end()) {
    const bool is_full = channels_.size() >= kMaxChannels;
    entry = channels_.try_emplace(is_full ? "(others)" : std::string(event.channel)).first;
  }
  ChannelSummary& channel = entry->second;
  const std::string type = types_.Name(event.data);
  if (channel.num_events == 0) channel.type = type;
  if (channel.type != type) channel.type = "(several)";
  channel.Count(event.utime, event.data.size());
  CountSeq(event, &channel);
}

void LogSummary::CountSeq(const LogEventView& event, ChannelSummary* channel) {
  const std::optional<MessageSeq> found = FindMessageSeq(std::string(event.channel), event.data);
  if (!found) return;
  channel->has_seq = true;
  const int64_t lost = sequence_.Add(found->sender, found->seq, 0);
  channel->num_lost += lost;
  all_.num_lost += lost;
  if (last_seq_.size() >= SequenceTracker::kMaxSenders && !last_seq_.contains(found->sender)) {
    last_seq_.clear();
  }
  const auto [last, is_new] = last_seq_.try_emplace(found->sender, found->seq);
  if (!is_new && found->seq < last->second && restarts_.size() < kMaxRestarts) {
    restarts_.push_back({.sender = found->sender, .utime = event.utime});
  }
  last->second = found->seq;
}

void LogSummary::ReadOrigin(const LogEventView& event) {
  origin_.emplace();
  const std::optional<int64_t> fingerprint = Fingerprint(event.data);
  if (fingerprint != log_header_t::getHash()) {
    origin_->newer = types_.Name(event.data);
    return;
  }
  const Result<log_header_t> header = DecodeChecked<log_header_t>(event.data);
  if (!header) {
    origin_->newer = header.error().message;
    return;
  }
  origin_->version = header->version;
  origin_->seed = header->seed;
  if (!header->config_text.empty()) {
    origin_->config_hash = Format("%016jx", static_cast<uintmax_t>(Fnv1a(header->config_text)));
  }
  const size_t count = std::min(header->schema_names.size(), header->schema_fingerprints.size());
  for (size_t i = 0; i < count; ++i) {
    types_.Add(header->schema_fingerprints[i], header->schema_names[i]);
  }
}

}  // namespace vantage
