// Measures vantage-log on a large log beside `cat LOG`, which reads it and does nothing: with
// the file out of the page cache, so that both wait for the disk, and in it as far as it fits.

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <vector>

#include "common/format.h"
#include "common/result.h"
#include "nodes/command_line.h"
#include "tests/bench/bench_rows.h"
#include "tests/bench/large_log.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  double gigabytes = 10.0;
  int rounds = 3;
  std::string folder;
  std::string program;
  std::string output;
};

struct Cost {
  double seconds = 0.0;
  double processor = 0.0;  // s
  double megabytes = 0.0;  // of memory, the most
};

// Runs a program to its end, its output thrown away.
Result<Cost> Measure(std::vector<std::string> command) {
  const auto start = std::chrono::steady_clock::now();
  const pid_t child = fork();
  if (child < 0) return Error{ErrorCode::kUnavailable, "no process can be started"};
  if (child == 0) {
    const int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, STDOUT_FILENO);
    std::vector<char*> arguments;
    for (std::string& each : command) arguments.push_back(each.data());
    arguments.push_back(nullptr);
    execvp(arguments[0], arguments.data());
    _exit(127);
  }
  int status = 0;
  struct rusage usage {};
  wait4(child, &status, 0, &usage);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    return Error{ErrorCode::kUnavailable,
                 Format("%s ended with status %d, expected 0", command[0].c_str(), status)};
  }
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return Cost{
      .seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
      .processor = seconds(usage.ru_utime) + seconds(usage.ru_stime),
      .megabytes = 1.024e-3 * static_cast<double>(usage.ru_maxrss)};
}

void DropFromCache(const fs::path& file) {
  const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return;
  fsync(descriptor);
  static_cast<void>(posix_fadvise(descriptor, 0, 0, POSIX_FADV_DONTNEED));
  close(descriptor);
}

double Median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

// Rounds of both programs in turn.
class Comparison {
 public:
  Comparison(std::string name, bool is_cold) : name_(std::move(name)), is_cold_(is_cold) {}

  Result<void> Run(const Arguments& arguments, const fs::path& log) {
    for (int i = 0; i < arguments.rounds; ++i) {
      if (is_cold_) DropFromCache(log);
      const Result<Cost> cat = Measure({"cat", log.string()});
      if (!cat) return cat.error();
      if (is_cold_) DropFromCache(log);
      const Result<Cost> info = Measure({arguments.program, "info", log.string()});
      if (!info) return info.error();
      cat_.push_back(cat->seconds);
      info_.push_back(info->seconds);
      ratios_.push_back(info->seconds / cat->seconds);
      processor_.push_back(info->processor);
      megabytes_ = std::max(megabytes_, info->megabytes);
    }
    return {};
  }

  void AppendTo(nlohmann::json* rows, double gigabytes) const {
    const auto row = [this](const char* what, double seconds) {
      return nlohmann::json{{"run_name", what + name_},
                            {"aggregate_name", "median"},
                            {"cpu_time", seconds},
                            {"time_unit", "s"}};
    };
    nlohmann::json info = row("info_", Median(info_));
    info["by_cat"] = Median(ratios_);
    info["gigabytes_per_second"] = gigabytes / Median(info_);
    info["processor_s"] = Median(processor_);
    info["memory_megabytes"] = megabytes_;
    nlohmann::json cat = row("cat_", Median(cat_));
    cat["gigabytes_per_second"] = gigabytes / Median(cat_);
    rows->push_back(info);
    rows->push_back(cat);
  }

 private:
  std::string name_;
  bool is_cold_;
  std::vector<double> cat_;  // s
  std::vector<double> info_;
  std::vector<double> ratios_;
  std::vector<double> processor_;
  double megabytes_ = 0.0;
};

Result<void> Run(const Arguments& arguments, const fs::path& log) {
  if (Result<void> written = WriteLargeLog(log, static_cast<int64_t>(1e9 * arguments.gigabytes));
      !written) {
    return written;
  }
  std::error_code error;
  const double gigabytes = 1e-9 * static_cast<double>(fs::file_size(log, error));
  Comparison cold("cold", true);
  Comparison warm("warm", false);
  if (Result<void> done = cold.Run(arguments, log); !done) return done;
  if (Result<void> done = warm.Run(arguments, log); !done) return done;
  nlohmann::json rows = nlohmann::json::array();
  cold.AppendTo(&rows, gigabytes);
  warm.AppendTo(&rows, gigabytes);
  const fs::path part = log.string() + ".part";
  const Result<Cost> cut = Measure({arguments.program,
                                    "cut",
                                    log.string(),
                                    "--from",
                                    "3000",
                                    "--to",
                                    "3010",
                                    "--force",
                                    "--output",
                                    part.string()});
  fs::remove(part, error);
  if (!cut) return cut.error();
  rows.push_back({{"run_name", "cut_ten_seconds"},
                  {"aggregate_name", "median"},
                  {"cpu_time", cut->seconds},
                  {"time_unit", "s"},
                  {"memory_megabytes", cut->megabytes}});
  return WriteBenchRows(rows, arguments.output);
}

int Main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Measures vantage-log on a large log that it makes.", "log_file_bench");
  app.add_option("--gigabytes", arguments.gigabytes, "of the log")->check(CLI::Range(1.0, 1e3));
  app.add_option("--rounds", arguments.rounds, "of each measurement")->check(CLI::Range(1, 100));
  app.add_option("--folder", arguments.folder, "where the log is made, and removed")->required();
  app.add_option("--program", arguments.program, "vantage-log")->required();
  app.add_option("--output", arguments.output, "JSON file to write")->required();
  if (const std::optional<int> code = ParseCommandLine(app, argc, argv)) return *code;
  const fs::path log = fs::path(arguments.folder) / Format("large-%d.lcm", getpid());
  const Result<void> done = Run(arguments, log);
  std::error_code error;
  fs::remove(log, error);
  if (done) return 0;
  std::fprintf(stderr, "log_file_bench: %s\n", done.error().message.c_str());
  return 2;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) { return vantage::Main(argc, argv); }
