// vantage-openni2: publishes a depth camera, or a recording of one.
#include "nodes/openni2_node.h"
#include "nodes/process.h"

int main(int argc, char** argv) {
  return vantage::RunProcess(
      argc,
      argv,
      "openni2",
      "Publishes an OpenNI2 depth camera or .oni recording on CAMERA_<NAME>.",
      [](vantage::Bus& bus, vantage::ConfigReader& config, const vantage::ProcessOptions& options) {
        return vantage::MakeOpenni2Node(bus, config, options);
      },
      &vantage::ListOpenni2Devices);
}
