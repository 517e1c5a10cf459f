#include "tools/evaluate/scene_crop_dataset.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "common/format.h"
#include "perception/model/mesh_check.h"
#include "perception/model/model_builder.h"
#include "tools/evaluate/dataset_pcd.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr const char* kModelFile = "milk.pcd";
constexpr double kFocal = 525.0;  // px, PCL's for a Kinect
constexpr uint32_t kNoVertex = 0xffffffffU;

// The cloud has y up and z backwards.
Pose CameraFromScene() {
  Pose T = Pose::Identity();
  T.linear().diagonal() << 1.0, -1.0, -1.0;
  return T;
}

// The crop's place in the scene is its publisher's; every point is checked against it.
Pose CameraFromModel() {
  Pose T = Pose::Identity();
  Eigen::Matrix3d R;
  R << 0.968879414, -0.119712210, 0.216660259, 0.116826833, 0.992808636, 0.026124781, -0.218229631,
      -3.0e-8, 0.975897447;
  T.linear() = Eigen::Quaterniond(R).normalized().toRotationMatrix();
  T.translation() = Eigen::Vector3d(-0.15896556, 0.21249808, -0.04212537);
  return CameraFromScene() * T;
}

Result<fs::path> FindScene(const fs::path& folder) {
  std::vector<fs::path> scenes;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".pcd" && entry.path().filename() != kModelFile) {
      scenes.push_back(entry.path());
    }
  }
  if (scenes.size() == 1) return scenes.front();
  return Error{ErrorCode::kNotFound,
               Format("%s has %zu point clouds beside %s, expected one, the scene",
                      folder.c_str(),
                      scenes.size(),
                      kModelFile)};
}

// Points in the camera's frame.
Result<PointCloud> ReadScene(const fs::path& file) {
  Result<PointCloud> cloud = ReadPcd(file);
  if (!cloud) return cloud;
  const Eigen::Matrix3f R = CameraFromScene().linear().cast<float>();
  for (Eigen::Vector3f& point : cloud->points) point = R * point;
  return cloud;
}

// The image that an organised cloud was made of.
Result<DepthImage> DepthOfCloud(const fs::path& file,
                                const PointCloud& cloud,
                                const CameraModel& camera) {
  constexpr double kSlack = 0.5;  // px
  DepthImage image(cloud.width, cloud.height);
  size_t measured = 0;
  for (int v = 0; v < cloud.height; ++v) {
    for (int u = 0; u < cloud.width; ++u) {
      const Eigen::Vector3f& point = cloud.points[image.Index(u, v)];
      if (!point.allFinite() || !(point.z() > 0.0F)) continue;
      const Eigen::Vector2d pixel = camera.Project(point.cast<double>());
      if ((pixel - Eigen::Vector2d(u, v)).cwiseAbs().maxCoeff() > kSlack) {
        return Error{ErrorCode::kCorrupt,
                     Format("%s: the point of pixel (%d, %d) is seen at (%.1f, %.1f), expected "
                            "points on their lines of sight for fx = fy = %g",
                            file.c_str(),
                            u,
                            v,
                            pixel.x(),
                            pixel.y(),
                            kFocal)};
      }
      image.at(u, v) = point.z();
      ++measured;
    }
  }
  if (measured == 0) {
    return Error{ErrorCode::kCorrupt, Format("%s has no points", file.c_str())};
  }
  return image;
}

// The scene's pixel of each of the model's points.
Result<std::vector<uint32_t>> PixelsOfModel(const fs::path& file,
                                            const PointCloud& model,
                                            const PointCloud& scene,
                                            const CameraModel& camera) {
  constexpr double kSame = 1e-5;  // m
  const Pose T_camera_model = CameraFromModel();
  std::vector<uint32_t> pixels;
  for (size_t i = 0; i < model.points.size(); ++i) {
    const Eigen::Vector3d p = T_camera_model * model.points[i].cast<double>();
    const Eigen::Vector2d seen = p.z() > 0.0 ? camera.Project(p) : Eigen::Vector2d(-1.0, -1.0);
    const bool is_inside = p.allFinite() && seen.x() > -0.5 && seen.y() > -0.5 &&
                           seen.x() < camera.width - 0.5 && seen.y() < camera.height - 0.5;
    const auto pixel =
        is_inside
            ? static_cast<size_t>(std::lround(seen.y()) * camera.width + std::lround(seen.x()))
            : 0;
    if (!is_inside || !((scene.points[pixel].cast<double>() - p).norm() < kSame)) {
      return Error{ErrorCode::kCorrupt,
                   Format("%s: point %zu is not one of the scene's, expected a model cut out of it",
                          file.c_str(),
                          i)};
    }
    pixels.push_back(static_cast<uint32_t>(pixel));
  }
  std::sort(pixels.begin(), pixels.end());
  return pixels;
}

