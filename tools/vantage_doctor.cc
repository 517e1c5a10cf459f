// vantage-doctor: what keeps a set-up from running well on this machine, and the commands that mend
// it.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>

#include "nodes/command_line.h"
#include "tools/monitor/doctor.h"

int main(int argc, char** argv) {
  using namespace vantage;
  DoctorRequest request;
  std::string config;
  bool as_json = false;
  CLI::App app("Tells what keeps a set-up from running well, and the commands that mend it.",
               "vantage-doctor");
  app.set_version_flag("--version", VANTAGE_VERSION);
  app.add_option("--config,-c", config, "TOML file of the set-up; without: the machine alone");
  app.add_option("--lcm-url", request.url, "LCM URL; default: [bus] url, then LCM_DEFAULT_URL");
  app.add_flag("--json", as_json, "print JSON");
  if (const std::optional<int> code = ParseCommandLine(app, argc, argv)) return *code;
  request.config = config;
  request.programs = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  const Result<DoctorFindings> findings = Diagnose(SystemView::Real(), request);
  if (!findings) {
    std::fprintf(stderr, "vantage-doctor: %s\n", findings.error().message.c_str());
    return 2;
  }
  std::fputs((as_json ? DoctorJson(*findings) : DoctorText(*findings)).c_str(), stdout);
  return ExitCodeOf(*findings);
}
