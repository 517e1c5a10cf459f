// Every check of vantage-doctor on a machine that is made up: once well, once not, with the command
// that mends it.
#include <gtest/gtest.h>
#include <net/if.h>
#include <sys/resource.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "tests/tools/monitor_messages.h"
#include "tests/tools/run_program.h"
#include "tools/monitor/doctor_devices.h"
#include "tools/monitor/doctor_host.h"
#include "tools/monitor/doctor_network.h"
#include "tools/monitor/system_view.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;
using Level = DoctorFinding::Level;

constexpr const char* kRouteHeading =
    "Iface\tDestination\tGateway \tFlags\tRefCnt\tUse\tMetric\tMask\t\tMTU\tWindow\tIRTT\n";
constexpr const char* kLoRoute = "lo\t000000E0\t00000000\t0001\t0\t0\t0\t000000F0\t0\t0\t0\n";
constexpr const char* kDefaultRoute =
    "eth0\t00000000\t0102A8C0\t0003\t0\t0\t0\t00000000\t0\t0\t0\n";

class Doctor : public ScratchTest {
 protected:
  void SetUp() override {
    ScratchTest::SetUp();
    system_.root = scratch();
    system_.user = "ada";
    system_.run = [this](const std::vector<std::string>& command) {
      const auto found = programs_.find(command.front());
      return found == programs_.end() ? SystemView::CommandOutput{} : found->second;
    };
    system_.environment = [this](const std::string& name) { return environment_[name]; };
    system_.interface_flags = [this](const std::string& name) { return flags_[name]; };
    system_.access = [this](const fs::path& path) { return refused_[path.string()]; };
    system_.group_of = [](const fs::path&) { return "video"; };
    system_.limit = [this](int) { return limit_; };
    system_.free_bytes = [this](const fs::path&) { return free_bytes_; };
    system_.clock = [this] { return clock_; };
    system_.openni2_devices = [this] { return Result<std::vector<DeviceListing>>(devices_); };
    flags_["lo"] = IFF_UP | IFF_LOOPBACK;
  }

  void Write(const std::string& path, const std::string& text) {
    fs::create_directories((scratch() / path).parent_path());
    std::ofstream(scratch() / path) << text;
  }

  static void Expect(const DoctorFinding& finding, Level level, const std::string& mend) {
    EXPECT_EQ(finding.level, level) << finding.subject << ": " << finding.what;
    EXPECT_EQ(finding.mend, mend) << finding.subject << ": " << finding.what;
    EXPECT_FALSE(finding.what.empty());
  }

  SystemView system_;
  std::map<std::string, SystemView::CommandOutput> programs_;
  std::map<std::string, std::string> environment_;
  std::map<std::string, unsigned> flags_;
  std::map<std::string, int> refused_;
  std::optional<uint64_t> limit_ = 0;
  std::optional<double> free_bytes_ = 1e12;
  SystemView::ClockState clock_{true, true, kStart};
  std::vector<DeviceListing> devices_;
};

TEST_F(Doctor, MulticastRoute) {
  const LcmUrl url;
  Write("proc/net/route", kRouteHeading);
  Expect(CheckMulticastRoute(system_, url), Level::kWrong, "sudo ip route add 224.0.0.0/4 dev lo");
  flags_["lo"] = IFF_LOOPBACK;
  Expect(CheckMulticastRoute(system_, url),
         Level::kWrong,
         "sudo sh -c 'ip link set lo up; ip route add 224.0.0.0/4 dev lo'");
  system_.is_root = true;
  Expect(CheckMulticastRoute(system_, url),
         Level::kWrong,
         "ip link set lo up; ip route add 224.0.0.0/4 dev lo");
  flags_["lo"] = IFF_UP | IFF_LOOPBACK;
  Write("proc/net/route", std::string(kRouteHeading) + kLoRoute + kDefaultRoute);
  Expect(CheckMulticastRoute(system_, url), Level::kOk, "");
  EXPECT_NE(CheckMulticastRoute(system_, url).what.find("by lo"), std::string::npos);
}

