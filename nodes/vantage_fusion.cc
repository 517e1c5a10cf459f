// vantage-fusion: fuses detections into objects and chooses the next view.
#include "nodes/fusion_node.h"
#include "nodes/process.h"

int main(int argc, char** argv) {
  return vantage::RunProcess(
      argc,
      argv,
      "fusion",
      "Fuses DETECTIONS_<NAME> into OBJECTS and leads the camera by NEXT_VIEW.",
      [](vantage::Bus& bus, vantage::ConfigReader& config, const vantage::ProcessOptions& options) {
        return vantage::MakeFusionNode(bus, config, options);
      });
}
