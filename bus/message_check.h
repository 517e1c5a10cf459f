#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"

namespace vantage {

/// Walks encoded bytes by the type's schema, without decoding or allocating: the fingerprint, every
/// count and string length against the bytes that are there, and no bytes left over. The decoders
/// that lcm-gen writes trust their input's counts, so no bytes reach them before this.
/// @param type_name name of a Vantage message type, e.g. "images_t".
Result<void> CheckMessageBytes(const std::string& type_name, std::span<const std::byte> bytes);

/// Decodes after CheckMessageBytes. Never throws.
template <class Message>
Result<Message> DecodeChecked(std::span<const std::byte> bytes) {
  if (Result<void> sound = CheckMessageBytes(Message::getTypeName(), bytes); !sound) {
    return sound.error();
  }
  try {
    Message message{};
    if (message.decode(bytes.data(), 0, static_cast<int>(bytes.size())) !=
        static_cast<int>(bytes.size())) {
      return Error{
          ErrorCode::kCorrupt,
          std::string(Message::getTypeName()) + ": decoded length differs from the message's"};
    }
    return message;
  } catch (const std::exception& exception) {
    return Error{ErrorCode::kCorrupt,
                 std::string(Message::getTypeName()) + ": " + exception.what()};
  }
}

/// Encodes. The caller has set every count to its vector's size.
template <class Message>
std::vector<std::byte> Encode(const Message& message) {
  const int size = message.getEncodedSize();
  std::vector<std::byte> bytes(static_cast<size_t>(size));
  message.encode(bytes.data(), 0, size);
  return bytes;
}

}  // namespace vantage