TEST_F(Doctor, MulticastRouteThroughAnInterface) {
  LcmUrl url;
  Write("proc/net/route", std::string(kRouteHeading) + kDefaultRoute);
  flags_["eth0"] = IFF_UP | IFF_MULTICAST;
  Expect(CheckMulticastRoute(system_, url), Level::kOk, "");
  flags_["eth0"] = IFF_UP;
  Expect(CheckMulticastRoute(system_, url), Level::kWrong, "sudo ip link set eth0 multicast on");
  flags_["lo"] = IFF_LOOPBACK;
  Expect(CheckMulticastRoute(system_, url), Level::kWrong, "sudo ip link set lo up");
  // A URL that means other machines, and a route that does not leave this one.
  flags_["lo"] = IFF_UP | IFF_LOOPBACK;
  Write("proc/net/route", std::string(kRouteHeading) + kLoRoute + kDefaultRoute);
  url.options = {{"ttl", "1"}};
  Expect(CheckMulticastRoute(system_, url),
         Level::kWarning,
         "sudo ip route replace 224.0.0.0/4 dev eth0");
}

TEST_F(Doctor, MulticastRouteThatIsRejectedIsNone) {
  Write("proc/net/route",
        std::string(kRouteHeading) +
            "lo\t000000E0\t00000000\t0201\t0\t0\t0\t000000F0\t0\t0\t0\n"
            "damaged line\n");
  EXPECT_EQ(CheckMulticastRoute(system_, {}).level, Level::kWrong);
}

TEST_F(Doctor, KernelBuffers) {
  Expect(CheckLargestBuffer(system_, 4194304), Level::kUnknown, "sysctl net.core.rmem_max");
  Write("proc/sys/net/core/rmem_max", "212992\n");
  Expect(CheckLargestBuffer(system_, 4194304),
         Level::kWarning,
         "sudo sh -c 'sysctl -w net.core.rmem_max=4194304; echo net.core.rmem_max=4194304 "
         ">/etc/sysctl.d/60-vantage-rmem_max.conf'");
  Write("proc/sys/net/core/rmem_max", "4194304\n");
  Expect(CheckLargestBuffer(system_, 4194304), Level::kOk, "");
  Expect(CheckDefaultBuffer(system_), Level::kUnknown, "sysctl net.core.rmem_default");
  Write("proc/sys/net/core/rmem_default", "212992\n");
  EXPECT_EQ(CheckDefaultBuffer(system_).level, Level::kWarning);
  EXPECT_NE(CheckDefaultBuffer(system_).mend.find("sysctl -w net.core.rmem_default=1048576"),
            std::string::npos);
  Write("proc/sys/net/core/rmem_default", "1048576\n");
  Expect(CheckDefaultBuffer(system_), Level::kOk, "");
}

TEST_F(Doctor, BusProbe) {
  BusProbe probe;
  probe.error =
      Error{ErrorCode::kUnavailable, "no multicast route; for one machine alone run: ip x"};
  Expect(CheckRoundTrip(probe), Level::kWrong, "ip x");
  EXPECT_EQ(CheckReceiveBuffer(system_, probe).level, Level::kUnknown);
  probe.error.reset();
  probe.num_sent = 20;
  probe.num_returned = 19;
  Expect(CheckRoundTrip(probe), Level::kWrong, "nft list ruleset");
  probe.num_returned = 20;
  Expect(CheckRoundTrip(probe), Level::kOk, "");
  probe.requested = 4194304;
  probe.granted = 212992;
  EXPECT_EQ(CheckReceiveBuffer(system_, probe).level, Level::kWrong);
  EXPECT_NE(CheckReceiveBuffer(system_, probe).mend.find("rmem_max=4194304"), std::string::npos);
  probe.granted = 4194304;
  Expect(CheckReceiveBuffer(system_, probe), Level::kOk, "");
}

TEST_F(Doctor, Port) {
  const LcmUrl url;  // 7667 is 1DF3.
  EXPECT_EQ(CheckPort(system_, url).level, Level::kUnknown);
  Write(
      "proc/net/udp",
      "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout "
      "inode ref pointer drops\n"
      "  100: 00000000:1DF3 00000000:0000 07 00000000:00000000 00:00000000 00000000  1000        0 "
      "4711 2 0000 0\n"
      "  101: 00000000:0035 00000000:0000 07 00000000:00000000 00:00000000 00000000  1000        0 "
      "4712 2 0000 0\n"
      "nonsense\n");
  EXPECT_NE(CheckPort(system_, url).what.find("others that this user may not look at"),
            std::string::npos);
  Write("proc/42/comm", "vantage-ppf\n");
  fs::create_directories(scratch() / "proc/42/fd");
  fs::create_symlink("socket:[4711]", scratch() / "proc/42/fd/5");
  EXPECT_EQ(CheckPort(system_, url).what, "heard by vantage-ppf (pid 42)");
  Write("proc/net/udp", "  sl  local_address\n");
  EXPECT_EQ(CheckPort(system_, url).what, "nobody listens on it now");
}

