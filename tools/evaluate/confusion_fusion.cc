#include "tools/evaluate/confusion_fusion.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "common/format.h"
#include "common/so3.h"
#include "fusion/confusion/accuracy_weights.h"
#include "fusion/confusion/confusion_model.h"
#include "fusion/confusion/viewing_direction.h"
#include "fusion/orientation_filter.h"
#include "fusion/verification_weight.h"
#include "tools/evaluate/confusion_pictures.h"
#include "tools/evaluate/fusion_methods.h"

namespace vantage {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr size_t kClusterings = 4;  // Of kFinalOrientations, those of the paper.

Eigen::Quaterniond Rotation(const Pose& pose) {
  return Eigen::Quaterniond(pose.linear()).normalized();
}

// What each view detected, and from where.
std::vector<OrientationView> SeenIn(const ObjectModel& model,
                                    const DetectionSequence& sequence,
                                    size_t num_views) {
  std::vector<OrientationView> all;
  for (size_t i = 0; i < std::min(num_views, sequence.views.size()); ++i) {
    const DetectedView& view = sequence.views[i];
    if (view.detections.empty()) continue;
    const Detection& best = view.detections.front();
    const Pose T_world_object = view.T_world_camera * best.T_camera_object;
    all.push_back({Canonical(Rotation(T_world_object)),
                   best.mse,
                   AimedAt(view.T_world_camera, T_world_object * model.center)});
  }
  return all;
}

OrientationHistogram FuseByAccuracy(const So3Grid& grid,
                                    const std::vector<OrientationView>& seen,
                                    bool is_verified,
                                    AccuracyWeights* weights) {
  OrientationHistogram histogram(grid);
  for (const OrientationView& one : seen) {
    const double w_v =
        is_verified ? VerificationWeight(one.mse, ClusteringParameters().sigma_vw) : 1.0;
    weights->AddTo(*one.q_world_camera, one.q_world_object, w_v, &histogram);
  }
  return histogram;
}

OrientationHistogram FuseByConfidence(const So3Grid& grid,
                                      const std::vector<OrientationView>& seen) {
  OrientationHistogram histogram(grid);
  for (const OrientationView& one : seen) {
    histogram.Add(one.q_world_object, ClusteringParameters().sigma_cw, 1.0);
  }
  return histogram;
}

OrientationFilter FuseByTable(const So3Grid& grid,
                              const ObjectModel& model,
                              const ConfusionModel& confusion,
                              const std::vector<OrientationView>& seen,
                              FinalOrientation final_orientation) {
  OrientationFilterParameters parameters = ClusteringParameters();
  parameters.final_orientation = final_orientation;
  OrientationFilter filter(
      grid, parameters, {.prior = {}, .symmetry = model.symmetry, .confusion = &confusion});
  filter.Fuse(seen);
  return filter;
}

// What the belief says, as wide as confidence weights are.
OrientationHistogram HistogramOf(const So3Grid& grid,
                                 const std::vector<OrientationHypothesis>& belief) {
  OrientationHistogram histogram(grid);
  for (const OrientationHypothesis& one : belief) {
    histogram.Add(one.q_world_object, ClusteringParameters().sigma_cw, one.probability);
  }
  return histogram;
}

double ErrorDeg(const ObjectModel& model,
                const DetectionSequence& sequence,
                const Eigen::Quaterniond& q) {
  return SymmetricAngle(model.symmetry, q, Rotation(sequence.T_world_object)) / kDegree;
}

// Of the four ways of the paper, of accuracy weights without and with verification, and of the
// filter that knows the table.
std::vector<double> FinalErrors(const So3Grid& grid,
                                const ObjectModel& model,
                                const ConfusionModel& confusion,
                                const DetectionSequence& circle,
                                AccuracyWeights* weights) {
  std::vector<double> errors;
  const std::vector<OrientationView> seen = SeenIn(model, circle, circle.views.size());
  const auto all = AllFinalOrientations(grid, ClusteringParameters(), seen);
  for (size_t i = 0; i < kClusterings; ++i) {
    errors.push_back(all ? ErrorDeg(model, circle, (*all)[i]) : kNone);
  }
  const auto append = [&](const std::vector<OrientationPeak>& peaks) {
    errors.push_back(peaks.empty() ? kNone : ErrorDeg(model, circle, peaks.front().q));
  };
  for (const bool is_verified : {false, true}) {
    append(
        FindPeaks(FuseByAccuracy(grid, seen, is_verified, weights), ClusteringParameters().peaks));
  }
  for (const FinalOrientation way :
       {FinalOrientation::kCwVwClustering, FinalOrientation::kDensityMode}) {
    append(FuseByTable(grid, model, confusion, seen, way).peaks());
  }
  return errors;
}

PeakFacts FactsOf(const ReweightedObject& object,
                  const OrientationHistogram& histogram,
                  const std::vector<OrientationPeak>& peaks,
                  const char* method,
                  int views) {
  PeakFacts facts;
  facts.model_id = object.model->id;
  facts.method = method;
  facts.views = views;
  facts.num_peaks = static_cast<int>(peaks.size());
  facts.best_deg = kNone;
  if (peaks.empty()) return facts;
  facts.best_deg = ErrorDeg(*object.model, object.circles.front(), peaks.front().q);
  double sum = 0.0;
  for (const OrientationPeak& peak : peaks) sum += peak.weight;
  facts.share_of_best = peaks.front().weight / sum;
  for (size_t i = 1; i < peaks.size(); ++i) {
    facts.others_deg.push_back(GeodesicAngle(peaks[i].q, peaks.front().q) / kDegree);
  }
  for (const CellWeights::Entry& entry : histogram.weights().Entries()) {
    facts.highest = std::max(
        facts.highest,
        static_cast<double>(entry.weight) * histogram.grid().Area(entry.cell) / histogram.Mass());
  }
  return facts;
}

}  // namespace

