#include "tests/drivers/v4l2_live/emulated_devices.h"

#include <cstdlib>
#include <fstream>
#include <stdexcept>

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr const char* kVariable = "VANTAGE_V4L2_SHIM";

}  // namespace

EmulatedDevices::EmulatedDevices() {
  std::string name = fs::temp_directory_path() / "v4l2-devices-XXXXXX";
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no folder " + name);
  folder_ = name;
  std::ofstream(folder_ / "devices").flush();
  setenv(kVariable, (folder_ / "devices").c_str(), 1);
  if (!fs::exists("/dev/v4l")) throw std::runtime_error("the program is not linked to the shim");
}

EmulatedDevices::~EmulatedDevices() {
  unsetenv(kVariable);
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

void EmulatedDevices::Describe(const std::string& description) const {
  std::ofstream(folder_ / "devices.new") << description;
  fs::rename(folder_ / "devices.new", folder_ / "devices");
  // The shim looks when somebody asks.
  (void)fs::exists("/dev/v4l");
}

std::optional<int64_t> EmulatedDevices::Control(int number, const std::string& name) const {
  std::ifstream state(folder_ / "devices.root/state" / ("video" + std::to_string(number) + ".txt"));
  std::string line;
  std::getline(state, line);  // The format.
  std::string control;
  for (int64_t value = 0; state >> control >> value;) {
    if (control == name) return value;
  }
  return std::nullopt;
}

}  // namespace vantage
