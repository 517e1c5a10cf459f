#include "tools/support/log_config.h"

#include <memory>
#include <optional>

#include "bus/event_log.h"
#include "bus/message_check.h"
#include "common/format.h"
#include "vantage/log_header_t.hpp"

namespace vantage {

Result<ConfigReader> OpenConfig(const std::string& config_file, const std::string& log) {
  if (!config_file.empty()) return ConfigReader::Open(config_file);
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(log);
  if (!reader) return reader.error();
  const std::optional<LogEvent> first = (*reader)->Next();
  if (first && first->channel == "LOG_HEADER") {
    const Result<log_header_t> header = DecodeChecked<log_header_t>(first->data);
    if (header && !header->config_text.empty()) {
      return ConfigReader::Parse(header->config_text, log + " LOG_HEADER");
    }
  }
  return Error{
      ErrorCode::kNotFound,
      Format("log %s has no LOG_HEADER with a configuration, expected one or --config FILE",
             log.c_str())};
}

}  // namespace vantage