TEST_F(Doctor, ProcessNames) {
  BusProbe probe;
  EXPECT_EQ(CheckProcessNames(system_, probe, {"ppf"})[0].level, Level::kOk);
  Send(&probe.model, "PROCESS_STATUS", MadeProcess("ppf"), kStart);
  probe.holders["ppf"] = 100;
  EXPECT_EQ(CheckProcessNames(system_, probe, {"ppf"})[0].level, Level::kOk);
  // One that holds its name and says nothing.
  probe.holders["fusion"] = 77;
  Expect(CheckProcessNames(system_, probe, {"ppf", "fusion"})[0],
         Level::kWrong,
         "kill -CONT 77; kill 77");
  process_status_t other = MadeProcess("ppf");
  other.pid = 200;
  other.start_utime += 1;
  Send(&probe.model, "PROCESS_STATUS", other, kStart + 1);
  Expect(CheckProcessNames(system_, probe, {"ppf"})[0], Level::kWrong, "kill 200");
}

TEST_F(Doctor, Clock) {
  Expect(CheckClockSynchronized(system_), Level::kOk, "");
  clock_.is_synchronized = false;
  Expect(CheckClockSynchronized(system_), Level::kWarning, "sudo apt install chrony");
  fs::create_directories(scratch() / "run/systemd/system");
  Expect(CheckClockSynchronized(system_), Level::kWarning, "sudo timedatectl set-ntp true");
  clock_.is_known = false;
  Expect(CheckClockSynchronized(system_), Level::kUnknown, "");
  clock_.utime = kStart;
  Expect(CheckClockYear(system_), Level::kWrong, "sudo date -s 'YYYY-MM-DD hh:mm:ss'");  // 2023
  clock_.utime = kStart + 3 * 365 * 86400 * kSecond;
  Expect(CheckClockYear(system_), Level::kOk, "");
  Expect(CheckClockStep(system_, {0.0, 0.0001}), Level::kOk, "");
  EXPECT_EQ(CheckClockStep(system_, {0.0, -2.0}).level, Level::kWarning);
}

TEST_F(Doctor, ClockSource) {
  EXPECT_EQ(CheckClockSource(system_).level, Level::kUnknown);
  const std::string folder = "sys/devices/system/clocksource/clocksource0/";
  Write(folder + "current_clocksource", "tsc\n");
  Expect(CheckClockSource(system_), Level::kOk, "");
  Write(folder + "current_clocksource", "hpet\n");
  Write(folder + "available_clocksource", "hpet acpi_pm\n");
  EXPECT_EQ(CheckClockSource(system_).level, Level::kWarning);
}

TEST_F(Doctor, StallsAndLoad) {
  Expect(CheckStalls({0.004, 0.0}), Level::kOk, "");
  Expect(CheckStalls({0.08, 0.0}), Level::kWarning, "ps -eo pid,ni,pcpu,comm --sort=-pcpu | head");
  EXPECT_EQ(CheckLoad(system_).level, Level::kUnknown);
  for (const char* name : {"cpu0", "cpu1", "cpufreq", "cpuidle"}) {
    fs::create_directories(scratch() / "sys/devices/system/cpu" / name);
  }
  Write("proc/loadavg", "1.90 1.00 0.50 1/100 1234\n");
  Expect(CheckLoad(system_), Level::kOk, "");
  Write("proc/loadavg", "2.10 1.00 0.50 1/100 1234\n");
  Expect(CheckLoad(system_), Level::kWarning, "ps -eo pid,ni,pcpu,comm --sort=-pcpu | head");
}

TEST_F(Doctor, Governor) {
  EXPECT_EQ(CheckGovernor(system_).level, Level::kUnknown);
  const std::string folder = "sys/devices/system/cpu/cpu0/cpufreq/";
  Write(folder + "scaling_governor", "performance\n");
  Write(folder + "scaling_driver", "acpi-cpufreq\n");
  Expect(CheckGovernor(system_), Level::kOk, "");
  Write(folder + "scaling_governor", "powersave\n");
  Expect(CheckGovernor(system_),
         Level::kWarning,
         "sudo sh -c 'for f in /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor; do echo "
         "performance >$f; done'");
  Write(folder + "scaling_driver", "intel_pstate\n");
  Expect(CheckGovernor(system_), Level::kOk, "");
}

