#include "tests/drivers/v4l2_shim/device_state.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "tests/drivers/v4l2_shim/control_table.h"

namespace vantage::v4l2_shim {
namespace {

namespace fs = std::filesystem;

fs::path StateFile(const fs::path& root, const Device& device) {
  return root / "state" / ("video" + std::to_string(device.number) + ".txt");
}

}  // namespace

DeviceState LoadState(const fs::path& root, const Device& device) {
  DeviceState state;
  for (const ControlValue& control : device.controls) {
    state.controls[control.name] = control.initial;
  }
  std::ifstream stream(StateFile(root, device));
  stream >> state.fourcc >> state.width >> state.height >> state.rate.numerator >>
      state.rate.denominator;
  std::string name;
  for (int32_t value = 0; stream >> name >> value;) state.controls[name] = value;
  const bool known = std::ranges::any_of(device.formats, [&state](const FormatMode& mode) {
    return mode.fourcc == state.fourcc &&
           (mode.stepwise || (mode.width == state.width && mode.height == state.height));
  });
  if (!known && !device.formats.empty()) {
    const FormatMode& first = device.formats.front();
    state.fourcc = first.fourcc;
    state.width = first.width;
    state.height = first.height;
    state.rate = first.rates.front();
  }
  return state;
}

void SaveState(const fs::path& root, const Device& device, const DeviceState& state) {
  const fs::path file = StateFile(root, device);
  const fs::path beside = file.string() + "." + std::to_string(getpid());
  std::ofstream stream(beside);
  stream << state.fourcc << ' ' << state.width << ' ' << state.height << ' ' << state.rate.numerator
         << ' ' << state.rate.denominator << '\n';
  for (const auto& [name, value] : state.controls) stream << name << ' ' << value << '\n';
  stream.close();
  fs::rename(beside, file);
}

bool IsInactive(const DeviceState& state, const std::string& control) {
  const KnownControl* known = FindControl(control);
  if (known == nullptr || known->master == nullptr) return false;
  const auto master = state.controls.find(known->master);
  return master != state.controls.end() && master->second != known->manual;
}

}  // namespace vantage::v4l2_shim
