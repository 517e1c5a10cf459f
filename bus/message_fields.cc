#include "bus/message_fields.h"

#include <bit>
#include <charconv>

#include "bus/message_check.h"
#include "bus/wire.h"
#include "common/check.h"
#include "common/format.h"

namespace vantage {
namespace {

template <class Number>
std::string Shortest(Number number) {
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.begin(), text.end(), number);
  VANTAGE_CHECK(error == std::errc(), "a number of up to 32 characters");
  return {text.begin(), end};
}

}  // namespace

int64_t FieldNumbers::Integer(size_t i) const {
  const auto width = static_cast<size_t>(WireSize(kind_));
  const std::span<const std::byte> at = bytes_.subspan(i * width, width);
  switch (kind_) {
    case FieldKind::kInt8:
      return LoadBigEndian<int8_t>(at);
    case FieldKind::kInt16:
      return LoadBigEndian<int16_t>(at);
    case FieldKind::kInt32:
      return LoadBigEndian<int32_t>(at);
    case FieldKind::kInt64:
      return LoadBigEndian<int64_t>(at);
    default:
      VANTAGE_CHECK(width == 1, "an integer's kind");
      return LoadBigEndian<uint8_t>(at);
  }
}

double FieldNumbers::Real(size_t i) const {
  const auto width = static_cast<size_t>(WireSize(kind_));
  const std::span<const std::byte> at = bytes_.subspan(i * width, width);
  if (kind_ == FieldKind::kFloat) {
    return static_cast<double>(std::bit_cast<float>(LoadBigEndian<uint32_t>(at)));
  }
  if (kind_ == FieldKind::kDouble) return std::bit_cast<double>(LoadBigEndian<uint64_t>(at));
  return static_cast<double>(Integer(i));
}

std::string FieldNumbers::Text(size_t i) const {
  if (kind_ == FieldKind::kFloat) return Shortest(static_cast<float>(Real(i)));
  if (kind_ == FieldKind::kDouble) return Shortest(Real(i));
  if (kind_ == FieldKind::kBool) return Integer(i) != 0 ? "true" : "false";
  return Shortest(Integer(i));
}

Result<MessageFields> MessageFields::Open(std::span<const std::byte> bytes) {
  if (bytes.size() < 8) {
    return Error{
        ErrorCode::kCorrupt,
        Format("a message of %zu bytes, expected at least the 8 of the fingerprint", bytes.size())};
  }
  const auto fingerprint = LoadBigEndian<int64_t>(bytes);
  const MessageSchema* schema = FindSchema(fingerprint);
  if (schema == nullptr) {
    return Error{ErrorCode::kNotFound,
                 Format("fingerprint %016llx, expected that of a type of lcmtypes/",
                        static_cast<unsigned long long>(fingerprint))};
  }
  if (Result<void> sound = CheckMessageBytes(std::string(schema->name), bytes); !sound) {
    return sound.error();
  }
  return MessageFields(*schema, bytes.subspan(8));
}

MessageFields::MessageFields(const MessageSchema& schema, std::span<const std::byte> bytes)
    : schema_(&schema), rest_(bytes) {
  levels_.push_back({.schema = &schema});
}

MessageFields::Event MessageFields::Next() { return event_ = Advance(); }

MessageFields::Event MessageFields::Advance() {
  if (levels_.empty()) return Event::kEnd;
  Level& level = levels_.back();
  if (level.array != nullptr) {
    field_ = level.array;
    is_element_ = level.next_element < level.num_elements;
    if (is_element_) {
      ++level.next_element;
      return Element(*level.array);
    }
    level.array = nullptr;
    return Event::kEndArray;
  }
  if (level.next_field == level.schema->fields.size()) {
    levels_.pop_back();
    if (levels_.empty()) return Event::kEnd;
    const Level& outer = levels_.back();
    is_element_ = outer.array != nullptr;
    field_ = is_element_ ? outer.array : &outer.schema->fields[outer.next_field - 1];
    return Event::kEndStruct;
  }
  field_ = &level.schema->fields[level.next_field++];
  is_element_ = false;
  const int64_t times =
      field_->count_from < 0 ? 1 : level.counts[static_cast<size_t>(field_->count_from)];
  const int64_t count = times * field_->fixed_count;
  if (field_->kind != FieldKind::kString && field_->kind != FieldKind::kNested) {
    return Numbers(*field_, count);
  }
  if (!field_->is_array) return Element(*field_);
  level.array = field_;
  level.next_element = 0;
  level.num_elements = array_size_ = count;
  return Event::kBeginArray;
}

MessageFields::Event MessageFields::Numbers(const SchemaField& field, int64_t count) {
  const auto size = static_cast<size_t>(count * WireSize(field.kind));
  numbers_ = FieldNumbers(field.kind, rest_.first(size));
  rest_ = rest_.subspan(size);
  if (field.count_into >= 0) {
    levels_.back().counts[static_cast<size_t>(field.count_into)] = numbers_.Integer(0);
  }
  return Event::kNumbers;
}

MessageFields::Event MessageFields::Element(const SchemaField& field) {
  if (field.kind == FieldKind::kNested) {
    levels_.push_back({.schema = field.nested});
    return Event::kBeginStruct;
  }
  const auto length = static_cast<size_t>(LoadBigEndian<int32_t>(rest_));
  const std::span<const std::byte> bytes = rest_.subspan(4, length - 1);
  text_ = {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  rest_ = rest_.subspan(4 + length);
  return Event::kText;
}

std::string MessageFields::Path() const {
  std::string path;
  for (const Level& level : levels_) {
    // A struct that just began is a level of its own, of which no member was read yet.
    if (level.next_field == 0) break;
    if (!path.empty()) path += '.';
    path += level.schema->fields[level.next_field - 1].name;
    if (level.array != nullptr && level.next_element > 0) {
      path += '[';
      path += std::to_string(level.next_element - 1);
      path += ']';
    }
  }
  return path;
}

}  // namespace vantage
