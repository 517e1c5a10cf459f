#include "tools/log/info_command.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "bus/event_log_reader.h"
#include "common/format.h"
#include "tools/log/log_progress.h"
#include "tools/log/log_summary.h"
#include "tools/log/shown_text.h"

namespace vantage {
namespace {

using nlohmann::json;

constexpr size_t kShown = 20;  // restarts, places of damage

double Seconds(int64_t utime) { return 1e-6 * static_cast<double>(utime); }

void PrintChannels(const LogSummary& summary) {
  size_t widest = 7;
  for (const auto& [name, unused] : summary.channels()) widest = std::max(widest, name.size());
  const int width = static_cast<int>(std::min<size_t>(widest, 40));
  std::printf("%-*s %-24s %8s %8s %9s %9s %18s %6s\n",
              width,
              "channel",
              "type",
              "events",
              "rate Hz",
              "mean B",
              "largest",
              "longest gap s (at)",
              "lost");
  for (const auto& [name, channel] : summary.channels()) {
    const double rate = channel.RateHz();
    std::string gap = "-";
    if (channel.longest_gap > 0) {
      gap = Format("%.3f (%.3f)",
                   Seconds(channel.longest_gap),
                   Seconds(channel.gap_utime - summary.all().first_utime));
    }
    std::printf("%-*s %-24s %8jd %8s %9jd %9jd %18s %6s\n",
                width,
                Printable(name).c_str(),
                Printable(channel.type).c_str(),
                intmax_t{channel.num_events},
                rate > 0.0 ? Format("%.2f", rate).c_str() : "-",
                intmax_t{channel.num_bytes / channel.num_events},
                intmax_t{channel.largest_bytes},
                gap.c_str(),
                channel.has_seq ? Format("%jd", intmax_t{channel.num_lost}).c_str() : "-");
  }
}

void PrintOrigin(const std::optional<LogOrigin>& origin) {
  if (!origin) {
    std::printf("no LOG_HEADER: what wrote it and by which configuration is unknown\n");
  } else if (!origin->newer.empty()) {
    std::printf("LOG_HEADER can't be read (%s): written by a newer version, or damaged\n",
                Printable(origin->newer).c_str());
  } else {
    std::printf("written by vantage %s, seed %jd, configuration %s\n",
                Printable(origin->version).c_str(),
                intmax_t{origin->seed},
                origin->config_hash.empty() ? "unknown" : origin->config_hash.c_str());
  }
}

void Print(const EventLogReader& reader, const LogSummary& summary) {
  const ChannelSummary& all = summary.all();
  std::printf("%s: %jd events, %s, %.3f s\n",
              reader.file().c_str(),
              intmax_t{all.num_events},
              BytesText(reader.file_bytes()).c_str(),
              Seconds(all.last_utime - all.first_utime));
  const std::string utc = UtcText(all.first_utime);
  const std::string local = LocalTimeText(all.first_utime);
  std::printf("from %s to %s%s\n",
              utc.c_str(),
              UtcText(all.last_utime).c_str(),
              local == utc ? "" : (" (from " + local + ")").c_str());
  PrintOrigin(summary.origin());
  PrintChannels(summary);
  for (size_t i = 0; i < std::min(kShown, summary.restarts().size()); ++i) {
    const LogSummary::Restart& restart = summary.restarts()[i];
    std::printf("restart: %s counts anew at %.3f s\n",
                Printable(restart.sender).c_str(),
                Seconds(restart.utime - all.first_utime));
  }
  if (summary.num_out_of_order() > 0) {
    std::printf("out of order: %jd events are earlier than the one before\n",
                intmax_t{summary.num_out_of_order()});
  }
  const EventLogReader::Damage& damage = reader.damage();
  std::printf("damage: %s\n", damage.any() ? damage.Describe().c_str() : "none");
  for (size_t i = 0; i < std::min(kShown, damage.places.size()); ++i) {
    std::printf("  %s\n", damage.places[i].Describe().c_str());
  }
}

json ToJson(const EventLogReader& reader, const LogSummary& summary) {
  const ChannelSummary& all = summary.all();
  const EventLogReader::Damage& damage = reader.damage();
  json channels = json::array();
  for (const auto& [name, channel] : summary.channels()) {
    channels.push_back({{"channel", name},
                        {"type", channel.type},
                        {"events", channel.num_events},
                        {"bytes", channel.num_bytes},
                        {"largest_bytes", channel.largest_bytes},
                        {"rate_hz", channel.RateHz()},
                        {"first_utime", channel.first_utime},
                        {"last_utime", channel.last_utime},
                        {"longest_gap_us", channel.longest_gap},
                        {"longest_gap_utime", channel.gap_utime},
                        {"lost", channel.has_seq ? json(channel.num_lost) : json()}});
  }
  json restarts = json::array();
  for (const LogSummary::Restart& restart : summary.restarts()) {
    restarts.push_back({{"sender", restart.sender}, {"utime", restart.utime}});
  }
  json places = json::array();
  for (const EventLogReader::Damage::Place& place : damage.places) {
    places.push_back({{"offset", place.offset},
                      {"bytes", place.bytes},
                      {"first_event", place.first_number},
                      {"events", place.num_events},
                      {"reason", place.reason}});
  }
  json header;
  if (const std::optional<LogOrigin>& origin = summary.origin()) {
    header = {{"readable", origin->newer.empty()},
              {"version", origin->version},
              {"seed", origin->seed},
              {"config_hash", origin->config_hash}};
  }
  return {{"log", reader.file().string()},
          {"file_bytes", reader.file_bytes()},
          {"events", all.num_events},
          {"first_utime", all.first_utime},
          {"last_utime", all.last_utime},
          {"header", header},
          {"channels", channels},
          {"lost", all.num_lost},
          {"restarts", restarts},
          {"out_of_order", summary.num_out_of_order()},
          {"damage",
           {{"bytes_skipped", damage.bytes_skipped},
            {"events_lost", damage.events_lost},
            {"events_mended", damage.events_mended},
            {"truncated", damage.truncated},
            {"read_error", damage.read_error},
            {"places", places}}}};
}

}  // namespace

InfoCommand::InfoCommand(CLI::App* app)
    : command_(app->add_subcommand("info", "tell what is in a log")) {
  command_->add_option("log", log_, "the log")->required();
  command_->add_flag("--json", json_, "for programs; times in us since the epoch");
}

Result<int> InfoCommand::Run() const {
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(log_);
  if (!reader) return reader.error();
  LogSummary summary;
  {
    LogProgress progress((*reader)->file_bytes());
    while (const std::optional<LogEventView> event = (*reader)->NextView()) {
      summary.Add(*event);
      progress.Show((*reader)->offset());
    }
  }
  if (json_) {
    // Names may hold bytes that are no UTF-8.
    constexpr auto kReplace = json::error_handler_t::replace;
    std::printf("%s\n", ToJson(**reader, summary).dump(2, ' ', false, kReplace).c_str());
  } else {
    Print(**reader, summary);
  }
  return 0;
}

}  // namespace vantage
