#include "tools/supervise/config_check.h"

#include <functional>
#include <map>

#include "bus/lcm_url.h"
#include "nodes/extrinsics_config.h"
#include "nodes/fusion_config.h"
#include "nodes/handeye_file.h"
#include "nodes/openni2_config.h"
#include "nodes/ppf_config.h"
#include "nodes/process.h"
#include "nodes/shot_config.h"
#include "nodes/sim_config.h"
#include "nodes/v4l2_config.h"

namespace vantage {
namespace {

using Check = std::function<Result<void>(ConfigReader& config, const std::string& name)>;

// The file's own errors first, as processes tell them.
template <class T>
Result<void> Finished(ConfigReader& config, const Result<T>& read) {
  IgnoreTablesOfOthers(config);
  if (Result<void> finished = config.Finish(); !finished) return finished;
  if (!read) return read.error();
  return {};
}

// Drivers tell first that there is no camera for them.
template <class T>
Result<void> FinishedCamera(ConfigReader& config, const Result<T>& read) {
  return read ? Finished(config, read) : Result<void>(read.error());
}

Result<void> CheckExtrinsics(ConfigReader& config) {
  const Result<ExtrinsicsConfig> read = ReadExtrinsicsConfig(config);
  if (Result<void> finished = Finished(config, read); !finished) return finished;
  const Result<HandEyeFile> calibration = ReadHandEyeFile(read->calibration);
  if (calibration) return {};
  return Error{calibration.error().code,
               calibration.error().message + "; vantage-handeye makes one"};
}

const std::map<std::string, Check>& Checks() {
  static const std::map<std::string, Check> checks = {
      {"vantage-openni2",
       [](ConfigReader& config, const std::string& name) {
         return FinishedCamera(config, ReadOpenni2Config(config, name));
       }},
      {"vantage-v4l2",
       [](ConfigReader& config, const std::string& name) {
         return FinishedCamera(config, ReadV4l2Config(config, name));
       }},
      {"vantage-ppf",
       [](ConfigReader& config, const std::string&) {
         return Finished(config, ReadPpfConfig(config));
       }},
      {"vantage-shot",
       [](ConfigReader& config, const std::string&) {
         return Finished(config, ReadShotConfig(config));
       }},
      {"vantage-fusion",
       [](ConfigReader& config, const std::string&) {
         return Finished(config, ReadFusionConfig(config));
       }},
      {"vantage-extrinsics",
       [](ConfigReader& config, const std::string&) { return CheckExtrinsics(config); }},
      {"vantage-sim-arm",
       [](ConfigReader& config, const std::string&) {
         return Finished(config, ReadSimConfig(config));
       }},
  };
  return checks;
}

}  // namespace

Result<void> CheckConfigFor(const std::string& program,
                            const std::string& name,
                            const std::filesystem::path& file) {
  const auto check = Checks().find(program);
  if (check == Checks().end()) return {};
  Result<ConfigReader> config = ConfigReader::Open(file);
  if (!config) return config.error();
  const LiveBus::Options bus = ReadBusOptions(*config);
  if (Result<void> sound = check->second(*config, name); !sound) return sound;
  if (const Result<LcmUrl> url = LcmUrl::ParseOrDefault(bus.url); !url) return url.error();
  return {};
}

}  // namespace vantage
