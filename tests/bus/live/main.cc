// These tests send over multicast, so the program first moves into a network of its own where
// nothing else is: loopback alone, with a multicast route.

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <net/if.h>
#include <net/route.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <string>

#include "tests/bus/live/private_network.h"

namespace vantage {
namespace {

bool WriteFile(const char* file, const std::string& text) {
  const int descriptor = open(file, O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool written =
      write(descriptor, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  close(descriptor);
  return written;
}

bool Unshare() {
  if (unshare(CLONE_NEWNET) == 0) return true;
  const uid_t uid = getuid();
  const gid_t gid = getgid();
  if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return false;
  return WriteFile("/proc/self/setgroups", "deny") &&
         WriteFile("/proc/self/uid_map", "0 " + std::to_string(uid) + " 1") &&
         WriteFile("/proc/self/gid_map", "0 " + std::to_string(gid) + " 1");
}

sockaddr Address(const char* text) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  inet_pton(AF_INET, text, &address.sin_addr);
  sockaddr result{};
  std::memcpy(&result, &address, sizeof result);
  return result;
}

bool SetUpLoopback(bool with_route) {
  const int control = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (control < 0) return false;
  ifreq request{};
  std::strncpy(request.ifr_name, "lo", IFNAMSIZ - 1);
  request.ifr_flags = IFF_UP | IFF_RUNNING;
  bool good = ioctl(control, SIOCSIFFLAGS, &request) == 0;
  if (good && with_route) {
    std::string device = "lo";
    rtentry route{};
    route.rt_dst = Address("224.0.0.0");
    route.rt_genmask = Address("240.0.0.0");
    route.rt_flags = RTF_UP;
    route.rt_dev = device.data();
    good = ioctl(control, SIOCADDRT, &route) == 0;
  }
  close(control);
  return good;
}

bool g_has_private_network = false;

}  // namespace

bool EnterPrivateNetwork(bool with_route) { return Unshare() && SetUpLoopback(with_route); }

bool HasPrivateNetwork() { return g_has_private_network; }

}  // namespace vantage

#ifdef __SANITIZE_THREAD__
// GLib, inside LCM, makes its locks with atomics that the sanitizer does not see.
extern "C" const char* __tsan_default_suppressions() { return "race:g_static_rec_mutex_lock\n"; }
#endif

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  vantage::g_has_private_network = vantage::EnterPrivateNetwork(true);
  return RUN_ALL_TESTS();
}
