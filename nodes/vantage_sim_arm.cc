// vantage-sim-arm: the simulated robot that carries the simulated camera.
#include "nodes/process.h"
#include "nodes/sim_arm_node.h"

int main(int argc, char** argv) {
  return vantage::RunProcess(argc,
                             argv,
                             "sim-arm",
                             "Carries the simulated camera where NEXT_VIEW says.",
                             vantage::MakeSimArmNode);
}
