// vantage-soak: sends depth frames of the simulated sensor from one process to another, as a camera
// driver and a listener do, and counts what is lost or altered on the way. tools/soak runs both.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "bus/image_conversion.h"
#include "bus/live_bus.h"
#include "bus/sequence_tracker.h"
#include "common/format.h"
#include "common/so3.h"
#include "common/statistics.h"
#include "drivers/sim/sim_camera.h"
#include "nodes/command_line.h"
#include "nodes/config_reader.h"
#include "nodes/sim_config.h"
#include "vantage/images_t.hpp"
#include "vantage/process_status_t.hpp"

namespace vantage {
namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kChannel = "CAMERA_SOAK";
constexpr const char* kReceiver = "soak-receive";
constexpr int kStockReceiveBuffer = 212'992;  // bytes, net.core.rmem_max of Linux as it comes
constexpr int kNumFrames = 32;                // different ones, sent in turn
constexpr std::chrono::seconds kReceiverWait(60);
constexpr std::chrono::seconds kSilence(10);

struct Arguments {
  std::string config;
  int64_t frames = 0;
  double rate_hz = 0.0;
};

struct Frame {
  int width = 0;   // px
  int height = 0;  // px
  std::vector<uint16_t> millimetres;
  DepthImage depth;  // m, as a listener has it
};

bool IsSame(const DepthImage& a, const DepthImage& b) {
  // By their bits: no measurement is always the same NaN.
  return a.width == b.width && a.height == b.height && a.depth.size() == b.depth.size() &&
         std::memcmp(a.depth.data(), b.depth.data(), a.depth.size() * sizeof a.depth[0]) == 0;
}

// What the set-up's sensor sees from places around its target. Both processes render the same.
Result<std::vector<Frame>> RenderFrames(ConfigReader& config) {
  Result<SimConfig> sim = LoadSimConfig(config);
  if (!sim) return sim.error();
  SimDeviceSetup setup;
  setup.camera = sim->camera;
  setup.scene = std::move(sim->scene);
  setup.sensor = sim->sensor;
  SimCamera camera(setup);
  std::vector<Frame> frames;
  for (int i = 0; i < kNumFrames; ++i) {
    const double azimuth = 360.0 * kDegree * i / kNumFrames;
    const double elevation = (40.0 + 20.0 * (i % 2)) * kDegree;
    const Eigen::Vector3d p_world_camera(0.75 * std::cos(elevation) * std::cos(azimuth),
                                         0.75 * std::cos(elevation) * std::sin(azimuth),
                                         0.75 * std::sin(elevation));
    camera.Expose(LookAt(p_world_camera, Eigen::Vector3d(0.0, 0.0, 0.04)), i, i / 30.0);
    Frame frame{setup.camera.width, setup.camera.height, camera.Depth(setup.camera.width), {}};
    const images_t plain = DepthToMessage(
        frame.width, frame.height, frame.millimetres, 1, 0, "", DepthCompression::kNone);
    Result<DepthFrame> decoded = DepthFrameFromMessage(plain);
    if (!decoded) return decoded.error();
    frame.depth = std::move(decoded->image);
    frames.push_back(std::move(frame));
  }
  return frames;
}

const Frame& FrameOf(const std::vector<Frame>& frames, int64_t seq) {
  return frames[static_cast<size_t>(seq) % frames.size()];
}

Result<std::unique_ptr<LiveBus>> OpenBus(const std::string& name) {
  LiveBus::Options options;
  options.name = name;
  options.version = VANTAGE_VERSION;
  options.receive_buffer_bytes = kStockReceiveBuffer;
  return LiveBus::Create(options);
}

Result<void> WaitForReceiver(LiveBus& bus) {
  bool heard = false;
  if (Result<void> subscribed =
          bus.Subscribe<process_status_t>("PROCESS_STATUS",
                                          {},
                                          [&](const Envelope&, const process_status_t& status) {
                                            heard = heard || status.name == kReceiver;
                                          });
      !subscribed) {
    return subscribed;
  }
  const Clock::time_point give_up = Clock::now() + kReceiverWait;
  while (!heard && Clock::now() < give_up) bus.Dispatch(std::chrono::milliseconds(100));
  if (heard) return {};
  return Error{ErrorCode::kUnavailable,
               Format("no PROCESS_STATUS of %s, expected one within %jd s",
                      kReceiver,
                      intmax_t{kReceiverWait.count()})};
}

Result<void> Send(const Arguments& arguments, const std::vector<Frame>& frames) {
  const Result<std::unique_ptr<LiveBus>> bus = OpenBus("soak-send");
  if (!bus) return bus.error();
  if (Result<void> there = WaitForReceiver(**bus); !there) return there;
  const auto period = std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(1.0 / arguments.rate_hz));
  Clock::time_point next = Clock::now();
  for (int64_t seq = 0; seq < arguments.frames; ++seq) {
    std::this_thread::sleep_until(next);
    // After a stall of the machine frames come no faster than before it, as from a camera.
    next = std::max(next + period, Clock::now());
    const Frame& frame = FrameOf(frames, seq);
    const images_t message = DepthToMessage(frame.width,
                                            frame.height,
                                            frame.millimetres,
                                            (*bus)->NowUtime(),
                                            seq,
                                            "SOAK",
                                            DepthCompression::kVdc);
    if (Result<void> sent = (*bus)->Publish(kChannel, message); !sent) return sent;
  }
  return {};
}

