#include "tools/log/check_command.h"

#include <cstdio>
#include <memory>
#include <optional>

#include "bus/event_log_reader.h"
#include "common/format.h"
#include "tools/log/log_check.h"
#include "tools/log/log_progress.h"
#include "tools/log/shown_text.h"

namespace vantage {
namespace {

constexpr int kDamaged = 1;

void PrintDoubt(const LogCheck::Doubt& doubt) {
  std::printf("doubtful: event %jd at byte %jd, %s, utime %jd: %s\n",
              intmax_t{doubt.place.number},
              intmax_t{doubt.place.offset},
              Printable(doubt.place.channel).c_str(),
              intmax_t{doubt.place.utime},
              doubt.reason.c_str());
}

// Both lists in the order of the file.
void PrintPlaces(const LogDamage& damage, const LogCheck& check) {
  auto place = damage.places.begin();
  for (const LogCheck::Doubt& doubt : check.doubts()) {
    for (; place != damage.places.end() && place->offset <= doubt.place.offset; ++place) {
      std::printf("damaged: %s\n", place->Describe().c_str());
    }
    PrintDoubt(doubt);
  }
  for (; place != damage.places.end(); ++place) {
    std::printf("damaged: %s\n", place->Describe().c_str());
  }
  const auto listed = static_cast<int64_t>(damage.places.size() + check.doubts().size());
  const int64_t all = damage.num_places + damage.events_mended + check.num_doubts();
  if (all > listed) std::printf("and %jd more\n", intmax_t{all - listed});
}

}  // namespace

CheckCommand::CheckCommand(CLI::App* app)
    : command_(app->add_subcommand("check", "look for damage; exit code 1 where there is some")) {
  command_->add_option("log", log_, "the log")->required();
}

Result<int> CheckCommand::Run() const {
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(log_);
  if (!reader) return reader.error();
  LogCheck check;
  {
    LogProgress progress((*reader)->file_bytes());
    while (const std::optional<LogEventView> event = (*reader)->NextView()) {
      check.Add(*event);
      progress.Show((*reader)->offset());
    }
  }
  check.Finish();
  const LogDamage& damage = (*reader)->damage();
  PrintPlaces(damage, check);
  // Each stretch that was lost is one such place.
  if (check.num_jumps() > damage.num_places) {
    std::printf(
        "note: event numbers go on elsewhere %jd times, as in logs that were cut or joined\n",
        intmax_t{check.num_jumps()});
  }
  const bool is_sound = !damage.any() && check.num_doubts() == 0;
  std::printf("%s: %jd events, %s, %s%s\n",
              log_.c_str(),
              intmax_t{check.num_events()},
              damage.any() ? damage.Describe().c_str() : "no damage",
              check.num_doubts() > 0 ? Format("%jd doubtful", intmax_t{check.num_doubts()}).c_str()
                                     : "none doubtful",
              damage.any() ? "; `vantage-log repair` writes what can be read" : "");
  return is_sound ? 0 : kDamaged;
}

}  // namespace vantage
