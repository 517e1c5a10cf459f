#include "tools/replay/replay_run.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "common/format.h"
#include "tools/replay/estimate_ahead.h"
#include "tools/replay/replay_nodes.h"
#include "tools/support/log_place.h"

namespace vantage {
namespace {

// What the nodes here publish anew. `DETECTIONS_` of others than the estimators that are rerun are
// anew only where they do not count as input.
constexpr const char* kRecomputed = "|OBJECTS|ORIENTATION_HISTOGRAM|NEXT_VIEW|PROCESS_STATUS";

// It answers the recorded NEXT_VIEW: input where that is recomputed as it was.
constexpr const char* kAnswers = "|DETECTIONS_.*|ARM_STATUS";

// What vantage-extrinsics publishes.
constexpr const char* kRecomputedExtrinsics =
    "|CAMERA_.*_TO_WORLD|NEXT_HAND_POSE|HANDEYE_RESULT|HANDEYE_CHECK";

constexpr int64_t kOrderWindow = 1'000'000;        // us, by which events may come too late
constexpr size_t kAheadBytes = size_t{64} << 20U;  // Of images that were estimated ahead.
constexpr int kMostThreads = 256;

std::string Suppressed(const ReplayOptions& options) {
  std::string pattern;
  for (const std::string& name : options.estimators) {
    pattern += (pattern.empty() ? "" : "|") + DetectionsChannel(name);
  }
  pattern += kRecomputed;
  if (!options.as_received) pattern += kAnswers;
  if (options.with_extrinsics) pattern += kRecomputedExtrinsics;
  return pattern;
}

Result<void> CheckOptions(const ReplayOptions& options) {
  if (options.threads < 1 || options.threads > kMostThreads) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("--threads is %d, expected 1 to %d", options.threads, kMostThreads)};
  }
  for (const std::string& name : options.estimators) {
    if (std::ranges::count(options.estimators, name) > 1) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("--estimator names %s twice, expected each once", name.c_str())};
    }
  }
  return {};
}

/// What of the log is read. Errors: the log, --channels, --from or --to.
Result<EventStream::Options> InputOf(const ReplayOptions& options) {
  EventStream::Options input;
  input.channels = options.channels;
  input.window_us = kOrderWindow;
  if (options.from.empty() && options.to.empty()) return input;
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(options.log);
  if (!reader) return reader.error();
  const std::optional<LogEvent> first = (*reader)->Next();
  const int64_t start = first ? first->utime : 0;
  if (!options.from.empty()) {
    const Result<int64_t> from = ParseLogPlace("--from", options.from, start);
    if (!from) return from.error();
    input.from_utime = *from;
  }
  if (!options.to.empty()) {
    const Result<int64_t> to = ParseLogPlace("--to", options.to, start);
    if (!to) return to.error();
    input.to_utime = *to;
  }
  if (input.from_utime && input.to_utime && *input.from_utime > *input.to_utime) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("--from %s is after --to %s, expected a place before it",
                        options.from.c_str(),
                        options.to.c_str())};
  }
  return input;
}

/// Nothing of the log was wanted.
Error NothingRead(const ReplayOptions& options, const EventStream& input) {
  if (input.channels().empty()) {
    return {ErrorCode::kCorrupt, "log " + options.log + " has no event that is whole"};
  }
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(options.log);
  if (!reader) return reader.error();
  const EventLogReader::TimeSpan log =
      (*reader)->FindTimeSpan().value_or(EventLogReader::TimeSpan());
  const double span =
      1e-6 * (static_cast<double>(log.last_utime) - static_cast<double>(log.first_utime));
  std::string wanted;
  if (!options.channels.empty()) wanted += " --channels " + options.channels;
  if (!options.from.empty()) wanted += " --from " + options.from;
  if (!options.to.empty()) wanted += " --to " + options.to;
  std::string there =
      Format("it has %.1f s from the utime %jd on", span, intmax_t{log.first_utime});
  if (!options.channels.empty()) {
    const char* separator = ", of these channels: ";
    for (const std::string& name : input.channels()) {
      there += std::exchange(separator, ", ") + name;
    }
  }
  return {
      ErrorCode::kNotFound,
      Format("nothing of log %s is in%s; %s", options.log.c_str(), wanted.c_str(), there.c_str())};
}

void AddInputWarnings(const EventStream::Counters& counters, std::vector<std::string>* warnings) {
  if (counters.num_late > 0) {
    warnings->push_back(Format(
        "the log's time goes back %jd times by more than %.1f s, by %.3f s at most, at first "
        "at event %jd: a clock was set, or another recording begins there; such events were "
        "taken as they stand",
        intmax_t{counters.num_late},
        1e-6 * double{kOrderWindow},
        counters.largest_step_back,
        intmax_t{*counters.late_event}));
  }
}

/// A rerun, from its options to its end.
class Rerun {
 public:
  Rerun(const ReplayOptions& options, const ReplayProgress& progress)
      : options_(options),
        progress_(progress),
        cache_(options.cache ? options.cache : std::make_shared<EstimatorCache>()) {}

  Result<ReplaySummary> Run() {
    if (Result<void> sound = CheckOptions(options_); !sound) return sound.error();
    if (Result<void> opened = OpenBus(); !opened) return opened.error();
    if (Result<void> made = MakeNodes(); !made) return made.error();
    if (Result<void> stepped = Step(); !stepped) return stepped.error();
    return Finish();
  }