// What came, against what was sent.
class Receiver {
 public:
  Receiver(const std::vector<Frame>& frames, int64_t expected)
      : frames_(frames), expected_(expected) {}

  void OnFrame(const Envelope& envelope, const images_t& message);
  /// Until the last frame, or silence.
  void Run(LiveBus& bus);
  void Print(const process_status_t& status) const;
  [[nodiscard]] bool passed() const {
    return received_ == expected_ && lost_ == 0 && skipped_ == 0 && altered_ == 0;
  }

 private:
  const std::vector<Frame>& frames_;
  int64_t expected_;
  SequenceTracker sequence_;
  int64_t received_ = 0;
  int64_t lost_ = 0;     // By gaps in seq.
  int64_t skipped_ = 0;  // Arrived, but were let go before they were looked at.
  int64_t altered_ = 0;  // Other than what was sent, in a bit or more.
  int64_t last_seq_ = -1;
  int64_t bytes_ = 0;
  size_t most_bytes_ = 0;
  int64_t first_utime_ = 0;
  int64_t last_utime_ = 0;
  std::vector<double> latency_;  // s, from before the compression to arrival
  std::string first_fault_;
};

void Receiver::OnFrame(const Envelope& envelope, const images_t& message) {
  const size_t bytes = message.images.empty() ? 0 : message.images[0].data.size();
  const Result<DepthFrame> frame = DepthFrameFromMessage(message);
  ++received_;
  skipped_ += envelope.num_skipped;
  bytes_ += static_cast<int64_t>(bytes);
  most_bytes_ = std::max(most_bytes_, bytes);
  if (received_ == 1) first_utime_ = message.utime;
  last_utime_ = message.utime;
  latency_.push_back(1e-6 * static_cast<double>(envelope.receive_utime - message.utime));
  if (!frame || frame->seq < 0) {
    ++altered_;
    if (first_fault_.empty()) first_fault_ = frame ? "a frame without seq" : frame.error().message;
    return;
  }
  lost_ += sequence_.Add(kChannel, frame->seq, envelope.num_skipped);
  last_seq_ = frame->seq;
  if (IsSame(frame->image, FrameOf(frames_, frame->seq).depth)) return;
  ++altered_;
  if (first_fault_.empty()) first_fault_ = Format("frame %jd differs", intmax_t{frame->seq});
}

