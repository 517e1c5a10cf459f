#include "bus/message_check.h"

#include <array>

#include "bus/message_schema.h"
#include "bus/wire.h"
#include "common/format.h"

namespace vantage {
namespace {

constexpr int kMaxDepth = 16;  // Types nested deeper than this are refused.

// The bytes from `position` on; fails once and then stays failed.
class Walker {
 public:
  Walker(const MessageSchema& type, std::span<const std::byte> bytes)
      : type_(type), bytes_(bytes) {}

  Result<void> Check() {
    if (bytes_.size() < 8) {
      return Error{ErrorCode::kCorrupt,
                   Format("%s: %zu bytes, expected at least the 8 of the fingerprint",
                          std::string(type_.name).c_str(),
                          bytes_.size())};
    }
    const int64_t fingerprint = LoadBigEndian<int64_t>(bytes_);
    if (fingerprint != type_.fingerprint()) {
      return Error{ErrorCode::kCorrupt,
                   Format("%s: fingerprint %016llx, expected %016llx",
                          std::string(type_.name).c_str(),
                          static_cast<unsigned long long>(fingerprint),
                          static_cast<unsigned long long>(type_.fingerprint()))};
    }
    position_ = 8;
    if (!Struct(type_, 0)) return error_;
    if (Remaining() != 0) {
      return Error{ErrorCode::kCorrupt,
                   Format("%s: %lld bytes left over after %zu",
                          std::string(type_.name).c_str(),
                          static_cast<long long>(Remaining()),
                          position_)};
    }
    return {};
  }

 private:
  [[nodiscard]] int64_t Remaining() const {
    return static_cast<int64_t>(bytes_.size()) - static_cast<int64_t>(position_);
  }

  bool Fail(const SchemaField& field, int64_t value, const char* expected) {
    error_ = {ErrorCode::kCorrupt,
              Format("%s: %s of %lld at byte %zu, expected %s (%lld bytes remain)",
                     std::string(type_.name).c_str(),
                     std::string(field.name).c_str(),
                     static_cast<long long>(value),
                     position_,
                     expected,
                     static_cast<long long>(Remaining()))};
    return false;
  }

  bool Struct(const MessageSchema& schema, int depth) {
    std::array<int64_t, MessageSchema::kMaxCounts> counts{};
    for (const SchemaField& field : schema.fields) {
      if (depth > kMaxDepth) return Fail(field, depth, "a nesting of 16 at most");
      if (!Field(field, depth, counts)) return false;
    }
    return true;
  }

  bool Field(const SchemaField& field,
             int depth,
             std::array<int64_t, MessageSchema::kMaxCounts>& counts) {
    const int64_t count = field.count_from < 0 ? 1 : counts[static_cast<size_t>(field.count_from)];
    if (count < 0) return Fail(field, count, "a count of 0 or more");
    const int64_t min_size = field.fixed_count * MinSize(field);
    if (count > Remaining() / min_size) return Fail(field, count, "a count that fits");
    if (field.count_into >= 0) {
      counts[static_cast<size_t>(field.count_into)] = LoadInteger(field.kind);
    }
    const int64_t num_elements = count * field.fixed_count;
    if (field.kind != FieldKind::kString && field.kind != FieldKind::kNested) {
      position_ += static_cast<size_t>(num_elements * MinSize(field));
      return true;
    }
    for (int64_t i = 0; i < num_elements; ++i) {
      const bool sound =
          field.kind == FieldKind::kString ? String(field) : Struct(*field.nested, depth + 1);
      if (!sound) return false;
    }
    return true;
  }

  bool String(const SchemaField& field) {
    if (Remaining() < 5) return Fail(field, Remaining(), "a string");
    const int64_t length = LoadBigEndian<int32_t>(bytes_.subspan(position_));
    if (length < 1 || length > Remaining() - 4) {
      return Fail(field, length, "a string length that fits");
    }
    const size_t end = position_ + 4 + static_cast<size_t>(length);
    if (bytes_[end - 1] != std::byte{0}) return Fail(field, length, "a string that ends in NUL");
    position_ = end;
    return true;
  }

  // Bytes of one element at least; never 0.
  static int64_t MinSize(const SchemaField& field) {
    return field.kind == FieldKind::kNested ? field.nested->min_size : WireSize(field.kind);
  }

  // Called after the size was checked.
  [[nodiscard]] int64_t LoadInteger(FieldKind kind) const {
    const std::span<const std::byte> here = bytes_.subspan(position_);
    switch (kind) {
      case FieldKind::kInt16:
        return LoadBigEndian<int16_t>(here);
      case FieldKind::kInt32:
        return LoadBigEndian<int32_t>(here);
      case FieldKind::kInt64:
        return LoadBigEndian<int64_t>(here);
      default:
        return LoadBigEndian<int8_t>(here);
    }
  }

  const MessageSchema& type_;
  std::span<const std::byte> bytes_;
  size_t position_ = 0;
  Error error_;
};

}  // namespace

Result<void> CheckMessageBytes(const std::string& type_name, std::span<const std::byte> bytes) {
  const MessageSchema* schema = FindSchema(type_name);
  if (schema == nullptr) {
    return Error{
        ErrorCode::kNotFound,
        Format("message type '%s' is unknown, expected one of lcmtypes/", type_name.c_str())};
  }
  // LCM counts a message's bytes in an int.
  constexpr size_t kMaxMessage = 1U << 30U;
  if (bytes.size() > kMaxMessage) {
    return Error{ErrorCode::kCorrupt,
                 Format("%s: %zu bytes, expected 1 GiB at most", type_name.c_str(), bytes.size())};
  }
  return Walker(*schema, bytes).Check();
}

}  // namespace vantage
