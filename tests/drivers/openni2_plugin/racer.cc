// Takes the device of a serial, round by round: a byte on standard input begins a round, a byte on
// standard output tells that the right device streams, another byte of input lets it go.
#include <unistd.h>

#include <cstdio>

#include "tests/drivers/openni2_plugin/openni2_fixture.h"

namespace vantage {
namespace {

constexpr auto kEnough = std::chrono::seconds(20);  // for failures only

// 'y', or 'n' when no frame or one of another device came.
char TakeDevice(Camera& camera, const std::string& serial) {
  const auto deadline = std::chrono::steady_clock::now() + kEnough;
  while (std::chrono::steady_clock::now() < deadline) {
    const std::optional<CameraFrame> frame = camera.Grab(std::chrono::milliseconds(100));
    if (frame) return frame->serial == serial ? 'y' : 'n';
  }
  std::fprintf(stderr, "%s: %s\n", serial.c_str(), camera.status().message.c_str());
  return 'n';
}

int Race(const std::string& serial) {
  SimAbilities abilities;
  abilities.exclusive = true;
  abilities.opening_time = std::chrono::milliseconds(20);
  Camera::Options options;
  options.device = *DeviceSelector::Parse("serial:" + serial);
  // One look at all devices must do: programs that look at the same time don't turn each other
  // away.
  options.search_interval = kEnough;
  options.retry_interval = kEnough;
  for (char byte = 0; read(STDIN_FILENO, &byte, 1) == 1;) {
    Result<std::unique_ptr<Openni2Api>> api = Openni2Api::Create();
    if (!api) return 1;
    SetPose();
    SetAbilities(abilities);
    Result<std::unique_ptr<Camera>> camera = Camera::Create(options, std::move(api).value());
    if (!camera) return 1;
    const char taken = TakeDevice(**camera, serial);
    if (write(STDOUT_FILENO, &taken, 1) != 1 || read(STDIN_FILENO, &byte, 1) != 1) return 1;
  }
  return 0;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) { return argc == 2 ? vantage::Race(argv[1]) : 2; }
