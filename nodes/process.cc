#include "nodes/process.h"

#include <pthread.h>

#include <csignal>
#include <cstdio>
#include <sstream>
#include <stop_token>
#include <thread>

#include "bus/live_bus.h"
#include "bus/process_name_lock.h"
#include "common/format.h"
#include "nodes/command_line.h"

namespace vantage {
namespace {

constexpr int kBadInput = 2;

int Fail(const std::string& name, const Error& error) {
  std::fprintf(stderr, "%s: %s\n", name.c_str(), error.message.c_str());
  return kBadInput;
}

// What this process runs with, for whoever reads its log later.
void PrintStart(const std::string& name,
                const std::string& config_file,
                const ConfigReader& config,
                const std::string& url) {
  std::fprintf(stderr,
               "%s %s: config %s (%s), %s\n",
               name.c_str(),
               VANTAGE_VERSION,
               config_file.c_str(),
               config.Hash().c_str(),
               url.c_str());
  std::istringstream lines(config.Effective());
  for (std::string line; std::getline(lines, line);) std::fprintf(stderr, "  %s\n", line.c_str());
}

// Turns the first SIGINT or SIGTERM into a stop; blocked before any thread starts, so that only
// this thread ever sees them.
class SignalStop {
 public:
  SignalStop() {
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGINT);
    sigaddset(&signals_, SIGTERM);
    sigaddset(&signals_, SIGUSR2);
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
    waiter_ = std::thread([this] {
      int signal = 0;
      sigwait(&signals_, &signal);
      source_.request_stop();
    });
  }
  ~SignalStop() {
    pthread_kill(waiter_.native_handle(), SIGUSR2);
    waiter_.join();
  }
  SignalStop(const SignalStop&) = delete;
  SignalStop& operator=(const SignalStop&) = delete;

  [[nodiscard]] std::stop_token token() const { return source_.get_token(); }

 private:
  sigset_t signals_{};
  std::stop_source source_;
  std::thread waiter_;
};

int PrintDevices(const std::string& name, const DeviceLister& list) {
  const Result<std::string> devices = list();
  if (!devices) return Fail(name, devices.error());
  std::fputs(devices->c_str(), stdout);
  return 0;
}

}  // namespace

LiveBus::Options ReadBusOptions(ConfigReader& config) {
  LiveBus::Options options;
  ConfigReader::Table table = config.Root().Sub("bus");
  table.Read("url", &options.url);
  table.Read("receive_buffer_bytes", &options.receive_buffer_bytes, 4096, 1 << 30);
  table.Read("min_receive_buffer_bytes", &options.min_receive_buffer_bytes, 0, 1 << 30);
  options.version = VANTAGE_VERSION;
  options.config_hash = config.Hash();
  return options;
}

void IgnoreTablesOfOthers(ConfigReader& config) {
  ConfigReader::Table root = config.Root();
  for (const char* table : {"bus",
                            "camera",
                            "models",
                            "segmentation",
                            "ppf",
                            "shot",
                            "verification",
                            "refinement",
                            "fusion",
                            "confusion",
                            "planner",
                            "extrinsics",
                            "sim",
                            "up"}) {
    if (!root.WasAsked(table)) root.Sub(table).IgnoreAll();
  }
}

int RunProcess(int argc,
               char** argv,
               const std::string& default_name,
               const std::string& description,
               const NodeFactory& make_node,
               const DeviceLister& list) {
  ProcessOptions options;
  options.name = default_name;
  std::string config_file;
  std::string url;
  CLI::App app(description, "vantage-" + default_name);
  app.set_version_flag("--version", VANTAGE_VERSION);
  CLI::Option* config_option =
      app.add_option("--config,-c", config_file, "TOML file of the set-up");
  bool wants_list = false;
  if (list) app.add_flag("--list", wants_list, "print the devices there are, and end");
  app.add_option("--lcm-url", url, "LCM URL; default: [bus] url, then LCM_DEFAULT_URL");
  app.add_option("--name", options.name, "name of this process, unique on the bus")
      ->capture_default_str();
  app.add_flag("--fresh", options.fresh, "start anew, forgetting a saved state");
  if (const std::optional<int> code = ParseCommandLine(app, argc, argv)) return *code;
  if (wants_list) return PrintDevices(options.name, list);
  if (config_option->empty()) {
    const std::string program = app.get_name();
    return Fail(program,
                {ErrorCode::kInvalidArgument,
                 Format("--config is required; see %s --help", program.c_str())});
  }

  Result<ConfigReader> config = ConfigReader::Open(config_file);
  if (!config) return Fail(options.name, config.error());
  LiveBus::Options bus_options = ReadBusOptions(*config);
  bus_options.name = options.name;
  if (!url.empty()) bus_options.url = url;

  const Result<std::unique_ptr<ProcessNameLock>> lock =
      ProcessNameLock::Acquire(options.name, bus_options.url);
  if (!lock) return Fail(options.name, lock.error());

  const SignalStop stop;
  Result<std::unique_ptr<LiveBus>> bus = LiveBus::Create(bus_options);
  if (!bus) return Fail(options.name, bus.error());

  Result<std::unique_ptr<Node>> node = make_node(**bus, *config, options);
  if (!node) return Fail(options.name, node.error());
  if (Result<void> read = config->Finish(); !read) return Fail(options.name, read.error());
  PrintStart(options.name, config_file, *config, (*bus)->url());
  (*bus)->Run(
      stop.token(), [&node] { (*node)->Poll(); }, (*node)->poll_interval());
  return 0;
}

}  // namespace vantage
