#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace vantage {

/// What one element of a field is. All numbers are big-endian.
enum class FieldKind : uint8_t {
  kByte,    ///< 0 to 255
  kInt8,    ///< also on the wire 1 byte
  kBool,    ///< 1 byte, 0 or 1
  kInt16,   ///< 2 bytes
  kInt32,   ///< 4 bytes
  kInt64,   ///< 8 bytes
  kFloat,   ///< 4 bytes, IEEE 754
  kDouble,  ///< 8 bytes, IEEE 754
  kString,  ///< int32 length with the closing NUL, then so many bytes
  kNested,  ///< the fields of another type, without its fingerprint
};

/// Bytes of one element on the wire; of a string at least so many; 0 for kNested.
constexpr int64_t WireSize(FieldKind kind) {
  switch (kind) {
    case FieldKind::kByte:
    case FieldKind::kInt8:
    case FieldKind::kBool:
      return 1;
    case FieldKind::kInt16:
      return 2;
    case FieldKind::kInt32:
    case FieldKind::kFloat:
      return 4;
    case FieldKind::kInt64:
    case FieldKind::kDouble:
      return 8;
    case FieldKind::kString:
      return 5;
    case FieldKind::kNested:
      return 0;
  }
  return 0;
}

struct MessageSchema;

/// One member of a message type: `fixed_count` elements, times an earlier member where the array is
/// variable.
struct SchemaField {
  std::string_view name;
  FieldKind kind = FieldKind::kByte;
  const MessageSchema* nested = nullptr;  ///< the type, for kNested
  int64_t fixed_count = 1;                ///< product of the fixed dimensions, row-major
  int count_from = -1;                    ///< slot that multiplies fixed_count; -1: none
  int count_into = -1;  ///< slot that this integer fills for a later array; -1: none
  bool is_array = false;
};

/// How a message type lies on the wire. Made from lcmtypes/*.lcm when the project is built.
struct MessageSchema {
  static constexpr int kMaxCounts = 16;  ///< slots for members that are sizes of arrays

  std::string_view name;  ///< e.g. "images_t"
  std::span<const SchemaField> fields;
  int64_t min_size = 0;  ///< bytes, with empty strings and arrays, without the fingerprint
  int64_t (*fingerprint)() = nullptr;
};

/// Every message type, by name.
std::span<const MessageSchema> AllSchemas();

/// Null when there is no such type.
const MessageSchema* FindSchema(std::string_view type_name);
/// The type that a message's first eight bytes name; null when it is none of ours.
const MessageSchema* FindSchema(int64_t fingerprint);

}  // namespace vantage
