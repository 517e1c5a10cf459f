// Stages of vantage-ppf on a VGA image of three objects on a table as the simulated sensor sees it
// from 0.75 m, the whole on such images, and on recorded views of a printed bunny where they are
// there. Counters give the accuracy that the time buys. Segmentation and verification have programs
// of their own.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "perception/model/mesh_import.h"
#include "perception/model/model_builder.h"
#include "perception/model/model_generator.h"
#include "perception/ppf/ppf_estimator.h"
#include "perception/ppf/ppf_proposer.h"
#include "tests/bench/table_frames.h"
#include "tools/support/png_image.h"

namespace vantage {
namespace {

constexpr size_t kBracket = 2;

const std::vector<ObjectModel>& Models() {
  static const std::vector<ObjectModel> models = [] {
    std::vector<ObjectModel> built;
    for (const char* name : {"filter", "mug", "bracket"}) {
      const GeneratedObject object = GenerateObject(name).value();
      built.push_back(
          BuildObjectModel(name, object.mesh, object.symmetry, "generated", {}).value());
    }
    return built;
  }();
  return models;
}

// One frame with its segments; the bracket's cluster.
struct Segmented {
  TableFrame frame = MakeTableFrame(1);
  Segmentation segmentation;
  size_t bracket = 0;
  std::vector<SurfacePoint> scene;

  Segmented() {
    Rng rng(1);
    segmentation = Segment(frame.depth, frame.camera, {}, rng);
    const Eigen::Vector2d place =
        frame.camera.Project(frame.T_camera_object[kBracket] * Models()[kBracket].center);
    double nearest = 1e9;
    for (size_t i = 0; i < segmentation.clusters.size(); ++i) {
      const PixelWindow& window = segmentation.clusters[i].window;
      const Eigen::Vector2d middle(0.5 * (window.u0 + window.u1), 0.5 * (window.v0 + window.v1));
      if ((middle - place).norm() < nearest) {
        nearest = (middle - place).norm();
        bracket = i;
      }
    }
    scene = Sample();
  }
  [[nodiscard]] std::vector<SurfacePoint> Sample() const {
    return SampleSurfaces(frame.depth,
                          frame.camera,
                          segmentation.labels,
                          segmentation.clusters[bracket].pixels,
                          0.05 * Models()[kBracket].diameter,
                          {});
  }
  [[nodiscard]] SegmentedImage image() const { return {frame.depth, frame.camera, segmentation}; }
};

const Segmented& Fixture() {
  static const Segmented fixture;
  return fixture;
}

ModelShape BracketShape() {
  const ObjectModel& model = Models()[kBracket];
  static const DrawableMesh mesh(model.mesh);
  return {mesh, model.center, model.diameter, model.diameter};
}

// A little off the truth, as the stage before leaves it.
Pose Disturbed(double degrees, double distance) {
  const Pose& T = Fixture().frame.T_camera_object[kBracket];
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, 2.0, -1.0).normalized();
  const Eigen::Vector3d center = T * Models()[kBracket].center;
  const Eigen::Vector3d shift = distance * Eigen::Vector3d(0.6, 0.0, 0.8);
  return Pose(Eigen::Translation3d(center + shift) * Eigen::AngleAxisd(degrees * kDegree, axis) *
              Eigen::Translation3d(-center)) *
         T;
}

double ErrorDegrees(const Pose& a, const Pose& b) {
  return GeodesicAngle(Eigen::Quaterniond(a.linear()), Eigen::Quaterniond(b.linear())) / kDegree;
}

double Seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Of all objects that this project makes itself.
void BM_TrainSlowestModel(benchmark::State& state) {
  std::vector<SurfacePoint> samples;
  double diameter = 0.0;
  double slowest = 0.0;
  for (const std::string& name : GeneratedObjectNames()) {
    const GeneratedObject object = GenerateObject(name).value();
    const ObjectModel model =
        BuildObjectModel(name, object.mesh, object.symmetry, "generated", {}).value();
    const double start = Seconds();
    benchmark::DoNotOptimize(PpfTable::Train(model.samples, model.diameter, {}).value());
    const double seconds = Seconds() - start;
    if (seconds <= slowest) continue;
    slowest = seconds;
    samples = model.samples;
    diameter = model.diameter;
    state.SetLabel(name);
  }
  size_t entries = 0;
  for (auto _ : state) entries = PpfTable::Train(samples, diameter, {}).value().num_entries();
  state.counters["entries"] = static_cast<double>(entries);
}
BENCHMARK(BM_TrainSlowestModel)->Unit(benchmark::kMillisecond);

// All that a model takes when vantage-ppf starts.
void BM_MakeEstimator(benchmark::State& state) {
  const std::vector<ObjectModel> models = {Models()[kBracket]};
  for (auto _ : state) benchmark::DoNotOptimize(CreatePpfEstimator(models, {}).value());
}
BENCHMARK(BM_MakeEstimator)->Unit(benchmark::kMillisecond);

void BM_ProposalsOneClusterOneModel(benchmark::State& state) {
  const ObjectModel& model = Models()[kBracket];
  std::vector<PpfProposer::Model> models;
  models.push_back(
      {PpfTable::Train(model.samples, model.diameter, {}).value(), model.center, model.symmetry});
  PpfProposer proposer(std::move(models), {});
  std::span<const PoseHypothesis> found;
  for (auto _ : state) {
    Rng rng(1);
    found = proposer.Propose(0, Fixture().scene, rng);
  }
  double best = 180.0;
  for (const PoseHypothesis& hypothesis : found) {
    best = std::min(
        best, ErrorDegrees(hypothesis.T_camera_object, Fixture().frame.T_camera_object[kBracket]));
  }
  state.counters["best_deg"] = best;
}
BENCHMARK(BM_ProposalsOneClusterOneModel)->Unit(benchmark::kMillisecond);

void BM_RefinementCoarse(benchmark::State& state) {
  const ObjectModel& model = Models()[kBracket];
  Rng rng(1);
  const NearestGrid grid(
      SampleSurface(model.mesh, 4000, rng), 0.16 * model.diameter, 0.02 * model.diameter);
  ScenePoints scene;
  scene.Assign(Fixture().scene, Fixture().frame.camera.fx, {});
  CoarselyRefined refined;
  for (auto _ : state) {
    refined = RefineCoarse(grid, BracketShape(), Disturbed(8.0, 0.008), scene, {});
  }
  state.counters["error_deg"] =
      ErrorDegrees(refined.T_camera_object, Fixture().frame.T_camera_object[kBracket]);
}
BENCHMARK(BM_RefinementCoarse)->Unit(benchmark::kMicrosecond);

void BM_RefinementFineAndFinal(benchmark::State& state) {
  ModelView view;
  Refiner refiner;
  Refined refined;
  for (auto _ : state) {
    refined = refiner.Refine(
        BracketShape(), BracketShape(), Disturbed(2.0, 0.003), Fixture().image(), {}, &view);
  }
  state.counters["error_deg"] =
      ErrorDegrees(refined.T_camera_object, Fixture().frame.T_camera_object[kBracket]);
}
BENCHMARK(BM_RefinementFineAndFinal)->Unit(benchmark::kMicrosecond);

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 180.0;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1,
                         static_cast<size_t>(share * static_cast<double>(values.size())))];
}

