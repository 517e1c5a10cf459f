#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bus/message_schema.h"
#include "common/result.h"

namespace vantage {

/// One number of a message, or an array of them, as they lie on the wire.
class FieldNumbers {
 public:
  FieldNumbers() = default;
  FieldNumbers(FieldKind kind, std::span<const std::byte> bytes) : kind_(kind), bytes_(bytes) {}

  [[nodiscard]] FieldKind kind() const { return kind_; }
  [[nodiscard]] bool is_real() const {
    return kind_ == FieldKind::kFloat || kind_ == FieldKind::kDouble;
  }
  /// Big-endian, of all elements. Of kByte it is the bulk itself, e.g. a compressed image.
  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }
  [[nodiscard]] size_t size() const { return bytes_.size() / static_cast<size_t>(WireSize(kind_)); }
  /// Of an integer kind; `i` < size().
  [[nodiscard]] int64_t Integer(size_t i) const;
  /// Of any kind; integers beyond 2^53 are rounded.
  [[nodiscard]] double Real(size_t i) const;
  /// Decimal, so short as reads back to the same value; "nan", "inf", "-inf"; "true" or "false".
  [[nodiscard]] std::string Text(size_t i) const;

 private:
  FieldKind kind_ = FieldKind::kByte;
  std::span<const std::byte> bytes_;
};

/// Reads an encoded message of any of our types field by field, in the order of the type:
///
///   Result<MessageFields> fields = MessageFields::Open(bytes);
///   if (!fields) return fields.error();
///   while (fields->Next() != MessageFields::Event::kEnd) {
///     if (fields->event() == MessageFields::Event::kNumbers) ... fields->numbers() ...
///   }
///
/// All bytes are checked by Open, so reading cannot fail. It allocates as deep as types nest.
class MessageFields {
 public:
  enum class Event : uint8_t {
    kBeginStruct,  ///< a member that is of another type, or an element of an array of these
    kEndStruct,
    kBeginArray,  ///< an array of strings or of another type, perhaps empty; see array_size()
    kEndArray,
    kNumbers,  ///< one number, or all elements of an array of numbers at once; see numbers()
    kText,     ///< a string, or an element of an array of these; see text()
    kEnd,      ///< the message's end
  };

  /// `bytes` outlive it. Errors: the fingerprint is of no type of ours, or CheckMessageBytes.
  static Result<MessageFields> Open(std::span<const std::byte> bytes);

  /// Goes on. After kEnd it stays there.
  Event Next();

  /// The message's type.
  [[nodiscard]] const MessageSchema& schema() const { return *schema_; }
  /// What Next() returned last.
  [[nodiscard]] Event event() const { return event_; }
  /// The member that the event belongs to; of an element, that of its array. Not at kEnd.
  [[nodiscard]] const SchemaField& field() const { return *field_; }
  /// Whether the event is about an element of an array of strings or of another type.
  [[nodiscard]] bool is_element() const { return is_element_; }
  /// Where the event is, e.g. "objects[2].peaks[0].quat"; "" at kEnd.
  [[nodiscard]] std::string Path() const;

  /// At kBeginArray.
  [[nodiscard]] int64_t array_size() const { return array_size_; }
  /// At kNumbers; field().is_array tells an array of one from a number.
  [[nodiscard]] const FieldNumbers& numbers() const { return numbers_; }
  /// At kText, without the closing NUL. Any bytes, not only UTF-8.
  [[nodiscard]] std::string_view text() const { return text_; }

 private:
  // A struct that is being read, and its array of strings or structs that is being read.
  struct Level {
    const MessageSchema* schema = nullptr;
    size_t next_field = 0;
    const SchemaField* array = nullptr;
    int64_t next_element = 0;
    int64_t num_elements = 0;
    std::array<int64_t, MessageSchema::kMaxCounts> counts{};
  };

  MessageFields(const MessageSchema& schema, std::span<const std::byte> bytes);
  Event Advance();
  Event Element(const SchemaField& field);
  Event Numbers(const SchemaField& field, int64_t count);

  const MessageSchema* schema_;
  std::span<const std::byte> rest_;
  std::vector<Level> levels_;
  Event event_ = Event::kBeginStruct;
  const SchemaField* field_ = nullptr;
  bool is_element_ = false;
  int64_t array_size_ = 0;
  FieldNumbers numbers_;
  std::string_view text_;
};

}  // namespace vantage
