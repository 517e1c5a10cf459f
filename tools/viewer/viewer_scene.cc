#include "tools/viewer/viewer_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/format.h"
#include "tools/support/shaded_scene.h"

namespace vantage {
namespace {

constexpr Rgb kAxisColors[3] = {{208, 46, 46}, {44, 150, 60}, {40, 84, 208}};
constexpr Rgb kPathColor{120, 142, 178};
constexpr Rgb kGridColor{206, 208, 212};
constexpr double kLeastGhost = 0.05;   // Weight of a peak that is shown beside the first.
constexpr double kPlaceholder = 0.06;  // m, size of a model that is not known

class SceneBuilder {
 public:
  SceneBuilder(const ViewerState& state, const ModelMap& models, const ViewerOptions& options)
      : state_(state), models_(models), options_(options) {}

  ViewerScene Build() {
    AddGround();
    if (options_.show_cloud) AddCloud();
    for (const ShownObject& object : state_.objects().objects) AddObject(object);
    for (const ShownDetection& detection : state_.detections().detections) {
      AddDetection(detection);
    }
    AddCameras();
    AddSteps();
    if (options_.show_candidates) AddPlan();
    SetViews();
    return std::move(scene_);
  }

 private:
  void AddGround();
  void AddCloud();
  void AddObject(const ShownObject& object);
  void AddUncertainty(const ShownObject& object, const Eigen::Vector3d& center, double size);
  void AddDetection(const ShownDetection& detection);
  void AddCameras();
  void AddSteps();
  void AddPlan();
  void SetViews();
  void AddFrustum(const CameraModel& camera,
                  const Pose& T_world_camera,
                  double depth,
                  double width_px,
                  Rgb color);
  [[nodiscard]] const ObjectModel* ModelOf(const std::string& id) const {
    const auto found = models_.find(id);
    return found == models_.end() ? nullptr : found->second.get();
  }
  [[nodiscard]] CameraModel AnyCamera() const {
    for (const auto& [name, camera] : state_.cameras()) {
      if (camera.model) return *camera.model;
    }
    return {};
  }