void BM_FrameOfThreeObjectsAndModels(benchmark::State& state) {
  const auto estimator = CreatePpfEstimator(Models(), {}).value();
  std::vector<TableFrame> frames;
  for (int i = 0; i < 8; ++i) frames.push_back(MakeTableFrame(i));
  std::vector<double> degrees;
  size_t next = 0;
  for (auto _ : state) {
    const TableFrame& frame = frames[next % frames.size()];
    Rng rng(next % frames.size());
    const PoseEstimator::Output output = estimator->Estimate(frame.depth, frame.camera, rng);
    if (next++ >= frames.size()) continue;
    for (size_t i = 0; i < Models().size(); ++i) {
      double error = 180.0;
      for (const Detection& detection : output.detections) {
        if (detection.model_id != Models()[i].id) continue;
        error = std::min(error, ErrorDegrees(detection.T_camera_object, frame.T_camera_object[i]));
      }
      degrees.push_back(error);
    }
  }
  state.counters["median_deg"] = Quantile(degrees, 0.5);
  state.counters["within_5_deg"] =
      static_cast<double>(
          std::count_if(degrees.begin(), degrees.end(), [](double d) { return d < 5.0; })) /
      static_cast<double>(degrees.size());
}
BENCHMARK(BM_FrameOfThreeObjectsAndModels)->Unit(benchmark::kMillisecond)->Iterations(8);

void BM_RealViewsOfTheBunny(benchmark::State& state) {
  const std::filesystem::path data = std::filesystem::path(VANTAGE_SOURCE_DIR) / "../shared/data";
  const std::filesystem::path views = data / "bunny_turntable_36views";
  Result<TriangleMesh> mesh = ImportMesh(data / "meshes/stanford_bunny.ply", 1.0);
  std::ifstream csv(views / "camera_T_model.csv");
  if (!mesh || !csv) {
    state.SkipWithError("the recorded views are not there");
    return;
  }
  const ObjectModel model =
      BuildObjectModel("bunny", std::move(mesh).value(), SymmetryGroup::None(), "scan", {}).value();
  const auto estimator = CreatePpfEstimator(std::vector<ObjectModel>{model}, {}).value();
  CameraModel camera;
  camera.fx = 542.0;
  camera.fy = 540.5;
  camera.cx = 320.0;
  camera.cy = 240.0;
  std::vector<DepthImage> images;
  std::vector<Pose> truths;
  std::string line;
  std::getline(csv, line);
  while (std::getline(csv, line)) {
    std::vector<double> values;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) values.push_back(std::stod(cell));
    const std::string name = std::to_string(static_cast<int>(values[0]));
    const Result<Gray16Image> png =
        ReadPng16(views / ("depth_" + std::string(2 - name.size(), '0') + name + ".png"));
    if (!png) continue;
    images.push_back(DepthFromMillimetres(png->width, png->height, png->gray.data()));
    Pose T = Pose::Identity();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        T(row, column) = values[13 + 4 * static_cast<size_t>(row) + static_cast<size_t>(column)];
      }
    }
    truths.push_back(T);
  }
  std::vector<double> degrees;
  size_t next = 0;
  for (auto _ : state) {
    const size_t i = next++ % images.size();
    Rng rng(i);
    const PoseEstimator::Output output = estimator->Estimate(images[i], camera, rng);
    degrees.push_back(output.detections.empty()
                          ? 180.0
                          : ErrorDegrees(output.detections[0].T_camera_object, truths[i]));
  }
  state.counters["median_deg"] = Quantile(degrees, 0.5);
  state.counters["worst_deg"] = Quantile(degrees, 1.0);
}
BENCHMARK(BM_RealViewsOfTheBunny)->Unit(benchmark::kMillisecond)->Iterations(36);

}  // namespace
}  // namespace vantage
