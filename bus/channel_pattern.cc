#include "bus/channel_pattern.h"

#include <algorithm>

#include "common/format.h"

namespace vantage {

Result<ChannelPattern> ChannelPattern::Create(const std::string& pattern) {
  if (pattern.empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 "channel is empty, expected a name or a regular expression"};
  }
  ChannelPattern result(pattern);
  if (std::ranges::any_of(pattern, [](char c) {
        return std::string("\\^$.|?*+()[]{}").find(c) != std::string::npos;
      })) {
    try {
      result.regex_.emplace(pattern);
    } catch (const std::regex_error& error) {
      return Error{
          ErrorCode::kInvalidArgument,
          Format("channel '%s' is no regular expression (%s)", pattern.c_str(), error.what())};
    }
  }
  return result;
}

bool ChannelPattern::Matches(const std::string& channel) const {
  if (!regex_) return channel == text_;
  // The matcher recurses over its input, which on the wire is never longer than this.
  return channel.size() <= kMaxChannelName && std::regex_match(channel, *regex_);
}

}  // namespace vantage
