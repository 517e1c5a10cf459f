// The files that vantage-up makes, read by other programs: Python's configparser and shlex, as
// supervisord does it, and systemd's own checker.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/tools/run_program.h"
#include "tools/supervise/child_process.h"
#include "tools/supervise/program_search.h"
#include "tools/supervise/run_folder.h"
#include "tools/supervise/supervisor_config.h"
#include "tools/supervise/systemd_units.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

// What paths and arguments may have in them.
const std::vector<std::string>& OddTexts() {
  static const std::vector<std::string> texts = {"plain",
                                                 "with blank",
                                                 " at both ends ",
                                                 "",
                                                 "a ;b #c;d#e",
                                                 "; # begins",
                                                 "100% %s %(here)s %%",
                                                 "$HOME ${HOME} $$ `id` $(id)",
                                                 "'single' \"double\" \\back\\\\slash\\",
                                                 "a=b",
                                                 "-n",
                                                 "*?[a]{b,c}~!&|<>()^",
                                                 "Stra\u00dfe \u65e5\u672c"};
  return texts;
}

class SupervisedFilesTest : public ScratchTest {
 protected:
  // A plan of one process a stage; the first has all the odd arguments.
  ProcessPlan MakePlan() const {
    ProcessPlan plan;
    plan.config = scratch() / "odd ;%s $x 'q'" / "set up.toml";
    plan.up.start_s = 7;
    plan.up.log_files = 3;
    const auto add = [&plan](
                         const char* name, UpStage stage, const std::vector<std::string>& command) {
      plan.processes.push_back({name, stage, command, {}, 0});
    };
    std::vector<std::string> odd = OddTexts();
    odd.insert(odd.begin(), "/bin/true");
    add("recorder", UpStage::kRecorder, {"/bin/true", "record"});
    add("robot", UpStage::kRobot, odd);
    plan.processes.back().environment = {{"A", "x y"}, {"B", "%d;\"$'"}};
    plan.processes.back().nice = -5;
    add("camera", UpStage::kCamera, {"/bin/true"});
    add("ppf", UpStage::kEstimator, {"/bin/true"});
    add("fusion", UpStage::kFusion, {"/bin/true"});
    return plan;
  }
  RunFolder MakeRun(const ProcessPlan& plan) const {
    const Result<RunFolder> run =
        ChooseRunFolder(plan.config, scratch() / "r %u n;n", scratch() / "l");
    EXPECT_TRUE(run.ok());
    return *run;
  }

  // What a Python program says to a file, one text a NUL.
  std::vector<std::string> AskPython(const std::string& program, const std::string& text) const {
    std::ofstream(scratch() / "text") << text;
    const Result<ChildOutput> output =
        RunChild({FindProgram("python3")->string(), "-c", program, (scratch() / "text").string()});
    EXPECT_EQ(output->exit_code, 0) << output->text;
    std::vector<std::string> texts;
    std::istringstream stream(output->text);
    for (std::string each; std::getline(stream, each, '\0');) texts.push_back(each);
    return texts;
  }
};

// As supervisord 4.2.5 reads its file: options.py, UnhosedConfigParser and get_execv_args.
constexpr const char* kReader =
    "import configparser, shlex, sys\n"
    "p = configparser.RawConfigParser(inline_comment_prefixes=(';', '#'), strict=False)\n"
    "p.read_file(open(sys.argv[1], encoding='utf-8'))\n"
    "def get(s, k): return p.get(s, k) % {'here': 'HERE', 'program_name': 'NAME'}\n"
    "def tell(texts): sys.stdout.buffer.write(b''.join(t.encode() + b'\\0' for t in texts))\n";

TEST_F(SupervisedFilesTest, SupervisorSplitsCommandsIntoTheWordsThatWereMeant) {
  const ProcessPlan plan = MakePlan();
  const Result<std::string> config = SupervisorConfig(plan, MakeRun(plan));
  ASSERT_TRUE(config.ok()) << config.error().message;
  const std::vector<std::string> words = AskPython(
      std::string(kReader) + "tell(shlex.split(get('program:robot', 'command')))", *config);
  const std::vector<std::string> start = {FindProgram("setpriv")->string(),
                                          "--pdeathsig",
                                          "TERM",
                                          FindProgram("env")->string(),
                                          "-C",
                                          plan.config.parent_path().string(),
                                          "A=x y",
                                          "B=%d;\"$'",
                                          FindProgram("nice")->string(),
                                          "-n",
                                          "-5"};
  std::vector<std::string> expected = start;
  expected.insert(
      expected.end(), plan.processes[1].command.begin(), plan.processes[1].command.end());
  EXPECT_EQ(words, expected);
}

TEST_F(SupervisedFilesTest, EveryOddTextAloneSurvivesToo) {
  std::string file;
  std::vector<std::string> expected;
  for (const std::string& text : OddTexts()) {
    file += '[';
    file += std::to_string(expected.size()) + "]\ncommand=" + SupervisorCommand({"p", text, "q"});
    file += '\n';
    for (const std::string& word : {std::string("p"), text, std::string("q")})
      expected.push_back(word);
  }
  const std::vector<std::string> words = AskPython(
      std::string(kReader) + "for s in p.sections(): tell(shlex.split(get(s, 'command')))", file);
  EXPECT_EQ(words, expected) << file;
}

