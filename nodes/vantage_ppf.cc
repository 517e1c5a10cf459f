// vantage-ppf: finds known objects in the depth images of a camera at rest.
#include "nodes/estimator_node.h"
#include "nodes/process.h"

int main(int argc, char** argv) {
  return vantage::RunProcess(
      argc,
      argv,
      "ppf",
      "Finds known objects in depth images with point pair features.",
      [](vantage::Bus& bus, vantage::ConfigReader& config, const vantage::ProcessOptions& options) {
        return vantage::MakePpfNode(bus, config, options);
      });
}