  const ViewerState& state_;
  const ModelMap& models_;
  const ViewerOptions& options_;
  ViewerScene scene_;
};

void SceneBuilder::AddGround() {
  constexpr int kCells = 12;
  constexpr float kCell = 0.1F;  // m
  constexpr float kHalf = 0.5F * kCell * kCells;
  const auto z = static_cast<float>(options_.table_height);
  for (int i = 0; i <= kCells; ++i) {
    const float at = -kHalf + kCell * static_cast<float>(i);
    scene_.lines.push_back({{{at, -kHalf, z}, {at, kHalf, z}}, kGridColor, 1.0, false});
    scene_.lines.push_back({{{-kHalf, at, z}, {kHalf, at, z}}, kGridColor, 1.0, false});
  }
  constexpr float kAxis = 0.12F;  // m
  static constexpr const char* kNames[3] = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3f tip = kAxis * Eigen::Vector3f::Unit(axis);
    scene_.lines.push_back({{Eigen::Vector3f::Zero(), tip}, kAxisColors[axis], 2.5, false});
    scene_.labels.push_back({1.12 * tip.cast<double>(), kNames[axis], kAxisColors[axis]});
  }
}

void SceneBuilder::AddCloud() {
  const auto& chunks = state_.cloud().chunks();
  const bool any_color =
      std::any_of(chunks.begin(), chunks.end(), [](const auto& chunk) { return chunk->has_color; });
  const bool by_image = options_.cloud_color == CloudColor::kImage && any_color;
  scene_.cloud_by_depth = options_.cloud_color == CloudColor::kDepth;
  const auto value = [&](const CloudPoint& point) {
    return scene_.cloud_by_depth ? point.depth : point.position.z();
  };
  // From the 1st to the 99th percentile: a few strays do not use the scale up.
  std::vector<float> values;
  for (const auto& chunk : chunks) {
    for (const CloudPoint& point : chunk->points) values.push_back(value(point));
  }
  if (values.empty()) return;
  std::sort(values.begin(), values.end());
  const ScaleRange range{static_cast<double>(values[values.size() / 100]),
                         static_cast<double>(values[values.size() - 1 - values.size() / 100])};
  if (!by_image) scene_.cloud_scale = range;
  const double span = std::max(1e-3, range.high - range.low);
  for (const auto& chunk : chunks) {
    SceneDots dots;
    dots.size_px = 2.0;
    for (const CloudPoint& point : chunk->points) {
      dots.points.push_back(point.position);
      const double t = (static_cast<double>(value(point)) - range.low) / span;
      dots.colors.push_back(by_image && chunk->has_color ? point.color : DepthColor(0.1 + 0.8 * t));
    }
    scene_.dots.push_back(std::move(dots));
  }
}

void SceneBuilder::AddObject(const ShownObject& object) {
  const ObjectModel* model = ModelOf(object.model_id);
  const Rgb color = ColorOfInstance(object.instance);
  const bool is_believed = object.state == object_estimate_v3_t::CONFIRMED;
  const Pose T_world_object = object.PoseOfPeak(0);
  Eigen::Vector3d center = T_world_object.translation();
  double size = kPlaceholder;
  if (model != nullptr) {
    const auto found = models_.find(object.model_id);
    const std::shared_ptr<const TriangleMesh> mesh(found->second, &found->second->mesh);
    center = T_world_object * model->center;
    size = model->diameter;
    scene_.meshes.push_back({mesh, T_world_object, color, is_believed ? 1.0 : 0.45, false});
    for (size_t i = 1; i < object.peaks.size(); ++i) {
      if (object.peaks[i].weight < kLeastGhost) continue;
      // About the model's center: that is what the position is known of.
      Pose ghost = object.PoseOfPeak(i);
      ghost.translation() = center - ghost.linear() * model->center;
      scene_.meshes.push_back({mesh,
                               ghost,
                               Mix(color, {255, 255, 255}, 0.3),
                               0.12 + 0.4 * object.peaks[i].weight,
                               false});
    }
  }
  std::string text = Format("%d %s", object.instance, object.model_id.c_str());
  if (model == nullptr) text += " (no model)";
  if (!is_believed) text += object.state == object_estimate_v3_t::LOST ? " lost" : " tentative";
  scene_.labels.push_back(
      {center + Eigen::Vector3d(0.0, 0.0, 0.8 * size), text, Mix(color, {0, 0, 0}, 0.3)});
  if (options_.show_uncertainty) AddUncertainty(object, center, size);
}

void SceneBuilder::AddUncertainty(const ShownObject& object,
                                  const Eigen::Vector3d& center,
                                  double size) {
  if (object.position_covariance.trace() > 0.0) {
    scene_.meshes.push_back({std::make_shared<const TriangleMesh>(EllipsoidMesh(
                                 center, object.position_covariance, options_.ellipsoid_sigmas)),
                             Pose::Identity(),
                             {250, 250, 252},
                             0.55,
                             true});
  }
  const Eigen::Matrix3d axes = object.PoseOfPeak(0).linear();
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d arm = 0.75 * size * axes.col(axis);
    scene_.lines.push_back(
        {{center.cast<float>(), (center + arm).cast<float>()}, kAxisColors[axis], 2.0, true});
    const Eigen::Matrix3d& covariance = object.peaks.front().covariance;
    if (!(covariance.trace() > 0.0)) continue;
    scene_.meshes.push_back({std::make_shared<const TriangleMesh>(
                                 AxisConeMesh(center, arm, covariance, options_.cone_sigmas)),
                             Pose::Identity(),
                             kAxisColors[axis],
                             0.35,
                             true});
  }
}

// The model's box, as the detection places it.
void SceneBuilder::AddDetection(const ShownDetection& detection) {
  const ObjectModel* model = ModelOf(detection.model_id);
  Eigen::AlignedBox3f box(Eigen::Vector3f::Constant(-0.5F * static_cast<float>(kPlaceholder)),
                          Eigen::Vector3f::Constant(0.5F * static_cast<float>(kPlaceholder)));
  if (model != nullptr) box = model->mesh.Bounds();
  const auto corner = [&](int i) -> Eigen::Vector3f {
    const Eigen::Vector3f p = box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(i));
    return (detection.T_world_object * p.cast<double>()).cast<float>();
  };
  constexpr Rgb kDetection{60, 64, 74};
  for (int i = 0; i < 8; ++i) {
    for (const int axis : {1, 2, 4}) {
      if ((i & axis) == 0) {
        scene_.lines.push_back({{corner(i), corner(i | axis)}, kDetection, 1.2, false});
      }
    }
  }
}

void SceneBuilder::AddFrustum(const CameraModel& camera,
                              const Pose& T_world_camera,
                              double depth,
                              double width_px,
                              Rgb color) {
  for (const ShadedLine& line : FrustumLines(camera, T_world_camera, depth, width_px, color)) {
    scene_.lines.push_back(
        {{line.from.cast<float>(), line.to.cast<float>()}, color, line.width_px, false});
  }
}

void SceneBuilder::AddCameras() {
  for (const auto& [name, camera] : state_.cameras()) {
    if (camera.path.size() > 1) scene_.lines.push_back({camera.path, kPathColor, 1.6, false});
    if (!camera.T_world_camera) continue;
    AddFrustum(
        camera.model.value_or(CameraModel{}), *camera.T_world_camera, 0.12, 2.6, kCameraColor);
    scene_.labels.push_back(
        {*camera.T_world_camera * Eigen::Vector3d(0.0, -0.07, 0.0), name, kCameraColor});
  }
}

