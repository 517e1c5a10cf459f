#include "tests/bus/support/random_message.h"

#include <array>

#include "bus/wire.h"

namespace vantage {
namespace {

class Writer {
 public:
  Writer(int max_count, Rng& rng) : max_count_(max_count), rng_(rng) {}

  template <class T>
  void Integer(T value) {
    bytes_.resize(bytes_.size() + sizeof(T));
    StoreBigEndian(value, std::span(bytes_).last(sizeof(T)));
  }

  void Struct(const MessageSchema& schema) {
    std::array<int64_t, MessageSchema::kMaxCounts> counts{};
    for (const SchemaField& field : schema.fields) {
      if (field.count_into >= 0) {
        const int64_t count = rng_.Below(static_cast<uint32_t>(max_count_) + 1);
        counts[static_cast<size_t>(field.count_into)] = count;
        Count(field.kind, count);
        continue;
      }
      const int64_t count =
          field.count_from < 0 ? 1 : counts[static_cast<size_t>(field.count_from)];
      for (int64_t i = 0; i < count * field.fixed_count; ++i) Element(field);
    }
  }

  std::vector<std::byte> Take() { return std::move(bytes_); }

 private:
  void Count(FieldKind kind, int64_t count) {
    if (kind == FieldKind::kInt8) Integer(static_cast<int8_t>(count));
    if (kind == FieldKind::kInt16) Integer(static_cast<int16_t>(count));
    if (kind == FieldKind::kInt32) Integer(static_cast<int32_t>(count));
    if (kind == FieldKind::kInt64) Integer(count);
  }

  void Element(const SchemaField& field) {
    switch (field.kind) {
      case FieldKind::kByte:
      case FieldKind::kInt8:
        return Integer(static_cast<uint8_t>(rng_.NextUint32()));
      case FieldKind::kBool:
        return Integer(static_cast<uint8_t>(rng_.Below(2)));
      case FieldKind::kInt16:
        return Integer(static_cast<uint16_t>(rng_.NextUint32()));
      case FieldKind::kInt32:
        return Integer(rng_.NextUint32());
      case FieldKind::kInt64:
        return Integer(uint64_t{rng_.NextUint32()} << 32U | rng_.NextUint32());
      case FieldKind::kFloat:
        // Never a signaling NaN, which a copy as float may change.
        return Integer(rng_.NextUint32() & 0xbfffffffU);
      case FieldKind::kDouble:
        return Integer((uint64_t{rng_.NextUint32()} << 32U | rng_.NextUint32()) &
                       0xbfffffffffffffffU);
      case FieldKind::kString: {
        const uint32_t length = rng_.Below(9);
        Integer(static_cast<int32_t>(length + 1));
        for (uint32_t i = 0; i < length; ++i) Integer(static_cast<uint8_t>('a' + rng_.Below(26)));
        return Integer(uint8_t{0});
      }
      case FieldKind::kNested:
        return Struct(*field.nested);
    }
  }

  int max_count_;
  Rng& rng_;
  std::vector<std::byte> bytes_;
};

}  // namespace

std::vector<std::byte> RandomMessage(const MessageSchema& schema, int max_count, Rng& rng) {
  Writer writer(max_count, rng);
  writer.Integer(schema.fingerprint());
  writer.Struct(schema);
  return writer.Take();
}

}  // namespace vantage
