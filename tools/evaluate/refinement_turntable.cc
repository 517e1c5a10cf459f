#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/format.h"
#include "common/so3.h"
#include "fusion/orientation_filter.h"
#include "fusion/position_filter.h"
#include "fusion/quaternion_mean.h"
#include "perception/model/enclosing_ball.h"
#include "perception/refinement/multi_view_refiner.h"
#include "perception/verification/mesh_decimation.h"
#include "tools/evaluate/dataset_estimator.h"
#include "tools/evaluate/refinement_study.h"
#include "tools/evaluate/turntable_dataset.h"
#include "tools/support/view_folder.h"

namespace vantage {
namespace {

constexpr int kGrid = 32;
// What the markers, which lie beside the object, tell wrong (the dataset's own figures).
constexpr double kMarkerRotation = 1.3 * kDegree;
constexpr double kMarkerTranslation = 0.0017;  // m
constexpr double kMaxRotation = 5.0 * kDegree;
constexpr double kMaxTranslation = 0.01;  // m

double AngleDeg(const Pose& a, const Pose& b) {
  return GeodesicAngle(Eigen::Quaterniond(a.linear()), Eigen::Quaterniond(b.linear())) / kDegree;
}

double DistanceMm(const Eigen::Vector3d& center, const Pose& a, const Pose& b) {
  return 1e3 * (a * center - b * center).norm();
}

Result<std::vector<Pose>> CameraPoses(const std::filesystem::path& folder, const Dataset& dataset) {
  std::vector<Pose> poses;
  for (const DatasetView& view : dataset.views) {
    const Result<Pose> pose =
        ReadPoseFile(folder / Format("world_T_camera_%s.txt", view.name.c_str()));
    if (!pose) return pose.error();
    poses.push_back(*pose);
  }
  return poses;
}

// Mean rotation and mean center.
Pose Consensus(const Eigen::Vector3d& center, const std::vector<Pose>& poses) {
  std::vector<WeightedOrientation> orientations;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Pose& pose : poses) {
    orientations.push_back({Eigen::Quaterniond(pose.linear()), 1.0});
    sum += pose * center;
  }
  Pose mean = Pose::Identity();
  mean.linear() = WeightedMean(orientations).toRotationMatrix();
  mean.translation() = sum / static_cast<double>(poses.size()) - mean.linear() * center;
  return mean;
}

// The estimator's detections of all views, fused as vantage-fusion would.
Result<Pose> Fuse(const Dataset& dataset,
                  const std::vector<Pose>& T_world_camera,
                  std::vector<size_t>* found) {
  const ObjectModel& model = dataset.models.front();
  const Result<DatasetEstimator> estimate =
      MakeEstimator("ppf", {model}, SegmentationParameters::Support::kNone);
  if (!estimate) return estimate.error();
  const Result<So3Grid> grid = So3Grid::Create(kGrid);
  if (!grid) return grid.error();
  OrientationFilter filter(*grid, {});
  std::vector<PositionView> positions;
  for (size_t i = 0; i < dataset.views.size(); ++i) {
    Rng rng(1, i);
    const DatasetEstimate seen = (*estimate)(dataset.views[i].depth, dataset.views[i].camera, rng);
    if (seen.detections.empty()) continue;
    const Pose T = T_world_camera[i] * seen.detections.front().T_camera_object;
    const Result<void> added =
        filter.Add({Eigen::Quaterniond(T.linear()).normalized(), seen.detections.front().mse});
    if (!added) return added.error();
    positions.push_back({T * model.center, 1.0});
    found->push_back(i);
  }
  const Result<Eigen::Quaterniond> q = filter.Estimate();
  if (!q) return q.error();
  Pose fused = Pose::Identity();
  fused.linear() = q->toRotationMatrix();
  fused.translation() = FusePositions(positions, {}).p_world - fused.linear() * model.center;
  return fused;
}

}  // namespace

Result<TurntableRefinement> RefineTurntable(const std::filesystem::path& folder,
                                            const std::filesystem::path& meshes) {
  const Result<Dataset> dataset = LoadTurntableDataset(folder, meshes);
  if (!dataset) return dataset.error();
  const Result<std::vector<Pose>> cameras = CameraPoses(folder, *dataset);
  if (!cameras) return cameras.error();
  const Result<Pose> truth = ReadPoseFile(folder / "world_T_model.txt");
  if (!truth) return truth.error();
  const ObjectModel& model = dataset->models.front();
  const DrawableMesh mesh(DecimateMesh(model.mesh, kFineLevel));
  RefinementStart start{{mesh, model.center, model.diameter, RadiusAboutCenter(model)},
                        SymmetryGroup::None(),
                        Pose::Identity(),
                        {}};
  start.max_rotation = kMaxRotation;
  start.max_translation = kMaxTranslation;
  const Result<Pose> fused = Fuse(*dataset, *cameras, &start.views);
  if (!fused) return fused.error();
  start.T_world_object = *fused;
  std::vector<RefinementView> views;
  std::vector<Pose> by_view;
  for (size_t i = 0; i < cameras->size(); ++i) {
    const DatasetView& view = dataset->views[i];
    views.push_back({view.camera, (*cameras)[i], &view.depth});
    by_view.push_back((*cameras)[i] * view.objects.front().T_camera_object);
  }
  MultiViewParameters parameters;
  parameters.view_rotation = kMarkerRotation;
  parameters.view_translation = kMarkerTranslation;
  const MultiViewResult result = MultiViewRefiner(parameters).Refine({&start, 1}, views);
  const MultiViewRefined& refined = result.objects.front();

  const Pose consensus = Consensus(model.center, by_view);
  TurntableRefinement outcome;
  outcome.views = refined.views;
  outcome.is_refined = refined.is_refined;
  outcome.note = refined.note;
  outcome.truth_deg = AngleDeg(refined.T_world_object, *truth);
  outcome.truth_mm = DistanceMm(model.center, refined.T_world_object, *truth);
  outcome.fused_truth_deg = AngleDeg(*fused, *truth);
  outcome.consensus_deg = AngleDeg(refined.T_world_object, consensus);
  outcome.consensus_mm = DistanceMm(model.center, refined.T_world_object, consensus);
  outcome.fused_consensus_deg = AngleDeg(*fused, consensus);
  outcome.nearest_view_deg = std::numeric_limits<double>::infinity();
  outcome.nearest_view_mm = std::numeric_limits<double>::infinity();
  for (const Pose& pose : by_view) {
    outcome.nearest_view_deg = std::min(outcome.nearest_view_deg, AngleDeg(pose, consensus));
    outcome.nearest_view_mm =
        std::min(outcome.nearest_view_mm, DistanceMm(model.center, pose, consensus));
  }
  return outcome;
}

}  // namespace vantage
