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
/// What one file tells.
struct Setup {
  ExtrinsicsConfig extrinsics;
  std::optional<Pose> truth;  ///< T_hand_camera of a simulated hand
  LiveBus::Options bus;
};

Result<Setup> ReadSetup(const std::string& file, const std::string& url) {
  Result<ConfigReader> config = ConfigReader::Open(file);
  if (!config) return config.error();
  Setup setup;
  setup.bus = ReadBusOptions(*config);
  setup.bus.name = "handeye";
  if (!url.empty()) setup.bus.url = url;
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

}  // namespace

LiveCommand::LiveCommand(CLI::App* app)
    : command_(app->add_subcommand(
          "live", "Calibrates with the robot on the bus, which moves itself before the target")) {
  command_->add_option("--config,-c", config_, "TOML file of the set-up, with [extrinsics]")
      ->required();
  command_->add_option("--lcm-url", url_, "LCM URL; default: [bus] url, then LCM_DEFAULT_URL");
  command_->add_option("--max-error-mm",
                       max_error_mm_,
                       "simulated set-ups: exit with 1 if the truth is farther off");
  command_->add_option("--max-error-deg", max_error_deg_, "the same for the rotation");
}

Result<int> LiveCommand::Run() const {
  Result<Setup> setup = ReadSetup(config_, url_);
  if (!setup) return setup.error();
  const ExtrinsicsConfig& config = setup->extrinsics;
  Result<std::unique_ptr<LiveBus>> bus = LiveBus::Create(setup->bus);
  if (!bus) return bus.error();
  Result<std::unique_ptr<LiveCalibration>> live = LiveCalibration::Create(**bus, config);
  if (!live) return live.error();
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
  if (!result) return Error{ErrorCode::kUnavailable, "no calibration: " + (*live)->remark()};
  if (!result->observability.is_sufficient) {
    std::printf("not written: %s\n", result->observability.reason.c_str());
    return kNotGood;
  }
  const HandEyeFile calibration = MakeHandEyeFile(*result, config.camera, (*live)->last_utime());
  if (Result<void> written = WriteHandEyeFile(calibration, config.calibration); !written) {
    return written.error();
  }
  std::printf("written: %s, known to %.3f mm and %.4f deg (95 %%)\n",
              config.calibration.c_str(),
              1e3 * (*live)->translation_bound(),
              (*live)->rotation_bound() / kDegree);
  if (!setup->truth) return 0;
  const double millimetres = 1e3 * (result->T_x.translation() - setup->truth->translation()).norm();
  const double degrees = GeodesicAngle(Eigen::Quaterniond(result->T_x.linear()),
                                       Eigen::Quaterniond(setup->truth->linear())) /
                         kDegree;
  std::printf("error against the simulation's truth: %.3f mm, %.4f deg\n", millimetres, degrees);
  const bool is_near = millimetres <= max_error_mm_.value_or(millimetres) &&
                       degrees <= max_error_deg_.value_or(degrees);
  return is_near ? 0 : kNotGood;
}

}  // namespace vantage
