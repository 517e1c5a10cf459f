// Listens to a running camera process for some time: the processor it takes, how long after its
// measurement an image is published and arrives, and what is lost. tests/bench/camera_processes
// starts the process. Writes its figures as Google Benchmark does, for vantage-bench-table.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "bus/image_conversion.h"
#include "bus/live_bus.h"
#include "common/format.h"
#include "common/statistics.h"
#include "nodes/command_line.h"
#include "tests/bench/bench_rows.h"
#include "vantage/images_t.hpp"
#include "vantage/process_status_t.hpp"

namespace vantage {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kWarmUp(3);
constexpr std::chrono::seconds kPatience(20);  // for the first image

struct Arguments {
  int pid = 0;
  std::string name;    // of the rows
  std::string camera;  // the <NAME> of CAMERA_<NAME>
  double seconds = 20.0;
  std::string output;
};

// s of processor time that a process took since its start.
Result<double> ProcessorTime(int pid) {
  const std::string file = Format("/proc/%d/stat", pid);
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  // Fields 14 and 15, utime and stime; the second is a name in parentheses that may hold blanks.
  const std::string content = text.str();
  const size_t name_end = content.rfind(')');
  if (name_end == std::string::npos) {
    return Error{ErrorCode::kNotFound, file + " can't be read, expected a running process"};
  }
  std::istringstream fields(content.substr(name_end + 1));
  std::string skipped;
  for (int field = 3; field < 14; ++field) fields >> skipped;
  double user = 0.0;
  double system = 0.0;
  fields >> user >> system;
  return (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

class Listener {
 public:
  explicit Listener(int pid) : pid_(pid) {}

  Result<void> Subscribe(LiveBus& bus, const std::string& camera);
  void Clear() { *this = Listener(pid_); }
  [[nodiscard]] int64_t num_images() const { return static_cast<int64_t>(arrival_s_.size()); }
  [[nodiscard]] int64_t num_lost() const { return last_seq_ - first_seq_ + 1 - num_images(); }
  [[nodiscard]] const std::vector<double>& arrival_s() const { return arrival_s_; }
  [[nodiscard]] double bytes_per_image() const {
    return static_cast<double>(bytes_) / static_cast<double>(num_images());
  }
  /// From the measurement until it was published; nothing while the process has not told.
  [[nodiscard]] const std::optional<stage_status_t>& published() const { return published_; }

 private:
  int pid_;
  int64_t first_seq_ = -1;
  int64_t last_seq_ = -1;
  int64_t bytes_ = 0;
  std::vector<double> arrival_s_;  // s, from the measurement
  std::optional<stage_status_t> published_;
};

Result<void> Listener::Subscribe(LiveBus& bus, const std::string& camera) {
  const Result<void> images = bus.Subscribe<images_t>(
      "CAMERA_" + camera, {}, [this](const Envelope& envelope, const images_t& message) {
        if (message.images.empty()) return;
        last_seq_ = ImageSeq(message.images[0]);
        if (first_seq_ < 0) first_seq_ = last_seq_;
        for (const image_t& image : message.images) bytes_ += image.size;
        arrival_s_.push_back(1e-6 * static_cast<double>(envelope.receive_utime - message.utime));
      });
  if (!images) return images;
  return bus.Subscribe<process_status_t>(
      "PROCESS_STATUS", {}, [this](const Envelope&, const process_status_t& message) {
        if (message.pid != pid_) return;
        const auto stage =
            std::ranges::find(message.stages, "capture_to_publish", &stage_status_t::stage);
        if (stage != message.stages.end()) published_ = *stage;
      });
}

Result<void> Run(const Arguments& arguments) {
  LiveBus::Options options;
  options.name = "camera-process-bench";
  const Result<std::unique_ptr<LiveBus>> bus = LiveBus::Create(options);
  if (!bus) return bus.error();
  Listener listener(arguments.pid);
  if (Result<void> subscribed = listener.Subscribe(**bus, arguments.camera); !subscribed) {
    return subscribed;
  }
  const auto listen = [&](Clock::duration duration) {
    const Clock::time_point end = Clock::now() + duration;
    while (Clock::now() < end) (*bus)->Dispatch(std::chrono::milliseconds(10));
  };
  const Clock::time_point give_up = Clock::now() + kPatience;
  while (listener.num_images() == 0 && Clock::now() < give_up)
    listen(std::chrono::milliseconds(50));
  if (listener.num_images() == 0) {
    return Error{ErrorCode::kUnavailable,
                 Format("no image on CAMERA_%s within %jd s, expected one of process %d",
                        arguments.camera.c_str(),
                        intmax_t{kPatience.count()},
                        arguments.pid)};
  }
  listen(kWarmUp);
  listener.Clear();
  const Result<double> before = ProcessorTime(arguments.pid);
  const Clock::time_point start = Clock::now();
  listen(std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(arguments.seconds)));
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  const Result<double> after = ProcessorTime(arguments.pid);
  if (!before || !after) return before ? after.error() : before.error();
  if (listener.num_images() == 0 || !listener.published()) {
    return Error{ErrorCode::kUnavailable,
                 Format("CAMERA_%s: %jd images and %s of process %d, expected both",
                        arguments.camera.c_str(),
                        intmax_t{listener.num_images()},
                        listener.published() ? "a status" : "no status",
                        arguments.pid)};
  }
  const std::string& name = arguments.name;
  const double images = static_cast<double>(listener.num_images());
  nlohmann::json processor =
      BenchRow(name + "/processor", 100.0 * (*after - *before) / seconds, "%");
  processor["frames_per_second"] = images / seconds;
  processor["kilobytes"] = 1e-3 * listener.bytes_per_image();
  nlohmann::json published =
      BenchRow(name + "/capture_to_publish", 1e3 * listener.published()->latency_p50, "ms");
  published["p99_ms"] = 1e3 * listener.published()->latency_p99;
  nlohmann::json arrived =
      BenchRow(name + "/capture_to_arrival", 1e3 * Median(listener.arrival_s()), "ms");
  arrived["p99_ms"] = 1e3 * Quantile(listener.arrival_s(), 0.99);
  const double lost = static_cast<double>(listener.num_lost());
  nlohmann::json delivered = BenchRow(name + "/delivered", 100.0 * images / (images + lost), "%");
  delivered["images"] = images;
  delivered["lost"] = lost;
  return WriteBenchRows({processor, published, arrived, delivered}, arguments.output);
}

int Main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Measures a running camera process.", "camera_process_bench");
  app.add_option("--pid", arguments.pid, "of the process")->required();
  app.add_option("--camera", arguments.camera, "the <NAME> of its channels")->required();
  app.add_option("--name", arguments.name, "of the rows")->required();
  app.add_option("--seconds", arguments.seconds, "to listen, after a warm-up")
      ->check(CLI::Range(1.0, 1e5));
  app.add_option("--output", arguments.output, "JSON file to write")->required();
  if (const std::optional<int> code = ParseCommandLine(app, argc, argv)) return *code;
  const Result<void> done = Run(arguments);
  if (done) return 0;
  std::fprintf(stderr, "camera_process_bench: %s\n", done.error().message.c_str());
  return 2;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) { return vantage::Main(argc, argv); }
