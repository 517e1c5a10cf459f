#include "tools/monitor/doctor_host.h"

#include <sys/resource.h>

#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstdlib>
#include <ctime>

#include "common/format.h"
#include "tools/monitor/shown_text.h"

namespace vantage {
namespace {

using Level = DoctorFinding::Level;

constexpr double kLateStall = 0.05;        // s; a camera's image comes every 0.033 s.
constexpr double kClockStep = 0.005;       // s
constexpr double kLittleSpace = 5e9;       // bytes: some hours of depth, minutes of color
constexpr double kNoSpace = 256e6;         // bytes
constexpr uint64_t kLockable = 8U << 20U;  // bytes, Debian's default
constexpr uint64_t kSomePriority = 10;
constexpr int kOldestJava = 11;

bool Exists(const SystemView& system, const std::string& path) {
  std::error_code error;
  return std::filesystem::exists(system.root / path, error);
}

int NumCpus(const SystemView& system) {
  int count = 0;
  for (const std::string& name : system.List("sys/devices/system/cpu")) {
    const bool is_cpu = name.size() > 3 && name.starts_with("cpu") &&
                        name.find_first_not_of("0123456789", 3) == std::string::npos;
    if (is_cpu) ++count;
  }
  return std::max(count, 1);
}

}  // namespace

DoctorFinding CheckClockSynchronized(const SystemView& system) {
  const std::string subject = "clock in step";
  const SystemView::ClockState clock = system.clock();
  if (!clock.is_known) {
    return {
        Level::kUnknown, subject, "the kernel does not tell whether it follows a time server", ""};
  }
  if (clock.is_synchronized) return {Level::kOk, subject, "it follows a time server", ""};
  const bool has_timedatectl = Exists(system, "run/systemd/system");
  return {Level::kWarning,
          subject,
          "it follows no time server: stamps of several machines do not agree, and those of one "
          "drift",
          system.AsRoot(has_timedatectl ? "timedatectl set-ntp true" : "apt install chrony")};
}

DoctorFinding CheckClockYear(const SystemView& system) {
  const std::time_t seconds = system.clock().utime / 1'000'000;
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  const int year = parts.tm_year + 1900;
  const std::string what = Format("the year is %d", year);
  if (year >= 2024 && year < 2100) return {Level::kOk, "clock's year", what, ""};
  return {Level::kWrong,
          "clock's year",
          what + ", expected one from 2024 to 2099",
          system.AsRoot("date -s 'YYYY-MM-DD hh:mm:ss'")};
}

DoctorFinding CheckClockSource(const SystemView& system) {
  const std::string subject = "clock source";
  const std::string folder = "sys/devices/system/clocksource/clocksource0/";
  const std::string source = Shown(system.ReadLine(folder + "current_clocksource"), 40);
  if (source.empty()) return {Level::kUnknown, subject, "/sys does not tell it", ""};
  for (const char* slow : {"hpet", "acpi_pm", "jiffies", "refined-jiffies", "pit"}) {
    if (source != slow) continue;
    return {Level::kWarning,
            subject,
            Format("%s is slow to read; others that there are: %s",
                   source.c_str(),
                   Shown(system.ReadLine(folder + "available_clocksource"), 80).c_str()),
            system.AsRoot("echo tsc >/sys/devices/system/clocksource/clocksource0/"
                          "current_clocksource")};
  }
  return {Level::kOk, subject, source, ""};
}

DoctorFinding CheckClockStep(const SystemView& system, const SystemView::Stalls& stalls) {
  const std::string subject = "clock's steps";
  const std::string what = Format("in one second it left the steady clock by %s",
                                  LatencyText(stalls.clock_step).c_str());
  if (std::abs(stalls.clock_step) < kClockStep) return {Level::kOk, subject, what, ""};
  return {Level::kWarning,
          subject,
          what + ": something sets it, and stamps jump",
          system.AsRoot("fuser -v /dev/rtc0") + "; ps -e | grep -E 'ntp|chrony|timesync|ptp'"};
}

DoctorFinding CheckStalls(const SystemView::Stalls& stalls) {
  const std::string what = Format("a process that slept was late by %s at most in one second",
                                  LatencyText(stalls.longest).c_str());
  if (stalls.longest < kLateStall) return {Level::kOk, "stalls", what, ""};
  return {Level::kWarning,
          "stalls",
          what + ": images will wait or be lost while others compute",
          "ps -eo pid,ni,pcpu,comm --sort=-pcpu | head"};
}

DoctorFinding CheckLoad(const SystemView& system) {
  const std::string text = system.ReadLine("proc/loadavg");
  if (text.empty()) return {Level::kUnknown, "load", "/proc/loadavg can't be read", ""};
  const double load = std::strtod(text.c_str(), nullptr);
  const int cpus = NumCpus(system);
  const std::string what = Format("%.1f on %d processors in the last minute", load, cpus);
  if (load <= cpus) return {Level::kOk, "load", what, ""};
  return {Level::kWarning, "load", what, "ps -eo pid,ni,pcpu,comm --sort=-pcpu | head"};
}

DoctorFinding CheckGovernor(const SystemView& system) {
  const std::string subject = "cpu frequency";
  const std::string folder = "sys/devices/system/cpu/cpu0/cpufreq/";
  const std::string governor = Shown(system.ReadLine(folder + "scaling_governor"), 40);
  const std::string driver = Shown(system.ReadLine(folder + "scaling_driver"), 40);
  if (governor.empty()) {
    return {Level::kUnknown, subject, "/sys tells no governor, as inside a virtual machine", ""};
  }
  // The governor of this name of these drivers goes up with the load.
  const bool is_own = driver.starts_with("intel_pstate") || driver.starts_with("amd-pstate-epp");
  if ((governor == "powersave" && !is_own) || governor == "conservative") {
    return {Level::kWarning,
            subject,
            Format("the governor is %s (%s), which stays low while work waits",
                   governor.c_str(),
                   driver.c_str()),
            system.AsRoot("for f in /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor; do echo "
                          "performance >$f; done")};
  }
  return {Level::kOk, subject, Format("governor %s (%s)", governor.c_str(), driver.c_str()), ""};
}

DoctorFinding CheckRealTimePriority(const SystemView& system) {
  const std::string subject = "real-time priority";
  const std::optional<uint64_t> limit = system.limit(RLIMIT_RTPRIO);
  if (system.is_root || !limit || *limit >= kSomePriority) {
    return {Level::kOk, subject, "a process may be started with chrt -f 10", ""};
  }
  return {Level::kWarning,
          subject,
          Format("this user may have none above %" PRIu64 ", so chrt -f is refused", *limit),
          system.AsRoot(Format("echo %s - rtprio 50 >/etc/security/limits.d/60-vantage-rtprio.conf",
                               system.user.c_str())) +
              "  # and log in anew"};
}

DoctorFinding CheckLockedMemory(const SystemView& system) {
  const std::string subject = "locked memory";
  const std::optional<uint64_t> limit = system.limit(RLIMIT_MEMLOCK);
  if (system.is_root || !limit || *limit >= kLockable) {
    return {Level::kOk,
            subject,
            limit ? ScaledText(static_cast<double>(*limit)) + "B may be locked" : "it has no limit",
            ""};
  }
  return {Level::kWarning,
          subject,
          Format("only %sB may be locked", ScaledText(static_cast<double>(*limit)).c_str()),
          system.AsRoot(Format("echo %s - memlock unlimited "
                               ">/etc/security/limits.d/60-vantage-memlock.conf",
                               system.user.c_str())) +
              "  # and log in anew"};
}

DoctorFinding CheckDisk(const SystemView& system, const std::filesystem::path& folder) {
  const std::optional<double> bytes = system.free_bytes(folder);
  const std::string where = Shown(folder.string());
  if (!bytes) {
    return {Level::kWrong,
            "disk",
            "the folder for recordings is not there: " + where,
            "mkdir -p '" + where + "'"};
  }
  const std::string what = Format("%sB are free at %s", ScaledText(*bytes).c_str(), where.c_str());
  if (*bytes >= kLittleSpace) return {Level::kOk, "disk", what, ""};
  return {*bytes < kNoSpace ? Level::kWrong : Level::kWarning,
          "disk",
          what + ": too little for long recordings",
          "du -xh --max-depth=2 '" + where + "' | sort -h | tail"};
}

DoctorFinding CheckJava(const SystemView& system) {
  const std::string install = system.AsRoot("apt install default-jre");
  const SystemView::CommandOutput java = system.run({"java", "-version"});
  if (!java.started || java.exit_code != 0) {
    return {Level::kWarning, "Java", "there is none, so lcm-spy does not start", install};
  }
  const size_t quote = java.text.find('"');
  const std::string version =
      quote == std::string::npos
          ? ""
          : java.text.substr(quote + 1, java.text.find('"', quote + 1) - quote - 1);
  const int major = std::atoi(version.c_str());
  const std::string what = "version " + Shown(version, 40);
  if (major >= kOldestJava) return {Level::kOk, "Java", what, ""};
  return {Level::kWarning,
          "Java",
          Format("%s, expected %d or later", what.c_str(), kOldestJava),
          install};
}

DoctorFindings CheckJars(const SystemView& system, const std::filesystem::path& programs) {
  struct Jar {
    const char* name;
    std::string path;
    std::string mend;
  };
  const std::filesystem::path build = programs.parent_path();
  const std::string ours = (build / "share/java/lcmtypes_vantage.jar").string();
  const Jar jars[] = {
      {"lcm.jar", "usr/share/java/lcm.jar", system.AsRoot("apt install liblcm-java")},
      {"jchart2d.jar",
       "usr/share/java/jchart2d.jar",
       system.AsRoot("apt install libjchart2d-java")},
      {"our jar",
       ours.substr(1),
       system.AsRoot("apt install default-jdk-headless liblcm-java") + "; cmake --fresh '" +
           build.string() + "'; cmake --build '" + build.string() + "' --target lcmtypes_jar"}};
  DoctorFindings findings;
  for (const Jar& jar : jars) {
    if (Exists(system, jar.path)) {
      findings.push_back({Level::kOk, jar.name, "/" + jar.path, ""});
    } else {
      findings.push_back({Level::kWarning,
                          jar.name,
                          "/" + jar.path + " is not there, so lcm-spy shows nothing of ours",
                          jar.mend});
    }
  }
  return findings;
}

DoctorFinding CheckSupervisor(const SystemView& system) {
  const SystemView::CommandOutput supervisor = system.run({"supervisord", "--version"});
  if (supervisor.started && supervisor.exit_code == 0) {
    const std::string version = supervisor.text.substr(0, supervisor.text.find('\n'));
    return {Level::kOk, "supervisor", "supervisord " + Shown(version, 40), ""};
  }
  if (Exists(system, "run/systemd/system")) {
    return {Level::kOk, "supervisor", "systemd runs", ""};
  }
  return {Level::kWarning,
          "supervisor",
          "neither supervisord nor systemd is there for vantage-up",
          system.AsRoot("apt install supervisor")};
}

DoctorFinding CheckDisplay(const SystemView& system) {
  for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY"}) {
    const std::string value = system.environment(name);
    if (!value.empty()) {
      return {Level::kOk, "display", Format("%s=%s", name, Shown(value, 80).c_str()), ""};
    }
  }
  return {Level::kWarning,
          "display",
          "neither DISPLAY nor WAYLAND_DISPLAY is set: lcm-spy and the viewer open no window",
          "export DISPLAY=:0"};
}

DoctorFinding CheckGraphics(const SystemView& system) {
  for (const std::string& name : system.List("dev/dri")) {
    if (!name.starts_with("renderD")) continue;
    const std::filesystem::path node = system.root / "dev/dri" / name;
    if (system.access(node) == 0) return {Level::kOk, "graphics", "/dev/dri/" + name, ""};
    return {Level::kWarning,
            "graphics",
            "this user may not open /dev/dri/" + name + ", so the viewer draws slowly",
            system.AsRoot(
                Format("usermod -aG %s %s", system.group_of(node).c_str(), system.user.c_str())) +
                "  # and log in anew"};
  }
  return {Level::kUnknown,
          "graphics",
          "there is no graphics card in /dev/dri: the viewer draws in software",
          ""};
}

}  // namespace vantage
