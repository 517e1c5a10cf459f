#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "common/gray_image.h"
#include "common/result.h"
#include "common/so3.h"
#include "common/triangle_mesh.h"

namespace vantage {

/// A level rectangle, its sides along the world's x and y: the table top, or the floor.
struct SimPlane {
  double height = 0.0;                               ///< m, z in the world
  Eigen::Vector2d size{1.2, 1.2};                    ///< m, along x and y
  Eigen::Vector2d center = Eigen::Vector2d::Zero();  ///< m, x and y in the world

  /// Size in 0.01..100 m, height and center within 100 m.
  Result<void> Validate() const;
};

/// An object that stands in the scene.
struct SimObject {
  std::string model_id;
  TriangleMesh mesh;  ///< m, in the model's frame
  Pose T_world_object = Pose::Identity();
};

/// A flat printed board, e.g. a calibration target.
struct SimBoard {
  Pose T_world_board = Pose::Identity();  ///< origin in its middle, x and y as the print's
  Eigen::Vector2d size{0.2, 0.2};         ///< m, along x and y
  GrayImage print;                        ///< over its whole size; (0, 0) at the lowest x and y
  double blur = 0.5;                      ///< px, sigma of the lens's blur
  double noise = 1.5;                     ///< of 255, sigma of the color image's noise
};

/// What the simulated camera looks at.
struct SimScene {
  std::optional<SimPlane> table;
  std::optional<SimPlane> floor;
  std::vector<SimObject> objects;
  std::optional<SimBoard> board;
};

}  // namespace vantage