TEST_F(Doctor, Limits) {
  Expect(CheckRealTimePriority(system_),
         Level::kWarning,
         "sudo sh -c 'echo ada - rtprio 50 >/etc/security/limits.d/60-vantage-rtprio.conf'  # and "
         "log in anew");
  EXPECT_EQ(CheckLockedMemory(system_).level, Level::kWarning);
  limit_ = 64 << 20;
  Expect(CheckRealTimePriority(system_), Level::kOk, "");
  Expect(CheckLockedMemory(system_), Level::kOk, "");
  limit_.reset();
  Expect(CheckLockedMemory(system_), Level::kOk, "");
  limit_ = 0;
  system_.is_root = true;
  Expect(CheckRealTimePriority(system_), Level::kOk, "");
}

TEST_F(Doctor, Disk) {
  Expect(CheckDisk(system_, "/data"), Level::kOk, "");
  free_bytes_ = 1e9;
  Expect(CheckDisk(system_, "/data"),
         Level::kWarning,
         "du -xh --max-depth=2 '/data' | sort -h | tail");
  free_bytes_ = 1e7;
  EXPECT_EQ(CheckDisk(system_, "/data").level, Level::kWrong);
  free_bytes_.reset();
  Expect(CheckDisk(system_, "/data"), Level::kWrong, "mkdir -p '/data'");
}

TEST_F(Doctor, JavaAndJars) {
  Expect(CheckJava(system_), Level::kWarning, "sudo apt install default-jre");
  programs_["java"] = {true, 0, "openjdk version \"17.0.12\" 2024-07-16\nOpenJDK"};
  Expect(CheckJava(system_), Level::kOk, "");
  programs_["java"] = {true, 0, "java version \"1.8.0_402\"\n"};
  EXPECT_EQ(CheckJava(system_).level, Level::kWarning);
  programs_["java"] = {true, 0, "nothing of a version"};
  EXPECT_EQ(CheckJava(system_).level, Level::kWarning);
  DoctorFindings jars = CheckJars(system_, "/opt/vantage/bin");
  ASSERT_EQ(jars.size(), 3U);
  Expect(jars[0], Level::kWarning, "sudo apt install liblcm-java");
  Expect(jars[1], Level::kWarning, "sudo apt install libjchart2d-java");
  EXPECT_NE(jars[2].mend.find("--target lcmtypes_jar"), std::string::npos);
  Write("usr/share/java/lcm.jar", "x");
  Write("usr/share/java/jchart2d.jar", "x");
  Write("opt/vantage/share/java/lcmtypes_vantage.jar", "x");
  for (const DoctorFinding& jar : CheckJars(system_, "/opt/vantage/bin")) {
    Expect(jar, Level::kOk, "");
  }
}

TEST_F(Doctor, Supervisor) {
  Expect(CheckSupervisor(system_), Level::kWarning, "sudo apt install supervisor");
  programs_["supervisord"] = {true, 0, "4.2.5\n"};
  Expect(CheckSupervisor(system_), Level::kOk, "");
  programs_.clear();
  fs::create_directories(scratch() / "run/systemd/system");
  Expect(CheckSupervisor(system_), Level::kOk, "");
}

TEST_F(Doctor, DisplayAndGraphics) {
  Expect(CheckDisplay(system_), Level::kWarning, "export DISPLAY=:0");
  environment_["DISPLAY"] = ":1";
  Expect(CheckDisplay(system_), Level::kOk, "");
  Expect(CheckGraphics(system_), Level::kUnknown, "");
  Write("dev/dri/card0", "");
  Write("dev/dri/renderD128", "");
  Expect(CheckGraphics(system_), Level::kOk, "");
  refused_[(scratch() / "dev/dri/renderD128").string()] = EACCES;
  Expect(CheckGraphics(system_), Level::kWarning, "sudo usermod -aG video ada  # and log in anew");
}

TEST_F(Doctor, VideoNodes) {
  EXPECT_EQ(CheckVideoNodes(system_)[0].what, "the kernel has none");
  Write("sys/class/video4linux/video0/name", "Web \033[31mcam\n");
  Write("dev/video0", "");
  Expect(CheckVideoNodes(system_)[0], Level::kOk, "");
  refused_[(scratch() / "dev/video0").string()] = EACCES;
  Expect(
      CheckVideoNodes(system_)[0], Level::kWrong, "sudo usermod -aG video ada  # and log in anew");
  refused_[(scratch() / "dev/video0").string()] = ENODEV;
  Expect(CheckVideoNodes(system_)[0], Level::kWrong, "");
}

