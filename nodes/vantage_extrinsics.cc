// vantage-extrinsics: where the camera is, from where the robot's hand is and a hand-eye
// calibration, and whether that still holds.
#include "nodes/extrinsics_node.h"
#include "nodes/process.h"

int main(int argc, char** argv) {
  return vantage::RunProcess(
      argc,
      argv,
      "extrinsics",
      "Publishes the camera's pose by the hand-eye calibration, and checks whether that holds.",
      vantage::MakeExtrinsicsNode);
}
