#include "tools/monitor/doctor_network.h"

#include <arpa/inet.h>
#include <net/if.h>

#include <bit>
#include <cinttypes>
#include <cstdlib>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <system_error>

#include "common/format.h"
#include "tools/monitor/shown_text.h"

namespace vantage {
namespace {

using Level = DoctorFinding::Level;

constexpr int64_t kDefaultBuffer = 1 << 20;  // Bytes that lcm-spy needs beside a camera.
constexpr size_t kMostSockets = 1000;

struct Route {
  std::string interface;
  uint32_t destination = 0;  // Host byte order, as the mask.
  uint32_t mask = 0;
};

std::vector<Route> ReadRoutes(const SystemView& system) {
  constexpr unsigned kUp = 1;
  constexpr unsigned kReject = 0x200;
  std::vector<Route> routes;
  std::istringstream lines(system.Read("proc/net/route").value_or(""));
  for (std::string line; std::getline(lines, line);) {
    char interface[64];
    uint32_t destination = 0;
    uint32_t mask = 0;
    unsigned flags = 0;
    if (std::sscanf(line.c_str(),
                    "%63s %8x %*x %4x %*d %*d %*d %8x",
                    interface,
                    &destination,
                    &flags,
                    &mask) != 4) {
      continue;
    }
    if ((flags & kUp) == 0 || (flags & kReject) != 0) continue;
    routes.push_back({interface, ntohl(destination), ntohl(mask)});
  }
  return routes;
}

// The one with the longest mask.
std::optional<Route> RouteTo(const std::vector<Route>& routes, const std::string& address) {
  in_addr parsed{};
  inet_pton(AF_INET, address.c_str(), &parsed);
  const uint32_t host = ntohl(parsed.s_addr);
  std::optional<Route> best;
  for (const Route& route : routes) {
    if ((host & route.mask) != route.destination) continue;
    if (!best || std::popcount(route.mask) > std::popcount(best->mask)) best = route;
  }
  return best;
}

DoctorFinding BadRoute(const SystemView& system, const std::string& what, const char* command) {
  return {Level::kWrong, "multicast route", what, system.AsRoot(command)};
}

// Processes by their ids that have one of the sockets, by inode.
std::set<std::string> OwnersOf(const SystemView& system, std::set<std::string> inodes) {
  std::set<std::string> owners;
  for (const std::string& pid : system.List("proc")) {
    if (pid.find_first_not_of("0123456789") != std::string::npos) continue;
    const std::string folder = "proc/" + pid + "/fd";
    for (const std::string& file : system.List(folder)) {
      std::error_code error;
      const std::string link =
          std::filesystem::read_symlink(system.root / folder / file, error).string();
      if (error || !link.starts_with("socket:[")) continue;
      const std::string inode = link.substr(8, link.size() - 9);
      if (inodes.erase(inode) == 0) continue;
      owners.insert(Shown(system.ReadLine("proc/" + pid + "/comm"), 32) + " (pid " + pid + ")");
    }
  }
  if (!inodes.empty()) owners.insert("others that this user may not look at");
  return owners;
}

}  // namespace

DoctorFinding CheckMulticastRoute(const SystemView& system, const LcmUrl& url) {
  if (url.provider == LcmUrl::Provider::kMemory) {
    return {Level::kUnknown, "multicast route", "the URL stays within a process", ""};
  }
  const std::vector<Route> routes = ReadRoutes(system);
  const std::optional<Route> route = RouteTo(routes, url.address);
  const bool is_lo_up = (system.interface_flags("lo") & IFF_UP) != 0;
  if (!route) {
    return BadRoute(system,
                    Format("there is none to %s: LCM sends nothing", url.address.c_str()),
                    is_lo_up ? "ip route add 224.0.0.0/4 dev lo"
                             : "ip link set lo up; ip route add 224.0.0.0/4 dev lo");
  }
  if (!is_lo_up) {
    return BadRoute(
        system, "lo is down: processes of one machine hear nothing", "ip link set lo up");
  }
  const unsigned flags = system.interface_flags(route->interface);
  const bool is_loopback = route->interface == "lo" || (flags & IFF_LOOPBACK) != 0;
  if (!is_loopback && (flags & IFF_MULTICAST) == 0) {
    return BadRoute(system,
                    Format("it is by %s, which has no multicast", route->interface.c_str()),
                    Format("ip link set %s multicast on", route->interface.c_str()).c_str());
  }
  const std::string ttl = url.Option("ttl");
  const bool means_others = !ttl.empty() && ttl.find_first_not_of('0') != std::string::npos;
  if (is_loopback && means_others) {
    DoctorFinding finding{Level::kWarning,
                          "multicast route",
                          Format("it is by %s, so other machines hear nothing, though the URL has "
                                 "ttl=%s",
                                 route->interface.c_str(),
                                 ttl.c_str()),
                          ""};
    const std::optional<Route> out = RouteTo(routes, "8.8.8.8");
    if (out) {
      finding.mend = system.AsRoot("ip route replace 224.0.0.0/4 dev " + out->interface);
    }
    return finding;
  }
  return {Level::kOk,
          "multicast route",
          Format("%s leaves by %s", url.address.c_str(), route->interface.c_str()),
          ""};
}

DoctorFinding CheckRoundTrip(const BusProbe& probe) {
  const std::string subject = "LCM round trip";
  if (probe.error) {
    // The sentence ends with its command.
    const std::string& what = probe.error->message;
    const size_t run = what.rfind("run: ");
    return {Level::kWrong, subject, what, run == std::string::npos ? "" : what.substr(run + 5)};
  }
  if (probe.num_returned < probe.num_sent || probe.num_sent == 0) {
    return {Level::kWrong,
            subject,
            Format("%d of %d messages came back on %s; a firewall may drop UDP multicast",
                   probe.num_returned,
                   probe.num_sent,
                   probe.url.c_str()),
            "nft list ruleset"};
  }
  return {Level::kOk,
          subject,
          Format("%d of %d messages came back on %s, median %s",
                 probe.num_returned,
                 probe.num_sent,
                 probe.url.substr(0, probe.url.find('?')).c_str(),
                 LatencyText(probe.round_trip).c_str()),
          ""};
}

DoctorFinding CheckReceiveBuffer(const SystemView& system, const BusProbe& probe) {
  const std::string subject = "receive buffer";
  if (probe.error) return {Level::kUnknown, subject, "the bus can't be opened", ""};
  const std::string what = Format("%d of %d bytes granted", probe.granted, probe.requested);
  if (probe.granted >= probe.requested) return {Level::kOk, subject, what, ""};
  return {Level::kWrong,
          subject,
          what + ": images and what comes with them will be lost",
          system.SetSysctl("net.core.rmem_max", probe.requested)};
}

DoctorFinding CheckLargestBuffer(const SystemView& system, int64_t wanted) {
  const std::string subject = "rmem_max";
  const std::string text = system.ReadLine("proc/sys/net/core/rmem_max");
  if (text.empty()) {
    return {Level::kUnknown,
            subject,
            "net.core.rmem_max is not shown inside this network namespace or container; look at it "
            "on the host",
            "sysctl net.core.rmem_max"};
  }
  const int64_t bytes = std::strtoll(text.c_str(), nullptr, 10);
  const std::string what = Format("net.core.rmem_max is %" PRId64, bytes);
  if (bytes >= wanted) return {Level::kOk, subject, what, ""};
  return {Level::kWarning,
          subject,
          what + Format(", less than the %" PRId64 " asked for: only the administrator's processes "
                        "get it",
                        wanted),
          system.SetSysctl("net.core.rmem_max", wanted)};
}

DoctorFinding CheckDefaultBuffer(const SystemView& system) {
  const std::string subject = "rmem_default";
  const std::string text = system.ReadLine("proc/sys/net/core/rmem_default");
  if (text.empty()) {
    return {Level::kUnknown,
            subject,
            "net.core.rmem_default is not shown inside this network namespace or container; look "
            "at it on the host",
            "sysctl net.core.rmem_default"};
  }
  const int64_t bytes = std::strtoll(text.c_str(), nullptr, 10);
  const std::string what = Format("net.core.rmem_default is %" PRId64, bytes);
  if (bytes >= kDefaultBuffer) return {Level::kOk, subject, what, ""};
  return {Level::kWarning,
          subject,
          what + ": programs that ask for no buffer, as lcm-spy, lose messages beside raw images",
          system.SetSysctl("net.core.rmem_default", kDefaultBuffer)};
}

DoctorFinding CheckPort(const SystemView& system, const LcmUrl& url) {
  const std::string subject = Format("port %d", url.port);
  const std::optional<std::string> sockets = system.Read("proc/net/udp");
  if (!sockets) {
    return {Level::kUnknown, subject, "/proc/net/udp can't be read", ""};
  }
  std::set<std::string> inodes;
  std::istringstream lines(*sockets);
  for (std::string line; std::getline(lines, line) && inodes.size() < kMostSockets;) {
    unsigned port = 0;
    char inode[32];
    if (std::sscanf(line.c_str(),
                    " %*d: %*x:%4x %*x:%*x %*x %*x:%*x %*x:%*x %*x %*d %*d %31s",
                    &port,
                    inode) == 2 &&
        port == url.port) {
      inodes.insert(inode);
    }
  }
  if (inodes.empty()) return {Level::kOk, subject, "nobody listens on it now", ""};
  std::string owners;
  for (const std::string& owner : OwnersOf(system, inodes)) {
    owners += (owners.empty() ? "" : ", ") + owner;
  }
  return {Level::kOk, subject, "heard by " + owners, ""};
}

DoctorFindings CheckProcessNames(const SystemView& system,
                                 const BusProbe& probe,
                                 const std::vector<std::string>& expected) {
  DoctorFindings findings;
  if (probe.error) return findings;
  std::string running;
  for (const auto& [name, process] : probe.model.processes()) {
    if (IsWatcher(name)) continue;
    running += (running.empty() ? "" : ", ") + Shown(name, 64);
    if (process.num_conflicts == 0 && process.num_restarts == 0) continue;
    findings.push_back({Level::kWrong,
                        "process " + name,
                        "two processes have this name on the bus",
                        Format("kill %d", process.status.pid)});
  }
  for (const std::string& name : expected) {
    const auto holder = probe.holders.find(name);
    if (holder == probe.holders.end() || probe.model.processes().contains(name)) continue;
    findings.push_back({Level::kWrong,
                        "process " + name,
                        "it holds its name but says nothing on the bus: it hangs or was stopped",
                        holder->second > 0
                            ? Format("kill -CONT %d; kill %d", holder->second, holder->second)
                            : system.AsRoot("ss -xlp | grep vantage/" + name)});
  }
  if (findings.empty()) {
    findings.push_back({Level::kOk,
                        "process names",
                        running.empty() ? "none of the set-up's processes runs"
                                        : "on the bus, each once: " + running,
                        ""});
  }
  return findings;
}

}  // namespace vantage
