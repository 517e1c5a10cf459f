#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "bus/message_check.h"
#include "bus/message_schema.h"
#include "bus/wire.h"
#include "common/time_range.h"

namespace vantage {

/// Finds the numbers in an encoded message that are no counts.
class NumberFinder {
 public:
  struct Number {
    size_t offset;
    FieldKind kind;
  };

  /// `bytes` is sound. Of an array the first two elements and the last one.
  NumberFinder(const MessageSchema& schema, std::span<const std::byte> bytes) : bytes_(bytes) {
    Struct(schema, true);
  }
  [[nodiscard]] const std::vector<Number>& numbers() const { return numbers_; }

 private:
  void Struct(const MessageSchema& schema, bool wanted) {
    std::array<int64_t, MessageSchema::kMaxCounts> counts{};
    for (const SchemaField& field : schema.fields) {
      if (field.count_into >= 0) {
        counts[static_cast<size_t>(field.count_into)] = TakeCount(field.kind);
        continue;
      }
      const int64_t times =
          field.count_from < 0 ? 1 : counts[static_cast<size_t>(field.count_from)];
      const int64_t count = times * field.fixed_count;
      for (int64_t i = 0; i < count; ++i) Element(field, wanted && (i < 2 || i == count - 1));
    }
  }

  void Element(const SchemaField& field, bool wanted) {
    if (field.kind == FieldKind::kNested) return Struct(*field.nested, wanted);
    if (field.kind == FieldKind::kString) {
      at_ += 4 + static_cast<size_t>(LoadBigEndian<int32_t>(bytes_.subspan(at_)));
      return;
    }
    if (wanted) numbers_.push_back({at_, field.kind});
    at_ += static_cast<size_t>(WireSize(field.kind));
  }

  int64_t TakeCount(FieldKind kind) {
    const std::span<const std::byte> from = bytes_.subspan(at_);
    at_ += static_cast<size_t>(WireSize(kind));
    if (kind == FieldKind::kInt8) return LoadBigEndian<int8_t>(from);
    if (kind == FieldKind::kInt16) return LoadBigEndian<int16_t>(from);
    if (kind == FieldKind::kInt32) return LoadBigEndian<int32_t>(from);
    return LoadBigEndian<int64_t>(from);
  }

  std::span<const std::byte> bytes_;
  size_t at_ = 8;  // After the fingerprint.
  std::vector<Number> numbers_;
};

/// What 8 bytes of a message may be at worst: as integer, and as floating point number.
inline const std::vector<int64_t>& Hostile64() {
  using Double = std::numeric_limits<double>;
  using Int = std::numeric_limits<int64_t>;
  static const std::vector<int64_t> values = [] {
    std::vector<int64_t> all = {Int::min(), Int::max(), -1, 0, 1, kLatestUtime, kLatestUtime + 1};
    for (const double value : {Double::quiet_NaN(),
                               Double::infinity(),
                               -Double::infinity(),
                               1e308,
                               -1e308,
                               1e-200,
                               1e9,
                               1.0,
                               -1.0}) {
      all.push_back(std::bit_cast<int64_t>(value));
    }
    return all;
  }();
  return values;
}

/// All messages that differ from a sound one in one number, which has a hostile value.
template <class Message>
std::vector<Message> HostileVariants(const Message& sound) {
  std::vector<Message> variants;
  std::vector<std::byte> bytes = Encode(sound);
  const NumberFinder finder(*FindSchema(Message::getTypeName()), bytes);
  for (const auto& [offset, kind] : finder.numbers()) {
    const std::vector<std::byte> original = bytes;
    for (const int64_t value : Hostile64()) {
      const std::span<std::byte> place = std::span(bytes).subspan(offset);
      // Of smaller numbers the upper half, so that the ends stay the ends and a double's NaN
      // and infinity a float's.
      const int64_t size = WireSize(kind);
      if (size == 1) place[0] = static_cast<std::byte>(value >> 56);
      if (size == 2) StoreBigEndian(static_cast<int16_t>(value >> 48), place);
      if (size == 4) StoreBigEndian(static_cast<int32_t>(value >> 32), place);
      if (size == 8) StoreBigEndian(value, place);
      Result<Message> variant = DecodeChecked<Message>(bytes);
      if (variant) variants.push_back(std::move(variant).value());
    }
    std::ranges::copy(original, bytes.begin());
  }
  return variants;
}

}  // namespace vantage
