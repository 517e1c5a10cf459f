#pragma once

#include <cmath>
#include <deque>
#include <vector>

#include "perception/refinement/multi_view_refiner.h"
#include "tests/perception/test_scenes.h"

namespace vantage {

/// An object, or several, and a table seen from around.
class MultiViewScene {
 public:
  explicit MultiViewScene(const TriangleMesh& mesh)
      : mesh_(mesh),
        drawable_(mesh),
        shape_{drawable_, mesh.SurfaceCentroid(), mesh.Diameter(), mesh.Diameter()} {}

  void Place(const Pose& T_world_object) { objects_.push_back(T_world_object); }

  /// Views evenly around at changing elevations, with noise of `sigma` m at 1 m. What the robot
  /// tells is the true camera but for `error` from the right.
  void LookAround(int count, double sigma, const Pose& error, Rng& rng) {
    const CameraModel camera = SmallCamera();
    DepthRasterizer rasterizer(camera);
    const TriangleMesh table = MakeTable(1.0F);
    for (int i = 0; i < count; ++i) {
      const double azimuth = 6.28 * (i + rng.Uniform(0.0, 0.5)) / count;
      const double elevation = (35.0 + 25.0 * (i % 3)) * kDegree;
      const Eigen::Vector3d target(0.05, 0.03, 0.03);
      const Eigen::Vector3d eye =
          target + 0.5 * Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                                         std::cos(elevation) * std::sin(azimuth),
                                         std::sin(elevation));
      const Pose T_world_camera =
          LookAt(eye, target) *
          Pose(Eigen::AngleAxisd(rng.Uniform(0.0, 6.28), Eigen::Vector3d::UnitZ()));
      rasterizer.Clear();
      const Pose T_camera_world = T_world_camera.inverse();
      rasterizer.Draw(table, T_camera_world);
      for (const Pose& T_world_object : objects_)
        rasterizer.Draw(mesh_, T_camera_world * T_world_object);
      images_.push_back(ToImage(rasterizer));
      if (sigma > 0.0) AddNoise(camera.fx, sigma, 0.0, rng, &images_.back());
      views_.push_back({camera, T_world_camera * error.inverse(), &images_.back()});
    }
  }

  /// Off by an angle (rad) and a distance (m) in random directions.
  [[nodiscard]] RefinementStart Start(size_t object,
                                      double angle,
                                      double distance,
                                      Rng& rng) const {
    const Eigen::Vector3d center = objects_[object] * shape_.center;
    const Pose motion(Eigen::Translation3d(center + distance * rng.UnitVector()) *
                      ExpSo3(angle * rng.UnitVector()) * Eigen::Translation3d(-center));
    RefinementStart start{shape_, {}, motion * objects_[object], {}};
    for (size_t i = 0; i < views_.size(); ++i) start.views.push_back(i);
    return start;
  }

  [[nodiscard]] double AngleOff(size_t object, const Pose& T) const {
    return GeodesicAngle(Eigen::Quaterniond(objects_[object].linear()),
                         Eigen::Quaterniond(T.linear()));
  }
  [[nodiscard]] double DistanceOff(size_t object, const Pose& T) const {
    return (objects_[object] * shape_.center - T * shape_.center).norm();
  }
  /// Rotation vector and translation of the center from T to the truth, in the world's axes.
  [[nodiscard]] Vector6 Error(size_t object, const Pose& T) const {
    Vector6 error;
    error << LogSo3(Eigen::Quaterniond(objects_[object].linear() * T.linear().transpose())),
        objects_[object] * shape_.center - T * shape_.center;
    return error;
  }

  [[nodiscard]] const ModelShape& shape() const { return shape_; }
  [[nodiscard]] const std::vector<Pose>& objects() const { return objects_; }
  std::vector<RefinementView>& views() { return views_; }
  std::deque<DepthImage>& images() { return images_; }

 private:
  TriangleMesh mesh_;
  DrawableMesh drawable_;
  ModelShape shape_;
  std::vector<Pose> objects_;
  std::deque<DepthImage> images_;
  std::vector<RefinementView> views_;
};

/// Noise of the tests is a pixel's own.
inline MultiViewParameters WhiteNoise() {
  MultiViewParameters parameters;
  parameters.correlation_px = 0.1;
  return parameters;
}

}  // namespace vantage