Result<ReweightingTable> CompareReweighting(int k, std::span<const ReweightedObject> objects) {
  Result<So3Grid> grid = So3Grid::Create(k);
  if (!grid) return grid.error();
  const OrientationFilterParameters clustering = ClusteringParameters();
  const std::string sigma_cw = Format("sigma_cw %g deg", clustering.sigma_cw / kDegree);
  const std::string sigma_vw = Format("sigma_vw %g mm^2", 1e6 * clustering.sigma_vw);
  const std::string pseudo_count = Format("c_p %g", AccuracyWeights::kPseudoCount);
  ReweightingTable table;
  table.k = k;
  table.methods = {
      {"voting", "Voting", "", true, false},
      {"vw_voting", "VW voting", sigma_vw, true, false},
      {"cw_clustering", "CW clustering", sigma_cw, true, false},
      {"cw_vw_clustering", "CW+VW clustering", sigma_cw + ", " + sigma_vw, true, false},
      {"aw_clustering", "AW clustering", pseudo_count, true, false},
      {"aw_vw_clustering", "AW+VW clustering", pseudo_count + ", " + sigma_vw, true, true},
      {"table_kernels", "Table, kernels", sigma_cw + ", " + sigma_vw, true, true},
      {"table_density", "Table, kernels, density mode", sigma_cw + ", " + sigma_vw, true, true}};
  for (const ReweightedObject& object : objects) {
    Result<AccuracyWeights> weights = AccuracyWeights::FromDirections(*object.table, *grid);
    if (!weights) return weights.error();
    const Result<ConfusionModel> confusion =
        ConfusionModel::Make(*object.table, object.model->symmetry);
    if (!confusion) return confusion.error();
    table.model_ids.push_back(object.model->id);
    std::vector<std::vector<double>> by_method(table.methods.size());
    for (const DetectionSequence& circle : object.circles) {
      const std::vector<double> errors =
          FinalErrors(*grid, *object.model, *confusion, circle, &*weights);
      for (size_t m = 0; m < errors.size(); ++m) by_method[m].push_back(errors[m]);
    }
    table.final_deg.push_back(std::move(by_method));
  }
  return table;
}

Result<void> AppendPeaks(int k,
                         const ReweightedObject& object,
                         const std::vector<int>& after_views,
                         const std::string& group,
                         ConfusionResults* results) {
  Result<So3Grid> grid = So3Grid::Create(k);
  if (!grid) return grid.error();
  Result<AccuracyWeights> weights = AccuracyWeights::FromDirections(*object.table, *grid);
  if (!weights) return weights.error();
  const Result<ConfusionModel> confusion =
      ConfusionModel::Make(*object.table, object.model->symmetry);
  if (!confusion) return confusion.error();
  if (object.circles.empty()) return {};
  const DetectionSequence& circle = object.circles.front();
  const auto append = [&](const char* method,
                          int views,
                          const OrientationHistogram& histogram,
                          const std::vector<OrientationPeak>& peaks) {
    results->peaks.push_back(FactsOf(object, histogram, peaks, method, views));
    results->pictures.push_back(
        {Format("%s-%s-%s-%d", group.c_str(), object.model->id.c_str(), method, views),
         group,
         Format("%s, %s, after %d views: %d peaks",
                object.model->id.c_str(),
                method,
                views,
                static_cast<int>(peaks.size())),
         DrawHistogram(histogram.weights(), Rotation(circle.T_world_object))});
  };
  for (const std::string method : {"CW", "AW", "table"}) {
    for (const int views : after_views) {
      const std::vector<OrientationView> seen =
          SeenIn(*object.model, circle, static_cast<size_t>(views));
      if (seen.empty()) continue;
      if (method == "table") {
        const OrientationFilter filter =
            FuseByTable(*grid, *object.model, *confusion, seen, FinalOrientation::kCwVwClustering);
        append("table", views, HistogramOf(*grid, filter.belief()), filter.peaks());
        continue;
      }
      const OrientationHistogram histogram = method == "AW"
                                                 ? FuseByAccuracy(*grid, seen, false, &*weights)
                                                 : FuseByConfidence(*grid, seen);
      append(method.c_str(), views, histogram, FindPeaks(histogram, PeakParameters{}));
    }
  }
  return {};
}

}  // namespace vantage
