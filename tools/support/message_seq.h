#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace vantage {

/// Who counts a stream of messages, and how far the count is.
struct MessageSeq {
  std::string sender;  ///< the channel, and the sender's name where several share the channel
  int64_t seq = 0;
};

/// The count of an encoded message: its member seq, or that in the metadata of a camera's images.
/// Nothing when the message has none, is none of our types, or is malformed.
std::optional<MessageSeq> FindMessageSeq(const std::string& channel,
                                         std::span<const std::byte> bytes);

}  // namespace vantage
