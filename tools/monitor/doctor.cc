#include "tools/monitor/doctor.h"

#include <optional>
#include <utility>
#include <vector>

#include "bus/lcm_url.h"
#include "common/format.h"
#include "nodes/config_reader.h"
#include "nodes/process.h"
#include "nodes/up_config.h"
#include "tools/monitor/bus_probe.h"
#include "tools/monitor/doctor_devices.h"
#include "tools/monitor/doctor_host.h"
#include "tools/monitor/doctor_network.h"
#include "tools/monitor/doctor_setup.h"
#include "tools/monitor/expected_setup.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

void Append(DoctorFindings more, DoctorFindings* findings) {
  for (DoctorFinding& each : more) findings->push_back(std::move(each));
}

// What the configuration says of the bus, as far as it can be read: what is wrong in it has a line
// of its own.
LiveBus::Options BusOptions(const DoctorRequest& request, fs::path* recordings) {
  LiveBus::Options options;
  *recordings = fs::current_path();
  if (!request.config.empty()) {
    Result<ConfigReader> config = ConfigReader::Open(request.config);
    if (config) {
      options = ReadBusOptions(*config);
      const UpConfig up = ReadUpConfig(*config);
      if (!up.record.empty()) *recordings = up.record;
    }
  }
  options.version = VANTAGE_VERSION;
  if (!request.url.empty()) options.url = request.url;
  return options;
}

void CheckNetwork(const SystemView& system,
                  const LiveBus::Options& options,
                  const LcmUrl& url,
                  const std::vector<std::string>& expected,
                  DoctorFindings* findings) {
  findings->push_back(CheckMulticastRoute(system, url));
  findings->push_back(CheckPort(system, url));
  const BusProbe probe = ProbeBus(options, expected);
  findings->push_back(CheckRoundTrip(probe));
  findings->push_back(CheckReceiveBuffer(system, probe));
  findings->push_back(
      CheckLargestBuffer(system, probe.error ? options.receive_buffer_bytes : probe.requested));
  findings->push_back(CheckDefaultBuffer(system));
  Append(CheckProcessNames(system, probe, expected), findings);
}

void CheckHost(const SystemView& system, const fs::path& recordings, DoctorFindings* findings) {
  const SystemView::Stalls stalls = system.measure_stalls();
  Append({CheckClockSynchronized(system),
          CheckClockYear(system),
          CheckClockSource(system),
          CheckClockStep(system, stalls),
          CheckStalls(stalls),
          CheckLoad(system),
          CheckGovernor(system),
          CheckRealTimePriority(system),
          CheckLockedMemory(system),
          CheckDisk(system, recordings)},
         findings);
}

}  // namespace

Result<DoctorFindings> Diagnose(const SystemView& system, const DoctorRequest& request) {
  std::error_code error;
  if (!request.config.empty() && !fs::is_regular_file(request.config, error)) {
    return Error{
        ErrorCode::kNotFound,
        Format("config file %s is not there, expected a TOML file", request.config.c_str())};
  }
  fs::path recordings;
  const LiveBus::Options options = BusOptions(request, &recordings);
  const Result<LcmUrl> url = LcmUrl::ParseOrDefault(options.url);
  if (!url) return url.error();
  DoctorFindings findings;
  std::vector<std::string> expected;
  std::vector<WantedCamera> cameras;
  if (!request.config.empty()) {
    findings.push_back(CheckConfig(request.config, request.programs));
    if (const Result<ExpectedSetup> setup = ReadExpectedSetup(request.config)) {
      expected = setup->processes;
    }
    cameras = ReadWantedCameras(request.config);
  }
  CheckNetwork(system, options, *url, expected, &findings);
  Append(CheckWantedCameras(system, cameras), &findings);
  Append(CheckVideoNodes(system), &findings);
  Append(CheckUsbCameras(system, cameras), &findings);
  if (!request.config.empty()) {
    Append(CheckModels(request.config), &findings);
    Append(CheckExtrinsics(request.config, system.clock().utime), &findings);
  }
  CheckHost(system, recordings, &findings);
  findings.push_back(CheckSupervisor(system));
  findings.push_back(CheckJava(system));
  Append(CheckJars(system, request.programs), &findings);
  findings.push_back(CheckDisplay(system));
  findings.push_back(CheckGraphics(system));
  return findings;
}

}  // namespace vantage
