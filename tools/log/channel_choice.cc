#include "tools/log/channel_choice.h"

#include "common/format.h"
#include "tools/log/event_type.h"
#include "tools/log/shown_text.h"

namespace vantage {

Result<ChannelChoice> ChannelChoice::Create(const std::vector<std::string>& wanted,
                                            const std::vector<std::string>& unwanted) {
  ChannelChoice choice;
  Result<std::vector<Pattern>> compiled = Compile(wanted);
  if (!compiled) return compiled.error();
  choice.wanted_ = std::move(compiled).value();
  compiled = Compile(unwanted);
  if (!compiled) return compiled.error();
  choice.unwanted_ = std::move(compiled).value();
  return choice;
}

Result<std::vector<ChannelChoice::Pattern>> ChannelChoice::Compile(
    const std::vector<std::string>& texts) {
  std::vector<Pattern> patterns;
  for (const std::string& text : texts) {
    const bool is_list = text.find_first_of("()[]\\") == std::string::npos;
    size_t begin = 0;
    while (begin <= text.size()) {
      const size_t end = is_list ? std::min(text.find('|', begin), text.size()) : text.size();
      Result<ChannelPattern> pattern = ChannelPattern::Create(text.substr(begin, end - begin));
      if (!pattern) return pattern.error();
      patterns.push_back({.pattern = std::move(pattern).value()});
      begin = end + 1;
    }
  }
  return patterns;
}

bool ChannelChoice::Wants(std::string_view channel) {
  const auto known = decided_.find(channel);
  if (known != decided_.end()) return known->second;
  std::string name(channel);
  const bool wants = Decide(name);
  if (decided_.size() < kMaxChannels) decided_.emplace(std::move(name), wants);
  return wants;
}

bool ChannelChoice::Decide(const std::string& channel) {
  bool wants = wanted_.empty();
  for (Pattern& each : wanted_) {
    if (!each.pattern.Matches(channel)) continue;
    each.is_met = true;
    wants = true;
  }
  for (Pattern& each : unwanted_) {
    if (!each.pattern.Matches(channel)) continue;
    each.is_met = true;
    wants = false;
  }
  return wants || channel == kLogHeaderChannel;
}

Result<void> ChannelChoice::Validate(const std::string& log) const {
  for (const std::vector<Pattern>* patterns : {&wanted_, &unwanted_}) {
    for (const Pattern& each : *patterns) {
      if (each.is_met) continue;
      std::string there;
      for (const auto& [channel, unused] : decided_) {
        there += (there.empty() ? "" : ", ") + Printable(channel);
      }
      return Error{ErrorCode::kNotFound,
                   Format("%s has no channel %s, expected one of ",
                          log.c_str(),
                          Printable(each.pattern.text()).c_str()) +
                       there};
    }
  }
  return {};
}

}  // namespace vantage
