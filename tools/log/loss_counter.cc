#include "tools/log/loss_counter.h"

#include <optional>

#include "common/format.h"
#include "tools/support/message_seq.h"

namespace vantage {

int64_t LossCounter::Add(const std::string& channel,
                         std::span<const std::byte> bytes,
                         int64_t num_skipped) {
  int64_t lost = num_skipped;
  if (num_skipped > 0) Of(channel).overrun += num_skipped;
  if (const std::optional<MessageSeq> seq = FindMessageSeq(channel, bytes)) {
    const int64_t gap = sequence_.Add(seq->sender, seq->seq, num_skipped);
    if (gap > 0) Of(channel).by_seq += gap;
    lost += gap;
  }
  total_ += lost;
  return lost;
}

void LossCounter::AddUnfit(const std::string& channel) {
  ++Of(channel).unfit;
  ++total_;
}

std::string LossCounter::Describe() const {
  if (total_ == 0) return "ok";
  std::string text;
  for (const auto& [channel, loss] : losses_) {
    text += Format("%s%jd of %s",
                   text.empty() ? "" : ", ",
                   intmax_t{loss.by_seq + loss.overrun + loss.unfit},
                   channel.c_str());
  }
  const auto sum = [this](int64_t Loss::*kind) {
    int64_t count = 0;
    for (const auto& each : losses_) count += each.second.*kind;
    return intmax_t{count};
  };
  return Format(
             "%jd messages lost (%jd never arrived, %jd came faster than the disk took them, "
             "%jd too long): ",
             intmax_t{total_},
             sum(&Loss::by_seq),
             sum(&Loss::overrun),
             sum(&Loss::unfit)) +
         text;
}

LossCounter::Loss& LossCounter::Of(const std::string& channel) {
  if (losses_.size() >= kMaxChannels && !losses_.contains(channel)) return losses_["(others)"];
  return losses_[channel];
}

}  // namespace vantage