TEST_F(Doctor, UsbCameras) {
  EXPECT_EQ(CheckUsbCameras(system_, {})[0].what, "no depth camera is plugged in");
  const std::string folder = "sys/bus/usb/devices/1-2/";
  Write(folder + "idVendor", "1d27\n");
  Write(folder + "idProduct", "0601\n");
  Write(folder + "busnum", "1\n");
  Write(folder + "devnum", "5\n");
  Expect(CheckUsbCameras(system_, {})[0], Level::kOk, "");
  refused_[(scratch() / "dev/bus/usb/001/005").string()] = EACCES;
  Expect(CheckUsbCameras(system_, {})[0], Level::kWrong, "sudo apt install libopenni2-0");
  Write("lib/udev/rules.d/60-libopenni2-0.rules", "");
  Expect(CheckUsbCameras(system_, {})[0],
         Level::kWrong,
         "sudo usermod -aG video ada  # and log in anew");
}

TEST_F(Doctor, KinectsModule) {
  const std::string folder = "sys/bus/usb/devices/1-2/";
  Write(folder + "idVendor", "045e\n");
  Write(folder + "idProduct", "02ae\n");
  const std::vector<WantedCamera> kernel = {{"KINECT", "v4l2", {}, false}};
  const std::vector<WantedCamera> openni2 = {{"KINECT", "openni2", {}, false}};
  Expect(CheckUsbCameras(system_, kernel).back(),
         Level::kWrong,
         "sudo modprobe gspca_kinect depth_mode=1");
  Expect(CheckUsbCameras(system_, openni2).back(), Level::kOk, "");
  Write("proc/modules", "gspca_kinect 20480 0 - Live 0x0\ngspca_main 1 1 - Live 0x0\n");
  Expect(CheckUsbCameras(system_, openni2).back(), Level::kWrong, "sudo modprobe -r gspca_kinect");
  EXPECT_EQ(CheckUsbCameras(system_, kernel).back().level, Level::kWarning);
  Write("sys/module/gspca_kinect/parameters/depth_mode", "Y\n");
  Expect(CheckUsbCameras(system_, kernel).back(), Level::kOk, "");
}

TEST_F(Doctor, CamerasOfTheConfiguration) {
  const auto check =
      [this](const std::string& driver, const std::string& device, bool simulated = false) {
        return CheckWantedCameras(
            system_, {{"X", driver, DeviceSelector::Parse(device).value(), simulated}})[0];
      };
  Expect(check("openni2", "serial:SIM0001", true), Level::kOk, "");
  Expect(check("openni2", "index:0"), Level::kWrong, "lsusb; vantage-openni2 --list");
  devices_.push_back({"uri://a", "Xtion", "", {}});
  Expect(check("openni2", "index:0"), Level::kOk, "");
  Expect(check("openni2", "uri:uri://a"), Level::kOk, "");
  Expect(check("openni2", "index:1"), Level::kWrong, "lsusb; vantage-openni2 --list");
  Expect(check("openni2", "serial:9"), Level::kUnknown, "vantage-openni2 --list");
  EXPECT_EQ(check("openni2", "oni:/nonexistent.oni").level, Level::kWrong);
  Expect(check("v4l2", "index:0"), Level::kWrong, "vantage-v4l2 --list");
  Write("sys/class/video4linux/video3/name", "cam\n");
  Expect(check("v4l2", "index:0"), Level::kOk, "");
  Expect(check("v4l2", "path:/dev/video3"), Level::kOk, "");
  Expect(check("v4l2", "path:/dev/video4"), Level::kWrong, "vantage-v4l2 --list");
  Expect(check("v4l2", "bus:usb-1"), Level::kUnknown, "vantage-v4l2 --list");
}

TEST(DoctorFinding, TextAndJsonAreFitToBeShownAndCounted) {
  const DoctorFindings findings = {{Level::kOk, "a", "fine\033[31m", ""},
                                   {Level::kWrong, "b", "bad\n", "mend it"}};
  const std::string text = DoctorText(findings);
  EXPECT_NE(text.find("wrong    b"), std::string::npos) << text;
  EXPECT_NE(text.find("$ mend it\n"), std::string::npos) << text;
  EXPECT_NE(text.find("1 ok, 0 unknown, 0 warnings, 1 wrong\n"), std::string::npos) << text;
  EXPECT_EQ(text.find('\033'), std::string::npos);
  EXPECT_EQ(ExitCodeOf(findings), 1);
  EXPECT_EQ(ExitCodeOf({{Level::kWarning, "a", "x", ""}}), 0);
  EXPECT_NE(DoctorJson(findings).find("\"level\": \"wrong\""), std::string::npos);
}

}  // namespace
}  // namespace vantage
