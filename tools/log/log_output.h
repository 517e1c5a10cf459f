#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "bus/event_log_reader.h"
#include "bus/event_log_writer.h"
#include "common/result.h"

namespace vantage {

/// The options --output and --force of a subcommand that makes one log of others.
class LogOutput {
 public:
  explicit LogOutput(CLI::App* command);

  /// Errors: the output is one of the inputs; it exists, without --force; it is no regular file;
  /// the system refuses.
  [[nodiscard]] Result<std::unique_ptr<EventLogWriter>> Create(
      const std::vector<std::string>& inputs) const;
  /// Completes the log and says so on standard output.
  Result<void> Close(EventLogWriter& writer) const;

 private:
  std::string file_;
  bool force_ = false;
};

/// One line on standard error for each input that is damaged.
void TellDamage(const EventLogReader& reader);

}  // namespace vantage
