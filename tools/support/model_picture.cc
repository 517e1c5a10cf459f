#include "tools/support/model_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/camera_model.h"
#include "tools/support/shaded_scene.h"

namespace vantage {

RgbImage RenderModelPicture(const ObjectModel& model) {
  constexpr int kSide = 480;                       // px
  constexpr double kFieldOfView = 30.0 * kDegree;  // rad
  const CameraModel camera = CameraFromFieldOfView(kSide, kSide, kFieldOfView, kFieldOfView);
  const Eigen::AlignedBox3d box = model.mesh.Bounds().cast<double>();
  const Eigen::Vector3d foot(box.center().x(), box.center().y(), box.min().z());
  const TriangleMesh table =
      TableMesh(foot, 16.0 * model.diameter, 16.0 * model.diameter, 0.1 * model.diameter);
  ShadedScene scene;
  scene.items.push_back({&table, Pose::Identity(), Rgb{225, 223, 218}});
  scene.items.push_back({&model.mesh, Pose::Identity(), Rgb{96, 140, 190}});

  RgbImage both{2 * kSide, kSide, {}};
  both.rgb.resize(static_cast<size_t>(3 * both.width * both.height));
  const double distance = 1.25 * model.diameter / (2.0 * std::tan(0.5 * kFieldOfView));
  const std::array<Eigen::Vector3d, 2> directions = {Eigen::Vector3d(0.55, -0.75, 0.55),
                                                     Eigen::Vector3d(-0.75, 0.35, 0.85)};
  for (size_t side = 0; side < directions.size(); ++side) {
    const Eigen::Vector3d eye = box.center() + distance * directions[side].normalized();
    const RgbImage picture = RenderShaded(scene, camera, LookAt(eye, box.center()));
    constexpr size_t kRow = 3 * kSide;  // bytes
    for (size_t row = 0; row < kSide; ++row) {
      std::copy_n(picture.rgb.begin() + static_cast<std::ptrdiff_t>(row * kRow),
                  kRow,
                  both.rgb.begin() + static_cast<std::ptrdiff_t>((2 * row + side) * kRow));
    }
  }
  return both;
}

}  // namespace vantage
