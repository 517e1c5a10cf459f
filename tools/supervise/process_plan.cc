#include "tools/supervise/process_plan.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <system_error>

#include "common/format.h"
#include "nodes/process.h"
#include "tools/supervise/config_check.h"
#include "tools/supervise/program_search.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

std::string Lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

// One of our processes as it is started by hand; its name is the program's unless it is told.
PlannedProcess Ours(const std::string& name, UpStage stage, const std::string& program) {
  PlannedProcess process;
  process.name = name;
  process.stage = stage;
  process.command = {program};
  if (program != "vantage-" + name) {
    process.command.emplace_back("--name");
    process.command.push_back(name);
  }
  return process;
}

// A process for each camera; one that is the only one of its driver has the driver's name.
// `simulated`: the camera of [sim], whose device lives in its driver's process.
std::vector<PlannedProcess> CameraProcesses(ConfigReader::Table cameras,
                                            const fs::path& config,
                                            const fs::path& programs,
                                            const std::optional<std::string>& simulated) {
  std::map<std::string, std::vector<std::string>> cameras_of;
  for (const std::string& name : cameras.Keys()) {
    std::string driver = "openni2";
    cameras.Sub(name).ReadChoice("driver", &driver, {"openni2", "v4l2"});
    cameras_of[driver].push_back(name);
  }
  std::vector<PlannedProcess> processes;
  for (const auto& [driver, names] : cameras_of) {
    for (const std::string& name : names) {
      const std::string process = names.size() == 1 ? driver : driver + "-" + Lower(name);
      processes.push_back(Ours(process, UpStage::kCamera, "vantage-" + driver));
      if (driver == "openni2" && simulated == name) {
        processes.back().environment = {
            {"LD_LIBRARY_PATH", (programs.parent_path() / "openni2").string()},
            {"VANTAGE_SIM_CONFIG", config.string()}};
      }
    }
  }
  return processes;
}

// What the tables imply; errors are kept by `config`.
std::vector<PlannedProcess> ImpliedProcesses(ConfigReader& config,
                                             const fs::path& file,
                                             const fs::path& programs) {
  ConfigReader::Table root = config.Root();
  std::vector<PlannedProcess> processes;
  std::optional<std::string> simulated;
  if (root.Has("sim")) {
    simulated = "XTION";
    root.Sub("sim").Read("camera", &*simulated);
    processes.push_back(Ours("sim-arm", UpStage::kRobot, "vantage-sim-arm"));
  }
  for (PlannedProcess& camera : CameraProcesses(root.Sub("camera"), file, programs, simulated)) {
    processes.push_back(std::move(camera));
  }
  const auto add = [&](const char* table, UpStage stage) {
    if (root.Has(table)) processes.push_back(Ours(table, stage, std::string("vantage-") + table));
  };
  add("extrinsics", UpStage::kExtrinsics);
  add("ppf", UpStage::kEstimator);
  add("shot", UpStage::kEstimator);
  add("fusion", UpStage::kFusion);
  for (PlannedProcess& process : processes) {
    process.command.emplace_back("--config");
    process.command.push_back(file.string());
  }
  return processes;
}

PlannedProcess Recorder(const fs::path& file, const fs::path& folder) {
  PlannedProcess recorder;
  recorder.name = "recorder";
  recorder.stage = UpStage::kRecorder;
  recorder.command = {
      "vantage-log", "record", "--config", file.string(), "--folder", folder.string()};
  return recorder;
}

// What [[up.process]] says about a process that is implied, or about one of the user's.
Result<void> Apply(const UpProcess& wish, std::vector<PlannedProcess>* processes) {
  auto found = std::ranges::find(*processes, wish.name, &PlannedProcess::name);
  if (found == processes->end()) {
    if (!wish.start) return {};
    if (wish.command.empty()) {
      std::string known;
      for (const PlannedProcess& process : *processes) known += " " + process.name;
      return Error{
          ErrorCode::kInvalidArgument,
          Format("[[up.process]] name = \"%s\" is none of the set-up's processes (%s ) and "
                 "has no command; expected one of these, or a command",
                 wish.name.c_str(),
                 known.c_str())};
    }
    processes->push_back({wish.name, UpStage::kRobot, {}, {}, 0});
    found = std::prev(processes->end());
  }
  if (!wish.start) {
    processes->erase(found);
    return {};
  }
  if (!wish.command.empty()) {
    found->command = wish.command;
    found->environment.clear();
  }
  found->command.insert(found->command.end(), wish.arguments.begin(), wish.arguments.end());
  found->nice = wish.nice;
  return {};
}

// The program's absolute path in place of its name. One with a '/' starts at the config's folder.
Result<void> Resolve(const fs::path& programs, const fs::path& folder, PlannedProcess* process) {
  std::string& program = process->command.front();
  std::optional<fs::path> found;
  if (program.find('/') != std::string::npos) {
    found = ExecutableFile(folder / program);
  } else {
    found = ExecutableFile(programs / program);
    if (!found) found = FindProgram(program);
  }
  if (!found) {
    return Error{
        ErrorCode::kNotFound,
        Format("the program %s of process %s is not there or can't be executed; looked in "
               "%s",
               program.c_str(),
               process->name.c_str(),
               program.find('/') != std::string::npos ? folder.c_str()
                                                      : (programs.string() + " and PATH").c_str())};
  }
  program = found->string();
  return {};
}

bool HasControlCharacters(const std::string& text) {
  return std::ranges::any_of(text, [](unsigned char c) { return std::iscntrl(c) != 0; });
}

Result<void> CheckTexts(const PlannedProcess& process) {
  for (const std::string& text : process.command) {
    if (!HasControlCharacters(text)) continue;
    return Error{
        ErrorCode::kInvalidArgument,
        Format("process %s has an argument with a line break or another control character, "
               "expected none",
               process.name.c_str())};
  }
  return {};
}

}  // namespace

Result<ProcessPlan> MakeProcessPlan(const fs::path& config, const fs::path& programs) {
  Result<ConfigReader> reader = ConfigReader::Open(config);
  if (!reader) return reader.error();
  ProcessPlan plan;
  plan.config = fs::weakly_canonical(fs::absolute(config));
  plan.up = ReadUpConfig(*reader);
  plan.processes = ImpliedProcesses(*reader, plan.config, programs);
  IgnoreTablesOfOthers(*reader);
  for (const char* table : {"camera", "sim"}) reader->Root().Sub(table).IgnoreAll();
  if (Result<void> read = reader->Finish(); !read) return read.error();
  if (!plan.up.record.empty()) plan.processes.push_back(Recorder(plan.config, plan.up.record));
  for (const UpProcess& wish : plan.up.processes) {
    if (Result<void> applied = Apply(wish, &plan.processes); !applied) return applied.error();
  }
  if (plan.processes.empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("config file %s asks for no process, expected a table such as "
                        "[camera.<NAME>], [ppf], [fusion] or [[up.process]]",
                        config.c_str())};
  }
  std::ranges::stable_sort(plan.processes, {}, &PlannedProcess::stage);
  for (PlannedProcess& process : plan.processes) {
    const std::string program = process.command.front();
    if (Result<void> sound = CheckConfigFor(program, process.name, config); !sound) {
      return sound.error();
    }
    if (Result<void> sound = CheckTexts(process); !sound) return sound.error();
    if (Result<void> there = Resolve(programs, plan.config.parent_path(), &process); !there) {
      return there.error();
    }
  }
  return plan;
}

}  // namespace vantage
