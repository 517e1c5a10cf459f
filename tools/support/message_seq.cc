#include "tools/support/message_seq.h"

#include <algorithm>

#include "bus/image_conversion.h"
#include "bus/message_check.h"
#include "bus/message_schema.h"
#include "bus/wire.h"
#include "vantage/images_t.hpp"

namespace vantage {
namespace {

constexpr size_t kFingerprintBytes = 8;

std::optional<int64_t> SeqOfImages(std::span<const std::byte> bytes) {
  const Result<images_t> images = DecodeChecked<images_t>(bytes);
  if (!images || images->images.empty()) return std::nullopt;
  const int64_t seq = ImageSeq(images->images.front());
  if (seq < 0) return std::nullopt;
  return seq;
}

}  // namespace

std::optional<MessageSeq> FindMessageSeq(const std::string& channel,
                                         std::span<const std::byte> bytes) {
  if (bytes.size() < kFingerprintBytes) return std::nullopt;
  const MessageSchema* schema = FindSchema(LoadBigEndian<int64_t>(bytes));
  if (schema == nullptr) return std::nullopt;
  if (schema->name == images_t::getTypeName()) {
    const std::optional<int64_t> seq = SeqOfImages(bytes);
    if (!seq) return std::nullopt;
    return MessageSeq{.sender = channel, .seq = *seq};
  }
  // Where a type counts itself, utime and seq come first, and after them the sender's name.
  const auto& fields = schema->fields;
  if (fields.size() < 2 || fields[0].name != "utime" || fields[1].name != "seq") {
    return std::nullopt;
  }
  if (!CheckMessageBytes(std::string(schema->name), bytes)) return std::nullopt;
  const std::span<const std::byte> rest = bytes.subspan(kFingerprintBytes + sizeof(int64_t));
  MessageSeq found{.sender = channel, .seq = LoadBigEndian<int64_t>(rest)};
  if (fields.size() > 2 && fields[2].name == "name" && fields[2].kind == FieldKind::kString) {
    const std::span<const std::byte> name = rest.subspan(sizeof(int64_t));
    const auto size = static_cast<size_t>(LoadBigEndian<int32_t>(name));
    found.sender += '/';
    found.sender.append(reinterpret_cast<const char*>(name.data()) + sizeof(int32_t), size - 1);
  }
  return found;
}

}  // namespace vantage
