#include "nodes/object_refinement_config.h"

namespace vantage {

ObjectRefinementConfig ReadObjectRefinementConfig(ConfigReader& config) {
  ObjectRefinementConfig result;
  MultiViewParameters& parameters = result.parameters;
  ConfigReader::Table table = config.Root().Sub("fusion").Sub("refinement");
  const auto read_scaled =
      [&table](const char* key, double unit, double lowest, double highest, double* value) {
        double scaled = *value / unit;
        table.Read(key, &scaled, lowest, highest);
        *value = scaled * unit;
      };
  table.Read("camera", &result.camera);
  table.Read("most_views", &result.most_views, 2, 100);
  parameters.min_views = 3;
  table.Read("min_views", &parameters.min_views, 2, 100);
  table.Read("settled_share", &result.settled_share, 0.0, 1.0);
  read_scaled("max_rotation_deg", kDegree, 0.01, 45.0, &result.max_rotation);
  read_scaled("max_translation_mm", 1e-3, 0.01, 1000.0, &result.max_translation);
  read_scaled("robot_rotation_deg", kDegree, 1e-4, 10.0, &parameters.camera_rotation);
  read_scaled("robot_translation_mm", 1e-3, 1e-4, 1000.0, &parameters.camera_translation);
  read_scaled("marker_rotation_deg", kDegree, 0.0, 10.0, &parameters.view_rotation);
  read_scaled("marker_translation_mm", 1e-3, 0.0, 1000.0, &parameters.view_translation);
  table.Read("adjust_hand_eye", &parameters.adjust_hand_eye);
  return result;
}

}  // namespace vantage