 private:
  Result<void> OpenBus() {
    Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(options_.log);
    if (!reader) return reader.error();
    Result<ConfigReader> config = options_.open_config();
    if (!config) return config.error();
    Result<EventStream::Options> input = InputOf(options_);
    if (!input) return input.error();
    for (const std::string& name : options_.estimators) {
      Result<ConfigReader> own = options_.open_config();
      if (!own) return own.error();
      Result<EstimatorCache::Made> made = cache_->Make(name, *own);
      if (!made) return made.error();
      made_.push_back(std::move(made).value());
    }
    if (!options_.output.empty()) {
      Result<std::unique_ptr<EventLogWriter>> created = EventLogWriter::Create(options_.output);
      if (!created) return created.error();
      writer_ = std::move(created).value();
    }
    bus_options_.input = std::move(input).value();
    bus_options_.suppress = Suppressed(options_);
    bus_options_.copy_inputs = options_.with_inputs;
    bus_options_.header.version = VANTAGE_VERSION;
    bus_options_.header.config_text = config->text();
    bus_options_.header.seed = static_cast<int64_t>(made_.front().config.seed);
    Result<std::unique_ptr<LogBus>> bus =
        LogBus::Create(bus_options_, std::move(reader).value(), writer_.get());
    if (!bus) return bus.error();
    bus_ = std::move(bus).value();
    return {};
  }

  Result<void> MakeNodes() {
    std::vector<ReplayEstimator> estimators;
    std::vector<ReplayEstimator> scouting;
    if (options_.threads > 1) {
      ahead_ = std::make_unique<EstimateAhead>([this] { return bus_->counters().num_events; },
                                               kAheadBytes);
    }
    for (size_t i = 0; i < made_.size(); ++i) {
      const auto& [config, prototype] = made_[i];
      const std::string& name = options_.estimators[i];
      if (ahead_) {
        EstimateAhead::Ends ends = ahead_->Add(prototype, config.seed);
        scouting.push_back({name, config, std::move(ends.ask)});
        estimators.push_back({name, config, std::move(ends.answer)});
      } else {
        estimators.push_back({name, config, EstimateBy(prototype->Clone(), config.seed)});
      }
    }
    Result<ReplayNodes> nodes = MakeReplayNodes(bus_.get(), options_, estimators);
    if (!nodes) return nodes.error();
    nodes_ = std::move(nodes).value();
    const auto keep = [this](const Envelope&, const object_estimates_v3_t& message) {
      summary_.objects = message;
    };
    if (Result<void> kept = bus_->Subscribe<object_estimates_v3_t>("OBJECTS", {}, keep); !kept) {
      return kept;
    }
    return ahead_ ? StartScout(scouting) : Result<void>();
  }

  Result<void> StartScout(const std::vector<ReplayEstimator>& estimators) {
    Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(options_.log);
    if (!reader) return reader.error();
    Result<std::unique_ptr<LogBus>> created =
        LogBus::Create(bus_options_, std::move(reader).value(), nullptr);
    if (!created) return created.error();
    const std::shared_ptr<LogBus> bus = std::move(created).value();
    Result<ReplayNodes> made = MakeScoutNodes(bus.get(), options_, estimators);
    if (!made) return made.error();
    const auto nodes = std::make_shared<ReplayNodes>(std::move(made).value());
    EstimateAhead::Scout scout;
    scout.step = [bus, nodes] {
      const Result<bool> more = bus->Step();
      return more.ok() && *more;
    };
    scout.num_events = [bus] { return bus->counters().num_events; };
    ahead_->Start(std::move(scout), options_.threads - 1);
    return {};
  }

  Result<void> Step() {
    start_utime_ = bus_->NowUtime();
    while (true) {
      const Result<bool> more = bus_->Step();
      if (!more) return more.error();
      if (!*more) break;
      progress_(bus_->input().reader().progress(), bus_->counters().num_events);
    }
    ahead_.reset();
    return {};
  }

  Result<ReplaySummary> Finish() {
    if (bus_->counters().num_events == 0) return NothingRead(options_, bus_->input());
    if (nodes_.as_received && nodes_.as_received->num_delivered() == 0) {
      return Error{ErrorCode::kNotFound,
                   Format("log %s has no %s of its images, expected some: they say which images "
                          "live processes took",
                          options_.log.c_str(),
                          DetectionsChannel(options_.estimators.front()).c_str())};
    }
    if (writer_) {
      if (Result<void> closed = writer_->Close(); !closed) return closed.error();
    }
    summary_.counters = bus_->counters();
    summary_.damage = bus_->input().reader().damage();
    summary_.span =
        1e-6 * (static_cast<double>(bus_->NowUtime()) - static_cast<double>(start_utime_));
    AddInputWarnings(bus_->input().counters(), &summary_.warnings);
    if (nodes_.as_received) {
      for (std::string& warning : nodes_.as_received->Warnings()) {
        summary_.warnings.push_back(std::move(warning));
      }
    }
    return std::move(summary_);
  }

  const ReplayOptions& options_;
  const ReplayProgress& progress_;
  std::shared_ptr<EstimatorCache> cache_;
  std::vector<EstimatorCache::Made> made_;
  std::unique_ptr<EventLogWriter> writer_;
  LogBus::Options bus_options_;
  std::unique_ptr<LogBus> bus_;
  ReplayNodes nodes_;
  std::unique_ptr<EstimateAhead> ahead_;  // Goes first: its threads end.
  ReplaySummary summary_;
  int64_t start_utime_ = 0;
};

}  // namespace

Result<ReplaySummary> RunReplay(const ReplayOptions& options, const ReplayProgress& progress) {
  return Rerun(options, progress).Run();
}

}  // namespace vantage
