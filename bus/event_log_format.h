#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "bus/wire.h"

namespace vantage {

/// The header of an event in an LCM event log, all numbers big-endian: sync (4 bytes), event number
/// (8), utime (8), length of the channel (4), length of the data (4). Channel and data follow.
struct EventHeader {
  static constexpr uint32_t kSync = 0xEDA1DA01U;
  static constexpr size_t kBytes = 28;

  int64_t number = 0;
  int64_t utime = 0;
  int32_t channel_bytes = 0;
  int32_t data_bytes = 0;

  /// Bytes of the event with its header.
  [[nodiscard]] int64_t EventBytes() const {
    return static_cast<int64_t>(kBytes) + channel_bytes + data_bytes;
  }

  /// `bytes` has at least kBytes. Nothing when the sync is not there.
  static std::optional<EventHeader> Load(std::span<const std::byte> bytes) {
    if (LoadBigEndian<uint32_t>(bytes) != kSync) return {};
    return EventHeader{.number = LoadBigEndian<int64_t>(bytes.subspan(4)),
                       .utime = LoadBigEndian<int64_t>(bytes.subspan(12)),
                       .channel_bytes = LoadBigEndian<int32_t>(bytes.subspan(20)),
                       .data_bytes = LoadBigEndian<int32_t>(bytes.subspan(24))};
  }

  /// `bytes` has room for kBytes.
  void Store(std::span<std::byte> bytes) const {
    StoreBigEndian(kSync, bytes);
    StoreBigEndian(number, bytes.subspan(4));
    StoreBigEndian(utime, bytes.subspan(12));
    StoreBigEndian(channel_bytes, bytes.subspan(20));
    StoreBigEndian(data_bytes, bytes.subspan(24));
  }
};

}  // namespace vantage