void SceneBuilder::AddSteps() {
  for (const ShownStep& step : state_.steps()) {
    if (!step.T_world_camera) continue;
    AddFrustum(AnyCamera(), *step.T_world_camera, 0.05, 1.2, kPathColor);
    scene_.labels.push_back({*step.T_world_camera * Eigen::Vector3d(0.0, -0.03, 0.0),
                             Format("%d", step.viewpoint + 1),
                             kPathColor});
  }
}

void SceneBuilder::AddPlan() {
  const ShownPlan& plan = state_.plan();
  SceneDots reachable;
  SceneDots unreachable;
  reachable.size_px = 5.0;
  unreachable.size_px = 3.0;
  ScaleRange range;
  bool any = false;
  for (const ShownCandidate& candidate : plan.candidates) {
    if (!candidate.reachable) continue;
    range.low = any ? std::min(range.low, candidate.gain) : candidate.gain;
    range.high = any ? std::max(range.high, candidate.gain) : candidate.gain;
    any = true;
  }
  const double span = range.high - range.low;
  for (const ShownCandidate& candidate : plan.candidates) {
    SceneDots& dots = candidate.reachable ? reachable : unreachable;
    dots.points.push_back(candidate.T_world_camera.translation().cast<float>());
    const double t = span > 0.0 ? (candidate.gain - range.low) / span : 1.0;
    dots.colors.push_back(candidate.reachable ? GainColor(t) : kUnreachableColor);
  }
  if (any) scene_.gain_scale = range;
  if (!reachable.points.empty()) scene_.dots.push_back(std::move(reachable));
  if (!unreachable.points.empty()) scene_.dots.push_back(std::move(unreachable));
  if (!plan.chosen) return;
  AddFrustum(AnyCamera(), plan.chosen->T_world_camera, 0.1, 3.0, kChosenColor);
  scene_.labels.push_back(
      {plan.chosen->T_world_camera * Eigen::Vector3d(0.0, 0.09, 0.0), "next view", kChosenColor});
}

void SceneBuilder::SetViews() {
  const double z = options_.table_height;
  constexpr double kHalfGround = 0.35;  // m
  constexpr double kFarthest = 3.0;     // m; a stray pose must not shrink all else to a dot
  const auto add = [&](const Eigen::Vector3d& point) {
    if (point.norm() < kFarthest) scene_.overview.push_back(point);
  };
  for (const double x : {-kHalfGround, kHalfGround}) {
    for (const double y : {-kHalfGround, kHalfGround}) scene_.overview.push_back({x, y, z});
  }
  for (const ShownObject& object : state_.objects().objects) add(object.position);
  for (const ShownCandidate& candidate : state_.plan().candidates) {
    if (candidate.reachable) add(candidate.T_world_camera.translation());
  }
  for (const auto& [name, camera] : state_.cameras()) {
    if (camera.T_world_camera) add(camera.T_world_camera->translation());
  }
  const ShownObject* chosen = ChosenObject(state_, options_);
  if (chosen == nullptr) {
    scene_.closeup = scene_.overview;
    return;
  }
  const ObjectModel* model = ModelOf(chosen->model_id);
  const Eigen::Vector3d center =
      chosen->PoseOfPeak(0) * (model != nullptr ? model->center : Eigen::Vector3d::Zero());
  const double reach = 0.9 * (model != nullptr ? model->diameter : kPlaceholder);
  for (int axis = 0; axis < 3; ++axis) {
    scene_.closeup.push_back(center + reach * Eigen::Vector3d::Unit(axis));
    scene_.closeup.push_back(center - reach * Eigen::Vector3d::Unit(axis));
  }
}

}  // namespace

ViewerScene BuildScene(const ViewerState& state,
                       const ModelMap& models,
                       const ViewerOptions& options) {
  return SceneBuilder(state, models, options).Build();
}

const ShownObject* ChosenObject(const ViewerState& state, const ViewerOptions& options) {
  const ShownObjects& objects = state.objects();
  if (objects.objects.empty()) return nullptr;
  const ShownObject* wanted = options.object ? objects.Find(*options.object) : nullptr;
  return wanted != nullptr ? wanted : &objects.objects.front();
}

Rgb ColorOfInstance(int32_t instance) { return ObjectColor(static_cast<uint32_t>(instance)); }

Rgb GainColor(double t) {
  static constexpr std::array<Rgb, 4> kStops = {
      Rgb{250, 232, 178}, {246, 178, 84}, {224, 100, 48}, {140, 26, 38}};
  const double place = std::clamp(t, 0.0, 1.0) * static_cast<double>(kStops.size() - 1);
  const auto index = std::min(static_cast<size_t>(place), kStops.size() - 2);
  return Mix(kStops[index], kStops[index + 1], place - static_cast<double>(index));
}

}  // namespace vantage
