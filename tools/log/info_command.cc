#include "tools/log/info_command.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>

#include "bus/event_log.h"
#include "bus/message_schema.h"
#include "bus/wire.h"
#include "common/format.h"

namespace vantage {
namespace {

// What is counted of one channel.
struct ChannelCount {
  std::string type;
  int64_t events = 0;
  int64_t bytes = 0;
  int64_t first_utime = 0;
  int64_t last_utime = 0;
};

std::string TypeName(const LogEvent& event) {
  constexpr size_t kFingerprintBytes = 8;
  if (event.data.size() < kFingerprintBytes) return "(too short)";
  const auto fingerprint = LoadBigEndian<int64_t>(event.data);
  const MessageSchema* schema = FindSchema(fingerprint);
  return schema != nullptr ? std::string(schema->name)
                           : Format("%016jx", static_cast<uintmax_t>(fingerprint));
}

void Count(const LogEvent& event, ChannelCount* count) {
  const std::string type = TypeName(event);
  if (count->events == 0) {
    count->type = type;
    count->first_utime = event.utime;
    count->last_utime = event.utime;
  } else if (count->type != type) {
    count->type = "(several)";
  }
  ++count->events;
  count->bytes += static_cast<int64_t>(event.data.size());
  count->first_utime = std::min(count->first_utime, event.utime);
  count->last_utime = std::max(count->last_utime, event.utime);
}

}  // namespace

InfoCommand::InfoCommand(CLI::App* app)
    : command_(app->add_subcommand("info", "tell what is in a log")) {
  command_->add_option("log", log_, "the log")->required();
}

Result<int> InfoCommand::Run() const {
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(log_);
  if (!reader) return reader.error();
  std::map<std::string, ChannelCount> channels;
  ChannelCount all;
  int64_t out_of_order = 0;
  int64_t previous = 0;
  while (const std::optional<LogEvent> event = (*reader)->Next()) {
    if (all.events > 0 && event->utime < previous) ++out_of_order;
    previous = event->utime;
    Count(*event, &channels[event->channel]);
    Count(*event, &all);
  }
  const auto seconds = [](const ChannelCount& count) {
    return 1e-6 * static_cast<double>(count.last_utime - count.first_utime);
  };
  std::printf("%s: %jd events, %.1f MB, %.3f s from %.6f\n",
              log_.c_str(),
              intmax_t{all.events},
              1e-6 * static_cast<double>(all.bytes),
              seconds(all),
              1e-6 * static_cast<double>(all.first_utime));
  std::printf("%-32s %-26s %9s %10s %12s\n", "channel", "type", "events", "rate Hz", "mean bytes");
  for (const auto& [channel, count] : channels) {
    const double span = seconds(count);
    const std::string rate =
        span > 0.0 ? Format("%.2f", static_cast<double>(count.events - 1) / span) : "-";
    std::printf("%-32s %-26s %9jd %10s %12jd\n",
                channel.c_str(),
                count.type.c_str(),
                intmax_t{count.events},
                rate.c_str(),
                intmax_t{count.bytes / count.events});
  }
  if (out_of_order > 0) {
    std::printf("out of order: %jd events are earlier than the one before\n",
                intmax_t{out_of_order});
  }
  const EventLogReader::Damage& damage = (*reader)->damage();
  std::printf("damage: %s\n", damage.any() ? damage.Describe().c_str() : "none");
  return 0;
}

}  // namespace vantage
