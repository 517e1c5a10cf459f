#include "drivers/openni2/usb_permission.h"

#include <grp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>

#include "common/format.h"

namespace vantage {
namespace {

std::string GroupName(gid_t gid) {
  std::array<char, 4096> buffer{};
  group entry{};
  group* found = nullptr;
  const bool known =
      getgrgid_r(gid, &entry, buffer.data(), buffer.size(), &found) == 0 && found != nullptr;
  return known ? entry.gr_name : std::to_string(gid);
}

}  // namespace

std::string UsbPermissionHint(const std::string& uri, const std::filesystem::path& usb_folder) {
  const size_t at = uri.rfind('@');
  unsigned bus = 0;
  unsigned device = 0;
  if (at == std::string::npos || std::sscanf(uri.c_str() + at, "@%3u/%3u", &bus, &device) != 2) {
    return {};
  }
  const std::filesystem::path node = usb_folder / Format("%03u", bus) / Format("%03u", device);
  struct stat status {};
  if (stat(node.c_str(), &status) != 0) return {};
  if (eaccess(node.c_str(), R_OK | W_OK) == 0 || errno != EACCES) return {};
  const std::string group_name = GroupName(status.st_gid);
  return Format(
      "this user may not write to %s, which belongs to the group %s: `sudo usermod -aG %s $USER` "
      "and a new login help, or the udev rules of libopenni2-0 and unplugging it",
      node.c_str(),
      group_name.c_str(),
      group_name.c_str());
}

}  // namespace vantage