// Joins neighboring pixels of the object, but not across steps in depth.
TriangleMesh JoinPixels(const std::vector<uint32_t>& pixels,
                        const PointCloud& scene,
                        const Pose& T_model_camera) {
  constexpr float kStep = 0.01F;  // m
  const auto width = static_cast<uint32_t>(scene.width);
  TriangleMesh mesh;
  std::vector<uint32_t> vertex_of(scene.points.size(), kNoVertex);
  for (const uint32_t pixel : pixels) {
    vertex_of[pixel] = static_cast<uint32_t>(mesh.vertices.size());
    mesh.vertices.emplace_back((T_model_camera * scene.points[pixel].cast<double>()).cast<float>());
  }
  const auto join = [&](const std::array<uint32_t, 3>& corners) {
    std::array<uint32_t, 3> triangle{};
    float nearest = std::numeric_limits<float>::max();
    float farthest = 0.0F;
    for (size_t i = 0; i < 3; ++i) {
      triangle[i] = vertex_of[corners[i]];
      if (triangle[i] == kNoVertex) return;
      nearest = std::min(nearest, scene.points[corners[i]].z());
      farthest = std::max(farthest, scene.points[corners[i]].z());
    }
    if (farthest - nearest < kStep) mesh.triangles.push_back(triangle);
  };
  for (const uint32_t pixel : pixels) {
    if (pixel % width + 1 == width || pixel + width + 1 >= scene.points.size()) continue;
    // Counter-clockwise for the camera: its image's y axis is down.
    join({pixel, pixel + width, pixel + 1});
    join({pixel + 1, pixel + width, pixel + width + 1});
  }
  return mesh;
}

}  // namespace

bool IsSceneCropDataset(const fs::path& folder) {
  std::error_code error;
  return fs::exists(folder / kModelFile, error);
}

Result<Dataset> LoadSceneCropDataset(const fs::path& folder) {
  const Result<fs::path> scene_file = FindScene(folder);
  if (!scene_file) return scene_file.error();
  const Result<PointCloud> scene = ReadScene(*scene_file);
  if (!scene) return scene.error();
  const Result<PointCloud> model_points = ReadPcd(folder / kModelFile);
  if (!model_points) return model_points.error();
  CameraModel camera;
  camera.width = scene->width;
  camera.height = scene->height;
  camera.fx = kFocal;
  camera.fy = kFocal;
  if (Result<void> valid = camera.Validate(); !valid) {
    return Error{valid.error().code, scene_file->string() + ": " + valid.error().message};
  }
  Result<DepthImage> depth = DepthOfCloud(*scene_file, *scene, camera);
  if (!depth) return depth.error();
  const Result<std::vector<uint32_t>> pixels =
      PixelsOfModel(folder / kModelFile, *model_points, *scene, camera);
  if (!pixels) return pixels.error();
  TriangleMesh mesh = JoinPixels(*pixels, *scene, CameraFromModel().inverse());
  const Result<MeshMending> mended = CheckAndMendMesh(&mesh);
  if (!mended) {
    return Error{mended.error().code,
                 (folder / kModelFile).string() + ": " + mended.error().message};
  }
  Result<ObjectModel> model =
      BuildObjectModel("milk", std::move(mesh), SymmetryGroup::None(), kModelFile, {});
  if (!model) return model.error();
  Dataset dataset;
  dataset.what =
      "One Kinect image of a table and a model that was cut out of it: a check that the parts fit, "
      "not of accuracy.";
  dataset.models.push_back(std::move(model).value());
  DatasetView view;
  view.name = scene_file->stem().string();
  view.camera = camera;
  view.depth = std::move(depth).value();
  view.objects.push_back({0, CameraFromModel(), std::nullopt, *pixels});
  dataset.views.push_back(std::move(view));
  return dataset;
}

}  // namespace vantage
