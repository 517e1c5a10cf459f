#include "tools/monitor/system_view.h"

#include <fcntl.h>
#include <grp.h>
#include <net/if.h>
#include <pwd.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/timex.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cinttypes>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <system_error>
#include <thread>

#include "common/format.h"
#include "drivers/openni2/openni2_api.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;
using Steady = std::chrono::steady_clock;
using Wall = std::chrono::system_clock;

constexpr size_t kMostOutput = 64U << 10U;
constexpr size_t kMostOfFile = 1U << 20U;

std::string ReadUpTo(int descriptor, size_t most) {
  std::string text;
  std::array<char, 4096> buffer{};
  while (true) {
    const ssize_t got = read(descriptor, buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return text;
    if (text.size() < most) text.append(buffer.data(), static_cast<size_t>(got));
  }
}

SystemView::CommandOutput RunCommand(const std::vector<std::string>& command) {
  constexpr int kNotThere = 127;
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return {};
  std::vector<char*> arguments;
  for (const std::string& each : command) arguments.push_back(const_cast<char*>(each.c_str()));
  arguments.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    dup2(ends[1], STDOUT_FILENO);
    dup2(ends[1], STDERR_FILENO);
    const int nothing = open("/dev/null", O_RDONLY);
    dup2(nothing, STDIN_FILENO);
    execvp(arguments[0], arguments.data());
    _exit(kNotThere);
  }
  close(ends[1]);
  SystemView::CommandOutput output;
  if (child > 0) {
    output.text = ReadUpTo(ends[0], kMostOutput);
    int status = 0;
    waitpid(child, &status, 0);
    output.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    output.started = output.exit_code != kNotThere;
  }
  close(ends[0]);
  return output;
}

unsigned InterfaceFlags(const std::string& name) {
  const int any = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (any < 0) return 0;
  ifreq request{};
  std::strncpy(request.ifr_name, name.c_str(), sizeof request.ifr_name - 1);
  const bool known = ioctl(any, SIOCGIFFLAGS, &request) == 0;
  close(any);
  return known ? static_cast<unsigned>(static_cast<uint16_t>(request.ifr_flags)) : 0;
}

int Access(const fs::path& path) { return eaccess(path.c_str(), R_OK | W_OK) == 0 ? 0 : errno; }

std::string GroupOf(const fs::path& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return {};
  const group* found = getgrgid(status.st_gid);
  return found != nullptr ? found->gr_name : std::to_string(status.st_gid);
}

std::optional<uint64_t> Limit(int resource) {
  rlimit limit{};
  if (getrlimit(static_cast<__rlimit_resource>(resource), &limit) != 0) return std::nullopt;
  if (limit.rlim_cur == RLIM_INFINITY) return std::nullopt;
  return limit.rlim_cur;
}

std::optional<double> FreeBytes(const fs::path& path) {
  std::error_code error;
  const fs::space_info space = fs::space(path, error);
  if (error) return std::nullopt;
  return static_cast<double>(space.available);
}

int64_t WallUtime() {
  return std::chrono::duration_cast<std::chrono::microseconds>(Wall::now().time_since_epoch())
      .count();
}

SystemView::ClockState Clock() {
  timex state{};
  SystemView::ClockState clock;
  clock.is_known = adjtimex(&state) >= 0;
  clock.is_synchronized = (state.status & STA_UNSYNC) == 0;
  clock.utime = WallUtime();
  return clock;
}

SystemView::Stalls MeasureStalls() {
  constexpr auto kSleep = std::chrono::milliseconds(1);
  const auto start = Steady::now();
  const auto wall_start = Wall::now();
  SystemView::Stalls stalls;
  while (Steady::now() - start < std::chrono::seconds(1)) {
    const auto before = Steady::now();
    std::this_thread::sleep_for(kSleep);
    const std::chrono::duration<double> late = Steady::now() - before - kSleep;
    stalls.longest = std::max(stalls.longest, late.count());
  }
  const std::chrono::duration<double> steady = Steady::now() - start;
  const std::chrono::duration<double> wall = Wall::now() - wall_start;
  stalls.clock_step = wall.count() - steady.count();
  return stalls;
}

Result<std::vector<DeviceListing>> Openni2Devices() {
  Result<std::unique_ptr<Openni2Api>> api = Openni2Api::Create();
  if (!api) return api.error();
  return (*api)->List();
}

std::string UserName() {
  const passwd* user = getpwuid(geteuid());
  return user != nullptr ? user->pw_name : "$USER";
}

}  // namespace

SystemView SystemView::Real() {
  SystemView view;
  view.user = UserName();
  view.is_root = geteuid() == 0;
  view.run = RunCommand;
  view.environment = [](const std::string& name) -> std::string {
    const char* value = std::getenv(name.c_str());
    return value != nullptr ? value : "";
  };
  view.interface_flags = InterfaceFlags;
  view.access = Access;
  view.group_of = GroupOf;
  view.limit = Limit;
  view.free_bytes = FreeBytes;
  view.clock = Clock;
  view.measure_stalls = MeasureStalls;
  view.openni2_devices = Openni2Devices;
  return view;
}

std::optional<std::string> SystemView::Read(const std::string& path) const {
  std::ifstream stream(root / path);
  if (!stream) return std::nullopt;
  std::string text(kMostOfFile, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad() || (stream.gcount() == 0 && !stream.eof())) return std::nullopt;
  text.resize(static_cast<size_t>(stream.gcount()));
  return text;
}

std::string SystemView::ReadLine(const std::string& path) const {
  const std::string text = Read(path).value_or("");
  return text.substr(0, text.find('\n'));
}

std::vector<std::string> SystemView::List(const std::string& path) const {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator at(root / path, error), end; !error && at != end;
       at.increment(error)) {
    names.push_back(at->path().filename().string());
  }
  std::ranges::sort(names);
  return names;
}

std::string SystemView::AsRoot(const std::string& command) const {
  if (is_root) return command;
  const bool is_plain = command.find_first_of(";|>&$*") == std::string::npos;
  return is_plain ? "sudo " + command : "sudo sh -c '" + command + "'";
}

std::string SystemView::SetSysctl(const std::string& key, int64_t value) const {
  const std::string setting = Format("%s=%" PRId64, key.c_str(), value);
  const std::string name = key.substr(key.rfind('.') + 1);
  return AsRoot("sysctl -w " + setting + "; echo " + setting + " >/etc/sysctl.d/60-vantage-" +
                name + ".conf");
}

}  // namespace vantage
