#include "tools/evaluate/refinement_study.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <ctime>
#include <memory>
#include <utility>

#include "common/format.h"
#include "common/so3.h"
#include "fusion/orientation_filter.h"
#include "fusion/position_filter.h"
#include "fusion/verification_weight.h"
#include "perception/model/enclosing_ball.h"
#include "perception/refinement/multi_view_refiner.h"
#include "perception/verification/mesh_decimation.h"
#include "tools/evaluate/detection_run.h"

namespace vantage {
namespace {

constexpr uint64_t kViewsStream = 1;     // As simulated_sequence.cc has it.
constexpr double kSecondsPerView = 3.0;  // Alike.
constexpr int kGrid = 32;

double ThreadSeconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// The density mode that is told the symmetry, and the position beside it.
Result<Pose> Fuse(const ObjectModel& model,
                  const DetectionSequence& sequence,
                  const So3Grid& grid) {
  OrientationFilterParameters parameters;
  OrientationKnowledge knowledge;
  knowledge.symmetry = model.symmetry;
  OrientationFilter filter(grid, parameters, knowledge);
  std::vector<PositionView> positions;
  for (const DetectedView& view : sequence.views) {
    if (view.detections.empty()) continue;
    const Detection& best = view.detections.front();
    const Pose T = view.T_world_camera * best.T_camera_object;
    const Result<void> added = filter.Add({Eigen::Quaterniond(T.linear()).normalized(), best.mse});
    if (!added) return added.error();
    positions.push_back({T * model.center, VerificationWeight(best.mse, parameters.sigma_vw)});
  }
  const Result<Eigen::Quaterniond> q = filter.Estimate();
  if (!q) return q.error();
  Pose fused = Pose::Identity();
  fused.linear() = q->toRotationMatrix();
  fused.translation() = FusePositions(positions, {}).p_world - fused.linear() * model.center;
  return fused;
}

// The depth of a sequence again; detections are kept, images are not.
std::vector<DepthImage> Depth(const ObjectModel& model,
                              const DetectionSequence& sequence,
                              const SimulationParameters& simulation,
                              const SequenceSimulator& simulator) {
  const uint64_t seed =
      SequenceSeed(simulation.seed, model.id, SequenceKind::kRandom, sequence.index);
  Rng rng(seed, kViewsStream);
  const SimulatedViews views = MakeSimulatedViews(model,
                                                  SequenceKind::kRandom,
                                                  sequence.index,
                                                  simulation.views,
                                                  simulation.camera,
                                                  simulation.sensor.nearest,
                                                  rng);
  SimulatedStage stage = simulator.Place(views, seed);
  std::vector<DepthImage> images(sequence.views.size());
  for (size_t i = 0; i < images.size(); ++i) {
    stage.sensor.Measure(stage.renderer.Render(sequence.views[i].T_world_camera),
                         static_cast<int64_t>(i),
                         kSecondsPerView * static_cast<double>(i),
                         &images[i]);
  }
  return images;
}

void Judge(const ObjectModel& model,
           const Pose& truth,
           const Pose& fused,
           const MultiViewRefined& refined,
           RefinedSequence* outcome) {
  const Eigen::Quaterniond q_truth(truth.linear());
  const Eigen::Quaterniond q_refined(refined.T_world_object.linear());
  const auto angle = [&](const Eigen::Quaterniond& q) {
    return SymmetricAngle(model.symmetry, q, q_truth) / kDegree;
  };
  const auto distance = [&](const Pose& T) {
    return 1e3 * (T * model.center - truth * model.center).norm();
  };
  outcome->fused_deg = angle(Eigen::Quaterniond(fused.linear()));
  outcome->refined_deg = angle(q_refined);
  outcome->fused_mm = distance(fused);
  outcome->refined_mm = distance(refined.T_world_object);
  outcome->is_refined = refined.is_refined;
  outcome->note = refined.note;
  Vector6 error;
  const Eigen::Quaterniond nearest = NearestEquivalent(model.symmetry, q_refined, q_truth);
  error << LogSo3(q_truth * nearest.conjugate()),
      truth * model.center - refined.T_world_object * model.center;
  outcome->squared_deviation = error.dot(refined.covariance.ldlt().solve(error));
  outcome->freedom = model.symmetry.kind == SymmetryGroup::Kind::kContinuous ? 5 : 6;
}

Result<RefinedSequence> Refine(const ObjectModel& model,
                               const ModelShape& shape,
                               const DetectionSequence& sequence,
                               std::span<const DepthImage> images,
                               const CameraModel& camera,
                               const So3Grid& grid,
                               MultiViewRefiner* refiner) {
  RefinedSequence outcome;
  outcome.model_id = model.id;
  outcome.index = sequence.index;
  const Result<Pose> fused = Fuse(model, sequence, grid);
  if (!fused) return fused.error();
  std::vector<RefinementView> views;
  RefinementStart start{shape, model.symmetry, *fused, {}};
  for (size_t i = 0; i < images.size(); ++i) {
    views.push_back({camera, sequence.views[i].T_world_camera, &images[i]});
    if (!sequence.views[i].detections.empty()) start.views.push_back(i);
  }
  outcome.views = static_cast<int>(start.views.size());
  const double begin = ThreadSeconds();
  const MultiViewResult result = refiner->Refine({&start, 1}, views);
  outcome.seconds = ThreadSeconds() - begin;
  Judge(model, sequence.T_world_object, *fused, result.objects.front(), &outcome);
  return outcome;
}

RefinementSummary SummaryOf(const std::string& name,
                            std::span<const RefinedSequence> sequences,
                            std::span<const int> groups,
                            uint64_t seed) {
  constexpr double kWorse = 1.1;
  constexpr double kSquared95[] = {11.070, 12.592};  // Of chi squared with 5 and 6 freedoms.
  RefinementSummary summary;
  summary.name = name;
  summary.count = static_cast<int>(sequences.size());
  std::vector<double> fused, refined, fused_mm, refined_mm, seconds;
  int covered = 0;
  for (const RefinedSequence& sequence : sequences) {
    fused.push_back(sequence.fused_deg);
    refined.push_back(sequence.refined_deg);
    fused_mm.push_back(sequence.fused_mm);
    refined_mm.push_back(sequence.refined_mm);
    if (sequence.views > 0) seconds.push_back(10.0 * sequence.seconds / sequence.views);
    const double ratio = sequence.refined_deg / sequence.fused_deg;
    summary.largest_ratio = std::max(summary.largest_ratio, ratio);
    summary.worse += ratio > kWorse ? 1 : 0;
    summary.refused += sequence.is_refined ? 0 : 1;
    covered += sequence.is_refined && sequence.squared_deviation <= kSquared95[sequence.freedom - 5]
                   ? 1
                   : 0;
  }
  Rng rng(seed);
  BootstrapParameters bootstrap;
  bootstrap.groups = groups;
  summary.fused_deg = BootstrapInterval(fused, Statistic::kMedian, bootstrap, rng);
  summary.refined_deg = BootstrapInterval(refined, Statistic::kMedian, bootstrap, rng);
  summary.fused_mm = Median(fused_mm);
  summary.refined_mm = Median(refined_mm);
  summary.fused_90_deg = Quantile(fused, 0.9);
  summary.refined_90_deg = Quantile(refined, 0.9);
  const int kept = summary.count - summary.refused;
  summary.coverage = kept > 0 ? static_cast<double>(covered) / kept : 0.0;
  summary.seconds_of_10 = Median(seconds);
  return summary;
}

}  // namespace

std::vector<RefinementSummary> Summarize(const RefinementStudyResults& results) {
  const std::vector<RefinedSequence>& all = results.sequences;
  std::vector<RefinementSummary> models;
  std::vector<int> groups;
  for (size_t begin = 0, end = 0; begin < all.size(); begin = end) {
    while (end < all.size() && all[end].model_id == all[begin].model_id) ++end;
    groups.resize(end, static_cast<int>(models.size()));
    const std::span<const RefinedSequence> of_model(&all[begin], end - begin);
    models.push_back(SummaryOf(all[begin].model_id, of_model, {}, results.seed));
  }
  if (!all.empty()) {
    models.insert(models.begin(), SummaryOf("all", all, groups, results.seed));
  }
  return models;
}

std::vector<std::string> MissedBars(const RefinementStudyResults& results) {
  constexpr double kShare = 0.5;
  constexpr double kSeconds = 0.05;
  constexpr double kTruthDeg = 1.3;
  std::vector<std::string> missed;
  const std::vector<RefinementSummary> summaries = Summarize(results);
  if (summaries.empty()) return {"no sequences were refined"};
  const RefinementSummary& all = summaries.front();
  if (!(all.refined_deg.value <= kShare * all.fused_deg.value)) {
    missed.push_back(Format("refined median %.4f deg, %.2f of the fused %.4f deg, expected %.2f",
                            all.refined_deg.value,
                            all.refined_deg.value / all.fused_deg.value,
                            all.fused_deg.value,
                            kShare));
  }
  if (all.worse > 0) {
    missed.push_back(
        Format("%d of %d sequences are more than 1.1 times as far off as fused, at "
               "most %.2f times, expected none",
               all.worse,
               all.count,
               all.largest_ratio));
  }
  if (!(all.seconds_of_10 <= kSeconds)) {
    missed.push_back(
        Format("%.1f ms for 10 views, expected %.0f", 1e3 * all.seconds_of_10, 1e3 * kSeconds));
  }
  if (!results.turntable) return missed;
  const TurntableRefinement& turntable = *results.turntable;
  if (!(turntable.is_refined && turntable.truth_deg <= kTruthDeg)) {
    missed.push_back(Format("turntable: %.2f deg from the truth, expected %.1f; %s",
                            turntable.truth_deg,
                            kTruthDeg,
                            turntable.note.c_str()));
  }
  if (!(turntable.consensus_deg < turntable.nearest_view_deg)) {
    missed.push_back(Format("turntable: %.3f deg from the consensus, the nearest view %.3f deg",
                            turntable.consensus_deg,
                            turntable.nearest_view_deg));
  }
  return missed;
}

Result<bool> StudyRefinement(const std::vector<ObjectModel>& models,
                             const RefinementRequest& request,
                             const std::stop_token& stop,
                             const std::function<void(int64_t done, int64_t total)>& progress,
                             RefinementStudyResults* results) {
  DetectionRequest detections;
  detections.simulation.seed = request.seed;
  detections.simulation.views.random_views = request.views;
  detections.circles = 0;
  detections.random_sequences = request.sequences;
  detections.threads = request.threads;
  detections.cache = request.cache;
  const int64_t total = static_cast<int64_t>(models.size()) * request.sequences;
  const Result<DetectionRun> run = RunDetections(models, detections, stop, {});
  if (!run) return run.error();
  if (!run->is_complete) return false;
  const Result<So3Grid> grid = So3Grid::Create(kGrid);
  if (!grid) return grid.error();
  MultiViewRefiner refiner{MultiViewParameters()};
  for (size_t i = 0; i < models.size(); ++i) {
    const ObjectModel& model = models[i];
    const DrawableMesh mesh(DecimateMesh(model.mesh, kFineLevel));
    const ModelShape shape{mesh, model.center, model.diameter, RadiusAboutCenter(model)};
    const Result<std::unique_ptr<SequenceSimulator>> simulator =
        SequenceSimulator::Create(model, detections.simulation);
    if (!simulator) return simulator.error();
    for (const DetectionSequence& sequence : run->models[i].random) {
      if (stop.stop_requested()) return false;
      const std::vector<DepthImage> images =
          Depth(model, sequence, detections.simulation, **simulator);
      Result<RefinedSequence> refined =
          Refine(model, shape, sequence, images, detections.simulation.camera, *grid, &refiner);
      if (!refined) return refined.error();
      results->sequences.push_back(std::move(refined).value());
      progress(static_cast<int64_t>(results->sequences.size()), total);
    }
  }
  return true;
}

}  // namespace vantage
