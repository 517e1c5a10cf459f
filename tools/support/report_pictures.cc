#include "tools/support/report_pictures.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "fusion/so3_grid.h"
#include "tools/support/color.h"
#include "tools/support/depth_view.h"
#include "tools/support/shaded_scene.h"
#include "tools/support/sphere_renderer.h"

namespace vantage {
namespace {

constexpr Rgb kTableColor{214, 207, 196};
constexpr Rgb kCameraColor{44, 62, 92};
constexpr Rgb kPathColor{120, 142, 178};

CameraModel PictureCamera(int width, int height) {
  CameraModel camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = 1.15 * width;
  camera.cx = 0.5 * (width - 1);
  camera.cy = 0.5 * (height - 1);
  return camera;
}

// Farther and farther from the scene until every point is in the picture.
Pose LookAtAll(const CameraModel& camera, const std::vector<Eigen::Vector3d>& points) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& point : points) box.extend(point);
  const Eigen::Vector3d target = box.center();
  const Eigen::Vector3d direction = Eigen::Vector3d(0.75, -1.0, 0.62).normalized();
  const double step = std::max(0.01, 0.02 * box.diagonal().norm());
  Pose T_world_camera = LookAt(target + step * direction, target);
  for (int i = 1; i < 1000; ++i) {
    T_world_camera = LookAt(target + i * step * direction, target);
    const Pose T_camera_world = T_world_camera.inverse();
    const bool all_in =
        std::all_of(points.begin(), points.end(), [&](const Eigen::Vector3d& point) {
          const Eigen::Vector3d p_camera = T_camera_world * point;
          if (p_camera.z() < 0.1) return false;
          const Eigen::Vector2d pixel = camera.Project(p_camera);
          const double margin = 0.06 * camera.width;
          return pixel.x() > margin && pixel.x() < camera.width - margin && pixel.y() > margin &&
                 pixel.y() < camera.height - margin;
        });
    if (all_in) break;
  }
  return T_world_camera;
}

}  // namespace

size_t ColorIndex(const RecordedRun& run, int32_t instance) {
  const auto& objects = run.views.back().objects.objects;
  for (size_t i = 0; i < objects.size(); ++i) {
    if (objects[i].instance_id == instance) return i;
  }
  return objects.size();
}

RgbImage ScenePicture(const RecordedRun& run, const ReportSetup& setup, SceneCut cut) {
  const CameraModel camera = PictureCamera(1000, 680);
  ShadedScene scene;
  std::vector<Eigen::Vector3d> points;
  TriangleMesh table;
  if (setup.table) {
    const SimPlane& plane = *setup.table;
    table = TableMesh(
        {plane.center.x(), plane.center.y(), plane.height}, plane.size.x(), plane.size.y(), 0.02);
    scene.items.push_back({&table, Pose::Identity(), kTableColor});
  }
  for (const object_estimate_v3_t& object : run.views.back().objects.objects) {
    const auto model = setup.models.find(object.model_id);
    const std::optional<Pose> pose = EstimatedPose(object);
    if (model == setup.models.end() || !pose || object.state != object_estimate_v3_t::CONFIRMED) {
      continue;
    }
    scene.items.push_back(
        {&model->second.mesh, *pose, ObjectColor(ColorIndex(run, object.instance_id))});
    const Eigen::AlignedBox3d bounds = model->second.mesh.Bounds().cast<double>();
    for (int corner = 0; corner < 8; ++corner) {
      points.push_back(*pose * bounds.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)));
    }
  }
  if (points.empty()) points = {{-0.2, -0.2, 0.0}, {0.2, 0.2, 0.2}};
  const RunView* previous = nullptr;
  for (const RunView& view : run.views) {
    if (view.utime == 0 || cut == SceneCut::kObjects) continue;
    const CameraModel seen = run.camera.value_or(CameraModel{});
    const auto lines = FrustumLines(seen, view.T_world_camera, 0.07, 1.6, kCameraColor);
    scene.lines.insert(scene.lines.end(), lines.begin(), lines.end());
    points.push_back(view.T_world_camera.translation());
    if (previous != nullptr) {
      scene.lines.push_back({previous->T_world_camera.translation(),
                             view.T_world_camera.translation(),
                             1.4,
                             kPathColor});
    }
    previous = &view;
  }
  return RenderShaded(scene, camera, LookAtAll(camera, points));
}

RgbImage ViewPicture(const RecordedRun& run, const RunView& view, const ReportSetup& setup) {
  std::vector<OutlinedModel> models;
  for (const object_estimate_v3_t& object : view.objects.objects) {
    const auto model = setup.models.find(object.model_id);
    const std::optional<Pose> pose = EstimatedPose(object);
    if (model == setup.models.end() || !pose) continue;
    models.push_back({&model->second.mesh,
                      view.T_world_camera.inverse() * *pose,
                      ObjectColor(ColorIndex(run, object.instance_id))});
  }
  return DrawDepthView(view.depth, *run.camera, models, 480, 360).image;
}

Eigen::Vector3d HistogramSide(const RecordedRun& run, int32_t instance) {
  for (const object_estimate_v3_t& object : run.views.back().objects.objects) {
    const std::optional<Pose> pose = EstimatedPose(object);
    if (object.instance_id != instance || !pose) continue;
    // A little from above, so that the poles are seen too.
    const Eigen::Vector3d peak = DirectionOfOrientation(Eigen::Quaterniond(pose->linear()));
    return peak + Eigen::Vector3d(0.0, 0.0, peak.z() < 0.0 ? -0.4 : 0.4);
  }
  return Eigen::Vector3d::Ones();
}

RgbImage HistogramPicture(const orientation_histogram_t& histogram,
                          const Eigen::Vector3d& towards) {
  std::vector<SphereSample> samples;
  if (histogram.k >= So3Grid::kSmallest && histogram.k <= So3Grid::kLargest) {
    const So3Grid grid(histogram.k);
    for (size_t i = 0; i < histogram.cell.size(); ++i) {
      const So3Grid::Cell cell = histogram.cell[i];
      if (!grid.IsValid(cell) || !std::isfinite(histogram.weight[i])) continue;
      const double weight = static_cast<double>(histogram.weight[i]) * grid.Area(cell);
      samples.push_back({DirectionOfOrientation(grid.Representative(cell)).cast<float>(),
                         static_cast<float>(weight)});
    }
  }
  SphereView view;
  view.towards = towards;
  return RenderSphereDensity(samples, view);
}

}  // namespace vantage
