#include "tests/bench/table_frames.h"

#include <cmath>

#include "drivers/sim/scene_renderer.h"
#include "drivers/sim/sensor_model.h"
#include "perception/model/model_generator.h"

namespace vantage {

TableFrame MakeTableFrame(int number) {
  SimScene scene;
  scene.table = SimPlane{};
  scene.floor = SimPlane{-0.7, {6.0, 6.0}, {0.0, 0.0}};
  for (const char* name : {"filter", "mug", "bracket"}) {
    const double around = 2.1 * static_cast<double>(scene.objects.size());
    const Pose T(Eigen::Translation3d(0.16 * std::cos(around), 0.16 * std::sin(around), 0.0) *
                 Eigen::AngleAxisd(0.7 * number + around, Eigen::Vector3d::UnitZ()));
    scene.objects.push_back({name, GenerateObject(name).value().mesh, T});
  }
  const double azimuth = 0.83 * number;
  const double elevation = (30.0 + 13.0 * (number % 4)) * kDegree;
  const Pose T_world_camera = LookAt(0.75 * Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                                                            std::cos(elevation) * std::sin(azimuth),
                                                            std::sin(elevation)),
                                     Eigen::Vector3d(0.0, 0.0, 0.04));
  TableFrame frame;
  SceneRenderer renderer(scene, frame.camera);
  SensorModelParameters parameters;
  parameters.device_id = static_cast<uint64_t>(number);
  SensorModel sensor(parameters, frame.camera);
  sensor.Measure(renderer.Render(T_world_camera), number, 0.0, &frame.depth);
  for (const SimObject& object : scene.objects) {
    frame.T_camera_object.push_back(T_world_camera.inverse() * object.T_world_object);
  }
  return frame;
}

}  // namespace vantage