void Receiver::Run(LiveBus& bus) {
  Clock::time_point give_up = Clock::now() + kReceiverWait;
  while (last_seq_ + 1 < expected_ && Clock::now() < give_up) {
    if (bus.Dispatch(std::chrono::milliseconds(200))) give_up = Clock::now() + kSilence;
  }
}

void Receiver::Print(const process_status_t& status) const {
  const double seconds = 1e-6 * static_cast<double>(last_utime_ - first_utime_);
  const double count = static_cast<double>(std::max<int64_t>(received_, 1));
  std::printf("receive buffer: %d B granted of %d B asked for\n",
              status.receive_buffer_granted,
              status.receive_buffer_requested);
  std::printf("frames: %jd of %jd received, %jd missing in between, %jd let go, %jd altered%s%s\n",
              intmax_t{received_},
              intmax_t{expected_},
              intmax_t{lost_},
              intmax_t{skipped_},
              intmax_t{altered_},
              first_fault_.empty() ? "" : ": ",
              first_fault_.c_str());
  std::printf("pace: %.1f Hz over %.1f s; %.1f kB a frame, %.1f kB the largest\n",
              seconds > 0.0 ? (count - 1.0) / seconds : 0.0,
              seconds,
              1e-3 * static_cast<double>(bytes_) / count,
              1e-3 * static_cast<double>(most_bytes_));
  std::printf(
      "before compression to arrival: p50 %.2f ms, p99 %.2f ms, p99.9 %.2f ms, max %.2f ms\n",
      1e3 * Quantile(latency_, 0.5),
      1e3 * Quantile(latency_, 0.99),
      1e3 * Quantile(latency_, 0.999),
      1e3 * Quantile(latency_, 1.0));
}

/// @return whether every frame came as it was sent.
Result<bool> Receive(const Arguments& arguments, const std::vector<Frame>& frames) {
  const Result<std::unique_ptr<LiveBus>> bus = OpenBus(kReceiver);
  if (!bus) return bus.error();
  Receiver receiver(frames, arguments.frames);
  if (Result<void> subscribed =
          (*bus)->Subscribe<images_t>(kChannel,
                                      {},
                                      [&](const Envelope& envelope, const images_t& message) {
                                        receiver.OnFrame(envelope, message);
                                      });
      !subscribed) {
    return subscribed.error();
  }
  receiver.Run(**bus);
  receiver.Print((*bus)->Status());
  return receiver.passed();
}

int Run(int argc, char** argv) {
  CLI::App app("Sends depth frames to another process and counts what is lost or altered.",
               "vantage-soak");
  app.require_subcommand(1);
  Arguments arguments;
  CLI::App* send = app.add_subcommand("send", "send as soon as the receiver is there");
  CLI::App* receive = app.add_subcommand("receive", "check what comes; exit code 1: not all did");
  for (CLI::App* command : {send, receive}) {
    command->add_option("--config", arguments.config, "set-up whose [sim] gives the frames")
        ->required();
    command->add_option("--frames", arguments.frames, "how many")
        ->required()
        ->check(CLI::Range(int64_t{1}, int64_t{1'000'000'000}));
  }
  send->add_option("--rate", arguments.rate_hz, "Hz")->required()->check(CLI::Range(0.01, 1e4));
  if (const std::optional<int> code = ParseCommandLine(app, argc, argv)) return *code;

  const auto fail = [](const Error& error) {
    std::fprintf(stderr, "vantage-soak: %s\n", error.message.c_str());
    return 2;
  };
  Result<ConfigReader> config = ConfigReader::Open(arguments.config);
  if (!config) return fail(config.error());
  const Result<std::vector<Frame>> frames = RenderFrames(*config);
  if (!frames) return fail(frames.error());
  if (*send) {
    const Result<void> sent = Send(arguments, *frames);
    return sent ? 0 : fail(sent.error());
  }
  const Result<bool> passed = Receive(arguments, *frames);
  if (!passed) return fail(passed.error());
  return *passed ? 0 : 1;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) { return vantage::Run(argc, argv); }
