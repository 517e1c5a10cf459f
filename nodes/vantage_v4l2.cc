// vantage-v4l2: publishes a camera of the kernel's video4linux.
#include "nodes/process.h"
#include "nodes/v4l2_node.h"

int main(int argc, char** argv) {
  return vantage::RunProcess(
      argc,
      argv,
      "v4l2",
      "Publishes a V4L2 camera, of depth or of color, on CAMERA_<NAME>.",
      [](vantage::Bus& bus, vantage::ConfigReader& config, const vantage::ProcessOptions& options) {
        return vantage::MakeV4l2Node(bus, config, options);
      },
      &vantage::ListV4l2Devices);
}
