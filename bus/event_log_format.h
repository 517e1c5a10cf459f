#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "bus/channel_pattern.h"
#include "bus/wire.h"

namespace vantage {

/// The header of an event in an LCM event log, all numbers big-endian: sync (4 bytes), event number
/// (8), utime (8), length of the channel (4), length of the data (4). Channel and data follow.
struct EventHeader {
  static constexpr uint32_t kSync = 0xEDA1DA01U;
  static constexpr size_t kBytes = 28;
  static constexpr int32_t kMaxDataBytes = 64 << 20;  ///< longer data is taken as damage

  uint32_t sync = kSync;
  int64_t number = 0;
  int64_t utime = 0;
  int32_t channel_bytes = 0;
  int32_t data_bytes = 0;

  /// Bytes of the event with its header.
  [[nodiscard]] int64_t EventBytes() const {
    return static_cast<int64_t>(kBytes) + channel_bytes + data_bytes;
  }

  /// Lengths that LCM can send.
  [[nodiscard]] bool HasPlausibleLengths() const {
    return channel_bytes >= 1 && channel_bytes <= static_cast<int32_t>(kMaxChannelName) &&
           data_bytes >= 0 && data_bytes <= kMaxDataBytes;
  }
  [[nodiscard]] bool IsPlausible() const { return sync == kSync && HasPlausibleLengths(); }

  /// `bytes` has at least kBytes, of anything.
  static EventHeader Load(std::span<const std::byte> bytes) {
    return EventHeader{.sync = LoadBigEndian<uint32_t>(bytes),
                       .number = LoadBigEndian<int64_t>(bytes.subspan(4)),
                       .utime = LoadBigEndian<int64_t>(bytes.subspan(12)),
                       .channel_bytes = LoadBigEndian<int32_t>(bytes.subspan(20)),
                       .data_bytes = LoadBigEndian<int32_t>(bytes.subspan(24))};
  }

  /// `bytes` has room for kBytes.
  void Store(std::span<std::byte> bytes) const {
    StoreBigEndian(sync, bytes);
    StoreBigEndian(number, bytes.subspan(4));
    StoreBigEndian(utime, bytes.subspan(12));
    StoreBigEndian(channel_bytes, bytes.subspan(20));
    StoreBigEndian(data_bytes, bytes.subspan(24));
  }
};

}  // namespace vantage