TEST_F(SupervisedFilesTest, PathsOfTheSupervisorsOwnAreThoseOfTheRunFolder) {
  const ProcessPlan plan = MakePlan();
  const RunFolder run = MakeRun(plan);
  const std::vector<std::string> values =
      AskPython(std::string(kReader) +
                    "tell([get('unix_http_server', 'file'), get('unix_http_server', 'chmod'),"
                    "get('supervisord', 'pidfile'), get('supervisorctl', 'serverurl'),"
                    "get('program:ppf', 'stdout_logfile'), get('program:ppf', 'startsecs'),"
                    "get('program:ppf', 'stdout_logfile_backups'), str('inet_http_server' in p)])",
                *SupervisorConfig(plan, run));
  EXPECT_EQ(values,
            (std::vector<std::string>{run.socket().string(),
                                      "0700",
                                      run.pid_file().string(),
                                      "unix://" + run.socket().string(),
                                      (run.log_link() / "ppf.log").string(),
                                      "7",
                                      "3",
                                      "False"}));
}

TEST_F(SupervisedFilesTest, PrioritiesFollowTheStagesAndOnlyARecorderMayEnd) {
  const ProcessPlan plan = MakePlan();
  const std::vector<std::string> values =
      AskPython(std::string(kReader) +
                    "names = ['recorder', 'robot', 'camera', 'ppf', 'fusion']\n"
                    "ranks = [int(get('program:' + n, 'priority')) for n in names]\n"
                    "tell([str(ranks == sorted(set(ranks)))] + [get('program:' + n, 'autorestart') "
                    "for n in names])",
                *SupervisorConfig(plan, MakeRun(plan)));
  EXPECT_EQ(values,
            (std::vector<std::string>{"True", "unexpected", "true", "true", "true", "true"}));
}

TEST_F(SupervisedFilesTest, SystemdFindsNoFaultInUnits) {
  const auto analyze = FindProgram("systemd-analyze");
  if (!analyze) GTEST_SKIP() << "systemd-analyze is not installed";
  ProcessPlan plan = MakePlan();
  fs::create_directories(plan.config.parent_path());
  // A program whose path must survive to be found.
  const fs::path program = plan.config.parent_path() / "pro gram";
  fs::copy_file("/bin/true", program);
  for (PlannedProcess& process : plan.processes) process.command.front() = program.string();
  const RunFolder run = MakeRun(plan);
  const fs::path folder = scratch() / "units";
  fs::create_directory(folder);
  std::vector<std::string> command = {analyze->string(), "--man=no", "verify"};
  for (const auto& [name, text] : SystemdUnits(plan, run)) {
    std::ofstream(folder / name) << text;
    command.push_back((folder / name).string());
  }
  ASSERT_EQ(command.size(), 3U + 6U);
  const Result<ChildOutput> output = RunChild(command);
  ASSERT_TRUE(output.ok());
  EXPECT_EQ(output->exit_code, 0) << output->text;
  EXPECT_EQ(output->text.find(folder.string()), std::string::npos) << output->text;
  // The checker does see what is wrong.
  std::ofstream(folder / fs::path(command.back()).filename(), std::ios::app) << "[Foo]\nBar=1\n";
  EXPECT_NE(RunChild(command)->text.find("Foo"), std::string::npos);
}

TEST_F(SupervisedFilesTest, SystemdStopsBackwards) {
  const ProcessPlan plan = MakePlan();
  const RunFolder run = MakeRun(plan);
  const auto units = SystemdUnits(plan, run);
  const auto unit = [&run](const std::string& name) {
    return "vantage-" + run.id + "-" + name + ".service";
  };
  EXPECT_EQ(units.at(unit("recorder")).find("\nAfter="), std::string::npos);
  const std::string& fusion = units.at(unit("fusion"));
  for (const char* name : {"recorder", "robot", "camera", "ppf"}) {
    EXPECT_NE(fusion.find(unit(name) + " "), std::string::npos) << name;
  }
  EXPECT_NE(fusion.find("\nStartLimitBurst=4\n"), std::string::npos);
  EXPECT_NE(fusion.find("\nRestart=always\n"), std::string::npos);
  EXPECT_NE(units.at(unit("recorder")).find("\nRestart=on-abnormal\n"), std::string::npos);
  EXPECT_NE(units.at(unit("robot")).find("\nNice=-5\n"), std::string::npos);
}

TEST(RunFolder, OfTwoConfigsAreApart) {
  const Result<RunFolder> a = ChooseRunFolder("/a/demo.toml", "", "");
  const Result<RunFolder> b = ChooseRunFolder("/b/demo.toml", "", "");
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_NE(a->folder, b->folder);
  EXPECT_TRUE(a->id.starts_with("demo-"));
}

}  // namespace
}  // namespace vantage
