#include "tools/monitor/expected_setup.h"

#include <algorithm>
#include <array>

#include "nodes/config_reader.h"
#include "tools/supervise/process_plan.h"

namespace vantage {
namespace {

// Others, such as a recorder of the user's, need not speak on the bus.
bool Speaks(const PlannedProcess& process) {
  constexpr std::array<const char*, 7> kPrograms = {"vantage-openni2",
                                                    "vantage-v4l2",
                                                    "vantage-sim-arm",
                                                    "vantage-extrinsics",
                                                    "vantage-ppf",
                                                    "vantage-shot",
                                                    "vantage-fusion"};
  const std::string program = std::filesystem::path(process.command.front()).filename().string();
  return std::ranges::find(kPrograms, program) != kPrograms.end();
}

}  // namespace

Result<ExpectedSetup> ReadExpectedSetup(const std::filesystem::path& config) {
  const std::filesystem::path programs =
      std::filesystem::read_symlink("/proc/self/exe").parent_path();
  Result<ProcessPlan> plan = MakeProcessPlan(config, programs);
  if (!plan) return plan.error();
  ExpectedSetup expected;
  for (const PlannedProcess& process : plan->processes) {
    if (Speaks(process)) expected.processes.push_back(process.name);
  }
  Result<ConfigReader> reader = ConfigReader::Open(config);
  if (!reader) return reader.error();
  expected.cameras = reader->Root().Sub("camera").Keys();
  expected.config_hash = reader->Hash();
  return expected;
}

}  // namespace vantage
