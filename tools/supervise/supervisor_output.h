#pragma once

#include <optional>
#include <set>
#include <string>

namespace vantage {

/// What supervisord says line by line, for people, and what follows from it.
class SupervisorOutput {
 public:
  /// What a line comes to; an empty text when it is of no interest.
  std::string Read(const std::string& line);

  /// The process that the last line tells the end of, if it was not asked to end.
  [[nodiscard]] const std::optional<std::string>& ended() const { return ended_; }
  /// The first process that it gave up.
  [[nodiscard]] const std::optional<std::string>& failed() const { return failed_; }
  /// Processes that have stayed up for long enough.
  [[nodiscard]] const std::set<std::string>& running() const { return running_; }

 private:
  std::optional<std::string> ended_;
  std::optional<std::string> failed_;
  std::set<std::string> running_;
};

}  // namespace vantage
