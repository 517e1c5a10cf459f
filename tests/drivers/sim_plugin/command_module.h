#pragma once

#include "common/camera_model.h"
#include "common/so3.h"
#include "drivers/sim/scene.h"

namespace vantage {

// What the test and the plugin must agree on; the test calls sim_test_* through dlsym:
//   void sim_test_set_pose(double azimuth, double elevation, double radius);  // rad, rad, m
//   void sim_test_fault(int kind, double duration);                           // SimFault, s
//   void sim_test_abilities(const SimAbilities* abilities);                   // at next opening
inline constexpr char kTestSerial[] = "TEST0001";
inline const Eigen::Vector3d kTestTarget(0.02, -0.01, 0.05);

/// A table with a tetrahedron on it: no symmetry that could hide a flipped image.
inline SimScene TestScene() {
  SimScene scene;
  scene.table = SimPlane{.height = 0.0, .size = {0.9, 0.7}};
  SimObject object;
  object.model_id = "tetrahedron";
  object.mesh.vertices = {
      {0.0F, 0.0F, 0.0F}, {0.2F, 0.0F, 0.0F}, {0.0F, 0.12F, 0.0F}, {0.0F, 0.0F, 0.15F}};
  object.mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  scene.objects.push_back(object);
  return scene;
}

}  // namespace vantage
