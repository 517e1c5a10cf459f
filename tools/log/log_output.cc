#include "tools/log/log_output.h"

#include <cstdio>
#include <filesystem>
#include <system_error>

#include "common/format.h"
#include "tools/log/shown_text.h"

namespace vantage {

namespace fs = std::filesystem;

LogOutput::LogOutput(CLI::App* command) {
  command->add_option("--output,-o", file_, "the log to write")->required();
  command->add_flag("--force", force_, "replace the output where it exists");
}

Result<std::unique_ptr<EventLogWriter>> LogOutput::Create(
    const std::vector<std::string>& inputs) const {
  std::error_code error;
  for (const std::string& input : inputs) {
    if (!fs::equivalent(input, file_, error)) continue;
    return Error{ErrorCode::kInvalidArgument,
                 Format("output %s is the log that is read, expected another", file_.c_str())};
  }
  const fs::file_status status = fs::status(file_, error);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("output %s is no regular file, expected a log to write", file_.c_str())};
  }
  if (fs::exists(status) && !force_) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("output %s exists, expected a new name or --force", file_.c_str())};
  }
  return EventLogWriter::Create(file_);
}

Result<void> LogOutput::Close(EventLogWriter& writer) const {
  if (Result<void> closed = writer.Close(); !closed) return closed;
  std::error_code error;
  const auto bytes = static_cast<int64_t>(fs::file_size(file_, error));
  std::printf("wrote %s: %jd events, %s\n",
              file_.c_str(),
              intmax_t{writer.num_events()},
              BytesText(bytes).c_str());
  return {};
}

void TellDamage(const EventLogReader& reader) {
  if (!reader.damage().any()) return;
  std::fprintf(stderr,
               "vantage-log: %s is damaged: %s\n",
               reader.file().c_str(),
               reader.damage().Describe().c_str());
}

}  // namespace vantage
