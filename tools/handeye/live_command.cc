#include "tools/handeye/live_command.h"

#include <chrono>
#include <cstdio>
#include <memory>

#include "bus/live_bus.h"
#include "nodes/handeye_file.h"
#include "nodes/process.h"
#include "nodes/sim_config.h"
#include "tools/handeye/live_calibration.h"

namespace vantage {
namespace {

constexpr int kNotGood = 1;
constexpr int kBadInput = 2;

int Fail(const std::string& message) {
  std::fprintf(stderr, "vantage-handeye: %s\n", message.c_str());
  return kBadInput;
}

/// Both of one file: its hand-eye where it has a simulation of a hand.
struct Setup {
  ExtrinsicsConfig extrinsics;
  std::optional<Pose> truth;  ///< T_hand_camera
  LiveBus::Options bus;
};

Result<Setup> ReadSetup(const LiveArguments& arguments) {
  Result<ConfigReader> config = ConfigReader::Open(arguments.config);
  if (!config) return config.error();
  Setup setup;
  setup.bus = ReadBusOptions(*config);
  setup.bus.name = "handeye";
  if (!arguments.url.empty()) setup.bus.url = arguments.url;
  Result<ExtrinsicsConfig> extrinsics = ReadExtrinsicsConfig(*config);
  std::optional<Result<SimConfig>> sim;
  if (config->Root().Has("sim")) sim = ReadSimConfig(*config);
  IgnoreTablesOfOthers(*config);
  if (Result<void> sound = config->Finish(); !sound) return sound.error();
  if (!extrinsics) return extrinsics.error();
  if (sim && !*sim) return sim->error();
  setup.extrinsics = std::move(extrinsics).value();
  if (sim && (*sim)->hand) setup.truth = (*sim)->hand->T_hand_camera;
  return setup;
}

/// Prints how far the result is from the truth; false when that is more than was asked for.
bool IsNearTruth(const Pose& T_x, const Pose& truth, const LiveArguments& arguments) {
  const double millimetres = 1e3 * (T_x.translation() - truth.translation()).norm();
  const double degrees =
      GeodesicAngle(Eigen::Quaterniond(T_x.linear()), Eigen::Quaterniond(truth.linear())) / kDegree;
  std::printf("error against the simulation's truth: %.3f mm, %.4f deg\n", millimetres, degrees);
  return millimetres <= arguments.max_error_mm.value_or(millimetres) &&
         degrees <= arguments.max_error_deg.value_or(degrees);
}

}  // namespace

int RunLive(const LiveArguments& arguments) {
  Result<Setup> setup = ReadSetup(arguments);
  if (!setup) return Fail(setup.error().message);
  const ExtrinsicsConfig& config = setup->extrinsics;
  Result<std::unique_ptr<LiveBus>> bus = LiveBus::Create(setup->bus);
  if (!bus) return Fail(bus.error().message);
  Result<std::unique_ptr<LiveCalibration>> live = LiveCalibration::Create(**bus, config);
  if (!live) return Fail(live.error().message);
  std::string told;
  while (!(*live)->finished()) {
    (*bus)->Dispatch(std::chrono::milliseconds(50));
    (*live)->Poll();
    if ((*live)->remark() != told) {
      told = (*live)->remark();
      (*bus)->SetState(told);
    }
  }
  const std::optional<HandEyeResult>& result = (*live)->result();
  std::printf("ended: %s\n", (*live)->remark().c_str());
  if (!result) return Fail("no calibration: " + (*live)->remark());
  if (!result->observability.is_sufficient) {
    std::printf("not written: %s\n", result->observability.reason.c_str());
    return kNotGood;
  }
  const HandEyeFile calibration = MakeHandEyeFile(*result, config.camera, (*live)->last_utime());
  if (Result<void> written = WriteHandEyeFile(calibration, config.calibration); !written) {
    return Fail(written.error().message);
  }
  std::printf("written: %s, known to %.3f mm and %.4f deg (95 %%)\n",
              config.calibration.c_str(),
              1e3 * (*live)->translation_bound(),
              (*live)->rotation_bound() / kDegree);
  if (!setup->truth) return 0;
  return IsNearTruth(result->T_x, *setup->truth, arguments) ? 0 : kNotGood;
}

}  // namespace vantage
