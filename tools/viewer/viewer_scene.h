#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/so3.h"
#include "common/triangle_mesh.h"
#include "perception/model/object_model.h"
#include "tools/support/color.h"
#include "tools/viewer/viewer_options.h"
#include "tools/viewer/viewer_state.h"

namespace vantage {

/// A surface in the scene.
struct SceneMesh {
  std::shared_ptr<const TriangleMesh> mesh;
  Pose T_world_mesh = Pose::Identity();
  Rgb color;
  double opacity = 1.0;
  bool on_top = false;  ///< seen through what is before it
};

struct SceneLine {
  std::vector<Eigen::Vector3f> points;  ///< m, world; joined one to the next
  Rgb color;
  double width_px = 1.5;
  bool on_top = false;
};

struct SceneDots {
  std::vector<Eigen::Vector3f> points;  ///< m, world
  std::vector<Rgb> colors;              ///< as many
  double size_px = 3.0;
};

struct SceneLabel {
  Eigen::Vector3d at = Eigen::Vector3d::Zero();  ///< m, world
  std::string text;
  Rgb color;
};

/// Lowest and highest value of a color scale.
struct ScaleRange {
  double low = 0.0;
  double high = 0.0;
};

/// All that is drawn in three dimensions; knows nothing of how.
struct ViewerScene {
  std::vector<SceneMesh> meshes;
  std::vector<SceneLine> lines;
  std::vector<SceneDots> dots;  ///< the cloud, one an image, and candidates
  std::vector<SceneLabel> labels;
  std::optional<ScaleRange> cloud_scale;  ///< m; absent: colors of images, or no cloud
  bool cloud_by_depth = false;            ///< else by height
  std::optional<ScaleRange> gain_scale;   ///< of the candidates' gain
  std::vector<Eigen::Vector3d> overview;  ///< m, world, what a wide view should hold
  std::vector<Eigen::Vector3d> closeup;   ///< m, world, about the chosen object
};

using ModelMap = std::map<std::string, std::shared_ptr<const ObjectModel>>;

ViewerScene BuildScene(const ViewerState& state,
                       const ModelMap& models,
                       const ViewerOptions& options);

/// The object whose orientation is shown; null when there is none.
const ShownObject* ChosenObject(const ViewerState& state, const ViewerOptions& options);

/// Color of an object in all panels.
Rgb ColorOfInstance(int32_t instance);
/// Color of a candidate: t = 0 at the lowest gain shown, 1 at the highest.
Rgb GainColor(double t);
inline constexpr Rgb kUnreachableColor{196, 198, 204};
inline constexpr Rgb kChosenColor{200, 22, 96};
inline constexpr Rgb kCameraColor{44, 62, 92};

/// An ellipsoid whose semi-axes are `sigmas` standard deviations.
TriangleMesh EllipsoidMesh(const Eigen::Vector3d& center,
                           const Eigen::Matrix3d& covariance,
                           double sigmas);

/// A cone from `center` over the places to which an axis' tip goes by rotation vectors within
/// `sigmas` standard deviations of `covariance` (rad^2, world).
/// @param arm m, world, from the center to the tip
TriangleMesh AxisConeMesh(const Eigen::Vector3d& center,
                          const Eigen::Vector3d& arm,
                          const Eigen::Matrix3d& covariance,
                          double sigmas);

}  // namespace vantage
