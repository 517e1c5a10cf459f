#include "tools/log/cut_command.h"

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>

#include "common/format.h"
#include "tools/log/event_type.h"
#include "tools/log/log_progress.h"
#include "tools/support/interrupt.h"
#include "tools/support/log_place.h"

namespace vantage {
namespace {

// Events that were written so much later or earlier than their times say are found all the same.
constexpr int64_t kDisorder = 60'000'000;  // us
// One event whose time is damaged does not end the search.
constexpr int kSurelyBehind = 100;

struct Stretch {
  int64_t from = std::numeric_limits<int64_t>::min();  // us since the epoch
  int64_t to = std::numeric_limits<int64_t>::max();    // us, the first time that is left out

  [[nodiscard]] bool Has(int64_t utime) const { return utime >= from && utime < to; }
  [[nodiscard]] bool IsFarBehind(int64_t utime) const {
    return utime >= 0 && utime - kDisorder > to;
  }
};

Result<Stretch> ParseStretch(const std::string& from, const std::string& to, int64_t start) {
  Stretch stretch;
  if (!from.empty()) {
    const Result<int64_t> place = ParseLogPlace("--from", from, start);
    if (!place) return place.error();
    stretch.from = *place;
  }
  if (!to.empty()) {
    const Result<int64_t> place = ParseLogPlace("--to", to, start);
    if (!place) return place.error();
    stretch.to = *place;
  }
  if (stretch.from >= stretch.to) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("--from %s is not before --to %s, expected a stretch of time",
                        from.c_str(),
                        to.c_str())};
  }
  return stretch;
}

// Copies what the stretch has, behind the log's header.
class Cutter {
 public:
  Cutter(const Stretch& stretch, EventLogWriter& writer) : stretch_(stretch), writer_(writer) {}

  void SetHeader(std::optional<LogEvent> header) { header_ = std::move(header); }

  // The header gets the time of the first event: a player would wait all the time between.
  Result<void> Take(const LogEventView& event) {
    const bool is_header = header_ && event.channel == kLogHeaderChannel;
    if (!stretch_.Has(event.utime) || is_header) return {};
    if (header_ && writer_.num_events() == 0) {
      Result<void> written = writer_.Write(event.utime, header_->channel, header_->data);
      if (!written) return written;
    }
    return writer_.Write(event.utime, event.channel, event.data);
  }

 private:
  Stretch stretch_;
  EventLogWriter& writer_;
  std::optional<LogEvent> header_;
};

}  // namespace

CutCommand::CutCommand(CLI::App* app)
    : command_(app->add_subcommand("cut", "write a log of a stretch of time")), output_(command_) {
  command_->add_option("log", log_, "the log")->required();
  command_->add_option("--from", from_, "seconds from the log's start, or a utime in us (start)");
  command_->add_option("--to", to_, "the same; events at this time are left out (end)");
}

Result<int> CutCommand::Run() const {
  if (from_.empty() && to_.empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 "cut with neither --from nor --to, expected one of them"};
  }
  Result<std::unique_ptr<EventLogReader>> opened = EventLogReader::Open(log_);
  if (!opened) return opened.error();
  EventLogReader& reader = **opened;
  std::optional<LogEvent> first = reader.Next();
  const int64_t start = first ? first->utime : 0;
  const Result<Stretch> stretch = ParseStretch(from_, to_, start);
  if (!stretch) return stretch.error();
  Result<std::unique_ptr<EventLogWriter>> writer = output_.Create({log_});
  if (!writer) return writer.error();
  const Interrupt interrupt("this event; the log is not written");
  Cutter cutter(*stretch, **writer);
  if (first && first->channel == kLogHeaderChannel) cutter.SetHeader(std::move(first));
  reader.SeekUtime(stretch->from > kDisorder ? stretch->from - kDisorder
                                             : std::numeric_limits<int64_t>::min());
  int num_behind = 0;  // In a row.
  {
    LogProgress progress(reader.file_bytes());
    while (const std::optional<LogEventView> event = reader.NextView()) {
      if (interrupt.token().stop_requested()) return kInterrupted;
      progress.Show(reader.offset());
      num_behind = stretch->IsFarBehind(event->utime) ? num_behind + 1 : 0;
      if (num_behind > kSurelyBehind) break;
      if (Result<void> taken = cutter.Take(*event); !taken) return taken.error();
    }
  }
  if ((*writer)->num_events() == 0) {
    const std::optional<EventLogReader::TimeSpan> span = reader.FindTimeSpan();
    const double seconds =
        span ? 1e-6 * static_cast<double>(span->last_utime - span->first_utime) : 0.0;
    return Error{ErrorCode::kNotFound,
                 Format("%s has no events from %s to %s, expected a stretch of its %.3f s",
                        log_.c_str(),
                        from_.empty() ? "the start" : from_.c_str(),
                        to_.empty() ? "the end" : to_.c_str(),
                        seconds)};
  }
  if (Result<void> closed = output_.Close(**writer); !closed) return closed.error();
  TellDamage(reader);
  return 0;
}

}  // namespace vantage
