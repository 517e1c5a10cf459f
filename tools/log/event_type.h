#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>

namespace vantage {

inline constexpr const char* kLogHeaderChannel = "LOG_HEADER";

/// The first eight bytes of an encoded message; nothing when it has fewer.
std::optional<int64_t> Fingerprint(std::span<const std::byte> data);

/// Names of message types by their fingerprints: of ours, and of those that a log's LOG_HEADER
/// lists.
class EventTypes {
 public:
  /// Learns from the table of a log's header.
  void Add(int64_t fingerprint, const std::string& name);
  /// "images_t"; "images_v9_t (unknown here)"; sixteen hexadecimal digits; "(too short)".
  [[nodiscard]] std::string Name(std::span<const std::byte> data) const;

  static constexpr size_t kMaxNames = 1000;  ///< learned

 private:
  std::map<int64_t, std::string> learned_;
};

}  // namespace vantage
