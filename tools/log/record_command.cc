#include "tools/log/record_command.h"

#include <cstdio>

#include "bus/process_name_lock.h"
#include "common/format.h"
#include "nodes/config_reader.h"
#include "nodes/process.h"
#include "tools/log/recorder.h"
#include "tools/support/interrupt.h"

namespace vantage {
namespace {

constexpr int kEndedByItself = 1;
constexpr double kMostMb = 1e9;

// Recorders differ in their names, so that several may run.
Result<std::unique_ptr<ProcessNameLock>> LockName(const std::string& url, std::string* name) {
  constexpr int kMost = 16;
  for (int i = 1;; ++i) {
    *name = i == 1 ? "recorder" : Format("recorder-%d", i);
    Result<std::unique_ptr<ProcessNameLock>> lock = ProcessNameLock::Acquire(*name, url);
    if (lock || i == kMost || lock.error().code != ErrorCode::kUnavailable) return lock;
  }
}

void PrintParts(const Recording& recording, double seconds, const LossCounter& losses) {
  for (const Recording::Part& part : recording.Parts()) {
    std::printf("%s: %jd events, %.1f MB\n",
                part.file.c_str(),
                intmax_t{part.num_events},
                1e-6 * static_cast<double>(part.num_bytes));
  }
  std::printf("recorded %.1f s; %s\n",
              seconds,
              losses.total() == 0 ? "nothing lost" : losses.Describe().c_str());
}

}  // namespace

RecordCommand::RecordCommand(CLI::App* app)
    : command_(app->add_subcommand("record", "make a log of what is on the bus, until Ctrl-C")) {
  command_->add_option("--config,-c", config_, "TOML file of the set-up, to go into LOG_HEADER");
  CLI::Option* file = command_->add_option("--output,-o", file_, "the log to write");
  command_
      ->add_option(
          "--folder", folder_, "write logs here that are named after the time (default: .)")
      ->excludes(file);
  command_->add_option("--channels", channels_, "regular expression of the channels (.*)");
  command_->add_option("--exclude", exclude_, "the same, of channels not to record");
  CLI::Option* split_mb =
      command_->add_option("--split-mb", split_mb_, "MB after which another file begins")
          ->check(CLI::Range(0.001, kMostMb));
  command_->add_option("--split-minutes", split_minutes_, "minutes after which another file begins")
      ->check(CLI::Range(0.001, 1e6))
      ->excludes(split_mb);
  command_
      ->add_option("--min-free-mb", min_free_mb_, "MB left on the disk with which it ends (256)")
      ->check(CLI::Range(0.0, kMostMb));
  command_->add_flag("--force", force_, "write over a log that is there");
  command_->add_option("--lcm-url", url_, "LCM URL; default: [bus] url, then LCM_DEFAULT_URL");
}

Result<int> RecordCommand::Run() const {
  const Result<RecordingOptions> options = ReadOptions();
  if (!options) return options.error();
  Result<LiveBus::Options> bus_options = ReadBus();
  if (!bus_options) return bus_options.error();
  const Result<std::unique_ptr<ProcessNameLock>> lock =
      LockName(bus_options->url, &bus_options->name);
  if (!lock) return lock.error();
  const Interrupt interrupt("what has arrived is written");
  Result<std::unique_ptr<LiveBus>> bus = LiveBus::Create(*bus_options);
  if (!bus) return bus.error();
  Recorder recorder(bus->get());
  if (Result<void> heard = recorder.Listen(channels_, exclude_); !heard) return heard.error();
  const int64_t start = (*bus)->NowUtime();
  Result<std::unique_ptr<Recording>> recording = Recording::Start(*options, start);
  if (!recording) return recording.error();
  std::fprintf(stderr,
               "vantage-log: recording %s to %s\n",
               (*bus)->url().c_str(),
               (*recording)->path().c_str());
  const Result<void> ran = recorder.Run(recording->get(), interrupt.token());
  PrintParts(
      **recording, 1e-6 * static_cast<double>((*bus)->NowUtime() - start), recorder.losses());
  if (ran) return 0;
  std::fprintf(stderr,
               "vantage-log: recording ended: %s; what was written before is kept\n",
               ran.error().message.c_str());
  return kEndedByItself;
}

Result<RecordingOptions> RecordCommand::ReadOptions() const {
  constexpr double kBytes = 1e6;         // in a MB
  constexpr double kMicroseconds = 6e7;  // in a minute
  RecordingOptions options;
  options.file = file_;
  if (file_.empty()) options.folder = folder_.empty() ? "." : folder_;
  options.overwrite = force_;
  options.split_bytes = static_cast<int64_t>(kBytes * split_mb_);
  options.split_us = static_cast<int64_t>(kMicroseconds * split_minutes_);
  options.min_free_bytes = static_cast<int64_t>(kBytes * min_free_mb_);
  Result<LogSetup> setup = ReadLogSetup(config_);
  if (!setup) return setup.error();
  options.setup = std::move(setup).value();
  return options;
}

Result<LiveBus::Options> RecordCommand::ReadBus() const {
  LiveBus::Options options;
  options.version = VANTAGE_VERSION;
  if (!config_.empty()) {
    Result<ConfigReader> config = ConfigReader::Open(config_);
    if (!config) return config.error();
    options = ReadBusOptions(*config);
    IgnoreTablesOfOthers(*config);
    if (Result<void> read = config->Finish(); !read) return read.error();
  }
  if (!url_.empty()) options.url = url_;
  return options;
}

}  // namespace vantage
