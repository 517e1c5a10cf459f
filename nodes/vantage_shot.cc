// vantage-shot: finds known objects in the depth images of a camera at rest.
#include "nodes/estimator_node.h"
#include "nodes/process.h"

int main(int argc, char** argv) {
  return vantage::RunProcess(
      argc,
      argv,
      "shot",
      "Finds known objects in depth images with SHOT descriptors and RANSAC.",
      [](vantage::Bus& bus, vantage::ConfigReader& config, const vantage::ProcessOptions& options) {
        return vantage::MakeShotNode(bus, config, options);
      });
}
