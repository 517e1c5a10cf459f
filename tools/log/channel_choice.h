#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "bus/channel_pattern.h"
#include "common/result.h"

namespace vantage {

/// Which channels of a log are wanted: those that match some pattern, or all where there is none,
/// and none of those to leave out. LOG_HEADER always is.
class ChannelChoice {
 public:
  /// "A|B" counts as two patterns, so that each must be there.
  /// Errors: a pattern is empty or no regular expression.
  static Result<ChannelChoice> Create(const std::vector<std::string>& wanted,
                                      const std::vector<std::string>& unwanted);

  [[nodiscard]] bool Wants(std::string_view channel);
  /// After the log's end. Errors: a pattern matched no channel; the sentence names those there are.
  [[nodiscard]] Result<void> Validate(const std::string& log) const;

  static constexpr size_t kMaxChannels = 5000;  ///< remembered

 private:
  struct Pattern {
    ChannelPattern pattern;
    bool is_met = false;
  };
  static Result<std::vector<Pattern>> Compile(const std::vector<std::string>& texts);
  bool Decide(const std::string& channel);

  std::vector<Pattern> wanted_;
  std::vector<Pattern> unwanted_;
  std::map<std::string, bool, std::less<>> decided_;
};

}  // namespace vantage
