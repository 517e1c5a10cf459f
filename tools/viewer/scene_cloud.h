#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/so3.h"
#include "tools/support/color.h"

namespace vantage {

/// A measured point of the scene.
struct CloudPoint {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();  ///< m, world
  float depth = 0.0F;                                  ///< m, along the axis of its camera
  Rgb color;                                           ///< as its camera saw it
};

/// What one image added to the cloud; never changed once made.
struct CloudChunk {
  std::vector<CloudPoint> points;
  bool has_color = false;  ///< else the points' colors say nothing
};

/// The color of a depth pixel.
using PixelColor = std::function<Rgb(int u, int v)>;

/// Depth images of several places in one cloud: one point a voxel, and no more points in all than
/// is allowed; the images that were added first go. Copies share their points.
class SceneCloud {
 public:
  struct Parameters {
    double voxel = 0.004;         ///< m, side of the cube that holds one point
    size_t max_points = 150'000;  ///< in all images together
    double max_depth = 4.0;       ///< m, what is farther is left out
  };

  SceneCloud() = default;
  explicit SceneCloud(const Parameters& parameters) : parameters_(parameters) {}

  /// Adds what no earlier image has shown. An image of another size than the camera's adds nothing.
  /// @param color may be empty.
  void Add(const DepthImage& depth,
           const CameraModel& camera,
           const Pose& T_world_camera,
           const PixelColor& color);
  void Clear() { chunks_.clear(); }

  [[nodiscard]] const std::vector<std::shared_ptr<const CloudChunk>>& chunks() const {
    return chunks_;
  }
  [[nodiscard]] size_t num_points() const;

 private:
  Parameters parameters_;
  std::vector<std::shared_ptr<const CloudChunk>> chunks_;  // The oldest first.
};

}  // namespace vantage
