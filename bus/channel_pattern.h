#pragma once

#include <optional>
#include <regex>
#include <string>

#include "common/result.h"

namespace vantage {

inline constexpr size_t kMaxChannelName = 63;  ///< characters, LCM's limit

/// A channel's name, or a regular expression that must match the whole name.
class ChannelPattern {
 public:
  /// Errors: it is empty, or no regular expression.
  static Result<ChannelPattern> Create(const std::string& pattern);

  [[nodiscard]] bool Matches(const std::string& channel) const;
  /// It stands for exactly one channel.
  [[nodiscard]] bool IsName() const { return !regex_.has_value(); }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  explicit ChannelPattern(std::string text) : text_(std::move(text)) {}

  std::string text_;
  std::optional<std::regex> regex_;  // Absent: a name.
};

}  // namespace vantage
