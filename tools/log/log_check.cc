#include "tools/log/log_check.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "bus/conversions.h"
#include "bus/image_conversion.h"
#include "bus/message_check.h"
#include "bus/message_schema.h"
#include "common/format.h"
#include "common/time_range.h"
#include "tools/log/event_type.h"
#include "tools/log/shown_text.h"
#include "tools/support/message_seq.h"

namespace vantage {
namespace {

constexpr size_t kMaxTypes = 16;  // of a channel

bool HasDepth(const images_t& message) {
  return std::ranges::any_of(message.image_types, [](int16_t type) {
    return type == images_t::DEPTH_MM || type == images_t::DEPTH_MM_ZIPPED ||
           type == images_t::DEPTH_MM_VDC;
  });
}

// What a node would say of the data; nothing when it would take them.
std::optional<std::string> Refusal(const MessageSchema& schema, std::span<const std::byte> data) {
  if (schema.name == images_t::getTypeName()) {
    const Result<images_t> message = DecodeChecked<images_t>(data);
    if (!message) return message.error().message;
    if (!HasDepth(*message)) return {};
    const Result<DepthFrame> frame = DepthFrameFromMessage(*message);
    return frame ? std::nullopt : std::optional(frame.error().message);
  }
  if (schema.name == rigid_transform_t::getTypeName()) {
    const Result<rigid_transform_t> message = DecodeChecked<rigid_transform_t>(data);
    if (!message) return message.error().message;
    const Result<Pose> pose = PoseFromMessage(*message);
    return pose ? std::nullopt : std::optional(pose.error().message);
  }
  const Result<void> sound = CheckMessageBytes(std::string(schema.name), data);
  return sound ? std::nullopt : std::optional(sound.error().message);
}

bool IsOneBitOff(int64_t a, int64_t b) { return std::popcount(static_cast<uint64_t>(a ^ b)) == 1; }

bool IsOneBitOff(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  int bits = 0;
  for (size_t i = 0; i < a.size() && bits < 2; ++i) {
    bits += std::popcount(static_cast<unsigned>(static_cast<unsigned char>(a[i] ^ b[i])));
  }
  return bits == 1;
}

// One that was met once where the other is usual.
bool IsRareBeside(int64_t rare, int64_t usual) { return rare == 1 && usual >= 3; }

}  // namespace

void LogCheck::Add(const LogEventView& event) {
  const EventPlace place{.offset = event.offset,
                         .number = event.number,
                         .utime = event.utime,
                         .channel = std::string(event.channel)};
  ++num_events_;
  DoubtNumber(numbers_.Add(event.number, place));
  DoubtTime(times_.Add(event.utime, place));
  if (!IsPlausibleUtime(event.utime)) AddDoubt(place, "its utime is outside of 1970 to 2200");
  if (Printable(place.channel) != place.channel) {
    AddDoubt(place, "its channel holds bytes that are no printable ASCII");
  }
  CountTypes(place, event.data);
  CheckData(place, event.data);
}

void LogCheck::Finish() {
  DoubtNumber(numbers_.Finish());
  DoubtTime(times_.Finish());
  for (const auto& [name, channel] : channels_) JudgeChannel(name, channel);
  std::ranges::stable_sort(doubts_, {}, [](const Doubt& doubt) { return doubt.place.offset; });
}

void LogCheck::DoubtNumber(const std::optional<OddValue>& odd) {
  if (!odd) return;
  EventPlace place = odd->place;
  place.number = odd->expected;
  AddDoubt(place, Format("its event number is %jd", intmax_t{odd->value}));
}

void LogCheck::DoubtTime(const std::optional<OddValue>& odd) {
  if (!odd) return;
  const double apart =
      1e-6 * (static_cast<double>(odd->value) - static_cast<double>(odd->expected));
  AddDoubt(odd->place,
           Format("its utime %jd is %.6f s %s the events beside it",
                  intmax_t{odd->value},
                  std::abs(apart),
                  apart < 0.0 ? "before" : "after"));
}

void LogCheck::CheckData(const EventPlace& place, std::span<const std::byte> data) {
  const std::optional<int64_t> fingerprint = Fingerprint(data);
  const MessageSchema* schema = fingerprint ? FindSchema(*fingerprint) : nullptr;
  if (schema == nullptr) return;
  if (const std::optional<std::string> refusal = Refusal(*schema, data)) {
    AddDoubt(place, "its data are damaged: " + Printable(*refusal));
    return;
  }
  const std::optional<MessageSeq> seq = FindMessageSeq(place.channel, data);
  if (!seq || (counts_.size() >= kMaxChannels && !counts_.contains(seq->sender))) return;
  const std::optional<OddValue> odd = counts_[seq->sender].Add(seq->seq, place);
  if (!odd || !IsOneBitOff(odd->value, odd->expected)) return;
  AddDoubt(odd->place,
           Format("its seq is %jd, expected %jd", intmax_t{odd->value}, intmax_t{odd->expected}));
}

void LogCheck::CountTypes(const EventPlace& place, std::span<const std::byte> data) {
  if (channels_.size() >= kMaxChannels && !channels_.contains(place.channel)) return;
  Channel& channel = channels_[place.channel];
  ++channel.count;
  const int64_t type = Fingerprint(data).value_or(0);
  if (channel.types.size() >= kMaxTypes && !channel.types.contains(type)) return;
  Seen& seen = channel.types[type];
  if (seen.count++ == 0) seen.first = place;
}

void LogCheck::JudgeChannel(const std::string& name, const Channel& channel) {
  for (const auto& [other_name, other] : channels_) {
    if (!IsRareBeside(channel.count, other.count) || !IsOneBitOff(name, other_name)) continue;
    AddDoubt(channel.types.begin()->second.first,
             Format("its channel is nearly %s, which has %jd events",
                    Printable(other_name).c_str(),
                    intmax_t{other.count}));
    return;
  }
  const auto usual = std::ranges::max_element(
      channel.types, {}, [](const auto& type) { return type.second.count; });
  for (const auto& [type, seen] : channel.types) {
    if (IsRareBeside(seen.count, usual->second.count)) {
      AddDoubt(seen.first,
               Format("its type %016jx is not that of the others on its channel, %016jx",
                      static_cast<uintmax_t>(type),
                      static_cast<uintmax_t>(usual->first)));
      continue;
    }
    for (const MessageSchema& schema : AllSchemas()) {
      if (!IsOneBitOff(type, schema.fingerprint())) continue;
      AddDoubt(seen.first,
               Format("its type %016jx is nearly %s",
                      static_cast<uintmax_t>(type),
                      std::string(schema.name).c_str()));
    }
  }
}

void LogCheck::AddDoubt(const EventPlace& place, std::string reason) {
  ++num_doubts_;
  if (doubts_.size() < kMaxDoubts) doubts_.push_back({.place = place, .reason = std::move(reason)});
}

}  // namespace vantage
