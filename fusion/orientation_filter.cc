#include "fusion/orientation_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/check.h"
#include "common/format.h"
#include "fusion/confidence_weight.h"
#include "fusion/verification_weight.h"

namespace vantage {
namespace {

// Truths this near to their detection, in sigma_cw, are no other mode: beside the detection itself
// they would only widen what tells where exactly its mode is.
constexpr double kApart = 3.0;

// An orientation that a detection may stand for.
struct Truth {
  Eigen::Quaterniond q_world_object;
  double share;
  double angle;  // rad, from the detection.
};

// P(truth | detection) of one view without a prior (paper eq. 8), what is left by outliers being
// `everywhere`. The detection itself where no more is known.
std::vector<Truth> TruthsOf(const OrientationView& view,
                            const ConfusionModel* confusion,
                            double* everywhere) {
  const Eigen::Quaterniond q = view.q_world_object.normalized();
  if (confusion == nullptr || !view.q_world_camera) return {{q, 1.0, 0.0}};
  const Eigen::Quaterniond q_camera_world = view.q_world_camera->normalized().conjugate();
  const double outliers = confusion->parameters().outlier_share;
  std::vector<Truth> truths;
  double sum = outliers;
  for (int mode = 0; mode < confusion->num_modes(); ++mode) {
    const Eigen::Quaterniond truth = q * confusion->Difference(mode).conjugate();
    const int direction = confusion->DirectionOf(q_camera_world * truth);
    double share = (1.0 - outliers) * confusion->ShareFrom(direction, mode);
    // A detection may be right even where none ever was.
    if (mode == 0) share = confusion->WithOutliers(confusion->ShareFrom(direction, mode));
    if (share <= 0.0) continue;
    const double angle =
        mode == 0 ? 0.0
                  : GeodesicAngle(confusion->Difference(mode), Eigen::Quaterniond::Identity());
    truths.push_back({truth, share, angle});
    sum += share;
  }
  for (Truth& truth : truths) truth.share /= sum;
  *everywhere = outliers / sum;
  return truths;
}

}  // namespace

Result<void> OrientationFilterParameters::Validate() const {
  if (!(sigma_cw > 0.0 && sigma_cw <= std::numbers::pi)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("sigma_cw = %g rad, expected above 0 and at most pi", sigma_cw)};
  }
  if (!(sigma_vw > 0.0 && std::isfinite(sigma_vw))) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("sigma_vw = %g m^2, expected above 0", sigma_vw)};
  }
  if (!(sigma_motion >= 0.0 && sigma_motion <= std::numbers::pi)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("sigma_motion = %g rad, expected 0 to pi", sigma_motion)};
  }
  if (!(converge_angle > 0.0) || converge_views < 1 || min_views < 1) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("converge_angle = %g rad, converge_views = %d, min_views = %d, expected "
                        "all above 0",
                        converge_angle,
                        converge_views,
                        min_views)};
  }
  if (auto valid = mode.Validate(); !valid) return valid;
  return peaks.Validate();
}

OrientationFilter::OrientationFilter(const So3Grid& grid,
                                     const OrientationFilterParameters& parameters,
                                     OrientationKnowledge knowledge)
    : grid_(&grid),
      parameters_(parameters),
      knowledge_(std::move(knowledge)),
      histogram_(grid, knowledge_.prior) {}

Result<void> OrientationFilter::Add(const OrientationView& view) {
  if (auto valid = view.Validate(); !valid) return valid;
  views_.push_back(view);
  if (parameters_.sigma_motion > 0.0) {
    FuseAll();
  } else {
    AddToHistogram(view, 0.0);
  }
  FindFinalOrientation();
  return {};
}

void OrientationFilter::Fuse(const std::vector<OrientationView>& views) {
  const auto [changed, old] =
      std::mismatch(views.begin(), views.end(), views_.begin(), views_.end());
  const auto num_same = static_cast<size_t>(changed - views.begin());
  if (num_same < views_.size()) {
    // What was added can't be taken back without rounding: start again from the first view.
    views_.resize(num_same);
    q_f_.resize(num_same);
    FuseAll();
    if (views.empty()) {
      peaks_.clear();
      belief_.clear();
      return;
    }
    if (num_same == views.size()) {
      q_f_.pop_back();
      FindFinalOrientation();
      return;
    }
  }
  for (size_t i = num_same; i < views.size(); ++i) {
    const auto added = Add(views[i]);
    VANTAGE_CHECK(added.ok(), added.error().message);
  }
}

// All views from the first, the older ones uncertain by the motions since.
void OrientationFilter::FuseAll() {
  histogram_ = OrientationHistogram(*grid_, knowledge_.prior);
  kernels_.clear();
  support_.clear();
  last_view_ = 0;
  for (size_t i = 0; i < views_.size(); ++i) {
    const auto num_motions = static_cast<double>(views_.size() - 1 - i);
    AddToHistogram(views_[i], parameters_.sigma_motion * std::sqrt(num_motions));
  }
}

void OrientationFilter::AddToHistogram(const OrientationView& view, double sigma_motion) {
  const Eigen::Quaterniond q = view.q_world_object.normalized();
  const double w_v = VerificationWeight(view.mse, parameters_.sigma_vw);
  const double sigma = std::hypot(parameters_.sigma_cw, sigma_motion);
  switch (parameters_.final_orientation) {
    case FinalOrientation::kVoting:
      histogram_.Vote(q, 1.0);
      break;
    case FinalOrientation::kVwVoting:
      if (w_v > 0.0) histogram_.Vote(q, w_v);
      break;
    case FinalOrientation::kCwClustering:
      histogram_.Add(q, sigma, 1.0);
      break;
    case FinalOrientation::kCwVwClustering:
    case FinalOrientation::kDensityMode:
      if (w_v > 0.0) AddDetection(view, sigma_motion, w_v);
      break;
  }
}

void OrientationFilter::AddDetection(const OrientationView& view, double sigma_motion, double w_v) {
  const double sigma = std::hypot(parameters_.sigma_cw, sigma_motion);
  const double precision = PrecisionWeight(view.mse, parameters_.mode);
  double everywhere = 0.0;
  std::vector<OrientationKernel> kernels;
  std::vector<double> weights;
  for (const Truth& truth : TruthsOf(view, knowledge_.confusion, &everywhere)) {
    const double weight = w_v * truth.share;
    histogram_.Add(truth.q_world_object, sigma, weight);
    if (truth.angle > 0.0 && truth.angle <= kApart * parameters_.sigma_cw) continue;
    // Where a detection's own mode is right, it tells where that is whatever it is confused with.
    const double certain = truth.angle > 0.0 ? weight : w_v;
    kernels.push_back({truth.q_world_object, sigma_motion, certain * precision});
    weights.push_back(weight);
  }
  if (everywhere > 0.0) histogram_.AddDensity({}, w_v * everywhere);
  if (parameters_.final_orientation == FinalOrientation::kDensityMode) {
    AddKernels(kernels, weights);
  }
}

// A detection that repeats the last one adds to its weight, so that a camera and an object at rest
// cost no more with every frame.
void OrientationFilter::AddKernels(const std::vector<OrientationKernel>& kernels,
                                   const std::vector<double>& w_v) {
  const bool repeats = std::equal(kernels.begin(),
                                  kernels.end(),
                                  kernels_.begin() + static_cast<std::ptrdiff_t>(last_view_),
                                  kernels_.end(),
                                  [](const OrientationKernel& a, const OrientationKernel& b) {
                                    return a.q.coeffs() == b.q.coeffs() && a.sigma == b.sigma;
                                  });
  if (!repeats) {
    last_view_ = kernels_.size();
    kernels_.insert(kernels_.end(), kernels.begin(), kernels.end());
    support_.insert(support_.end(), w_v.begin(), w_v.end());
    return;
  }
  for (size_t i = 0; i < kernels.size(); ++i) {
    kernels_[last_view_ + i].weight += kernels[i].weight;
    support_[last_view_ + i] += w_v[i];
  }
}

void OrientationFilter::FindFinalOrientation() {
  peaks_ = FindPeaks(histogram_, parameters_.peaks);
  if (!peaks_.empty()) {
    switch (parameters_.final_orientation) {
      case FinalOrientation::kVoting:
      case FinalOrientation::kVwVoting:
        peaks_.front().q = HeaviestCell();
        break;
      case FinalOrientation::kCwClustering:
      case FinalOrientation::kCwVwClustering:
        break;
      case FinalOrientation::kDensityMode:
        RefinePeaks();
        break;
    }
  }
  WeighByBelief();
  q_f_.emplace_back();
  if (!peaks_.empty()) q_f_.back() = peaks_.front().q;
}

// Every peak becomes the mode that mean shift reaches from it; peaks that reach the same mode, or
// one that a symmetry makes equal, become one. The best supported one is first.
void OrientationFilter::RefinePeaks() {
  struct Refined {
    OrientationPeak peak;
    double support;
  };
  std::vector<Refined> refined;
  for (const OrientationPeak& cluster : peaks_) {
    const OrientationPeak peak = AtMode(cluster);
    const auto same = std::find_if(refined.begin(), refined.end(), [&](const Refined& other) {
      return SymmetricAngle(knowledge_.symmetry, peak.q, other.peak.q) < parameters_.sigma_cw;
    });
    if (same != refined.end()) {
      same->peak.weight += peak.weight;
      continue;
    }
    refined.push_back({peak, Support(peak.q)});
  }
  std::stable_sort(refined.begin(), refined.end(), [](const Refined& a, const Refined& b) {
    return a.support > b.support;
  });
  peaks_.clear();
  for (const Refined& one : refined) peaks_.push_back(one.peak);
}

OrientationPeak OrientationFilter::AtMode(OrientationPeak peak) const {
  const DensityMode mode = RefineMode(kernels_, peak.q, parameters_.mode, knowledge_.symmetry);
  if (mode.density <= 0.0) return peak;  // No kernel reaches it: the cluster's mean stays.
  peak.q = mode.q;
  peak.covariance = mode.covariance;
  peak.spread = std::sqrt(mode.covariance.trace());
  return peak;
}

std::vector<ConfusionView> OrientationFilter::ViewsOfBelief() const {
  std::vector<ConfusionView> views;
  for (const OrientationView& view : views_) {
    const bool counts = VerificationWeight(view.mse, parameters_.sigma_vw) > 0.0;
    if (!view.q_world_camera || !counts) continue;
    views.push_back({view.q_world_camera->normalized(), view.q_world_object.normalized()});
  }
  return views;
}

// Gives every peak the probability of the hypotheses that it is the nearest to. Likely hypotheses
// have a peak even where the histogram is low: views can outvote what they rule out one by one.
void OrientationFilter::WeighByBelief() {
  belief_.clear();
  if (knowledge_.confusion == nullptr || peaks_.empty()) return;
  belief_ = ModeBelief(*knowledge_.confusion, ViewsOfBelief());
  if (belief_.empty()) return;
  for (OrientationPeak& peak : peaks_) peak.weight = 0.0;
  const double w_mode = parameters_.peaks.w_mode;
  const double likely = w_mode * belief_.front().probability;
  const double reach = knowledge_.confusion->parameters().mode_radius + parameters_.sigma_cw;
  const auto nearest_to = [this](const Eigen::Quaterniond& q, double radius) {
    OrientationPeak* nearest = nullptr;
    for (OrientationPeak& peak : peaks_) {
      const double angle = SymmetricAngle(knowledge_.symmetry, peak.q, q);
      if (angle >= radius) continue;
      radius = angle;
      nearest = &peak;
    }
    return nearest;
  };
  for (const OrientationHypothesis& hypothesis : belief_) {
    OrientationPeak* known = nearest_to(hypothesis.q_world_object, reach);
    if (known == nullptr && hypothesis.probability >= likely) {
      const OrientationPeak peak = PeakOf(hypothesis);
      known = nearest_to(peak.q, parameters_.sigma_cw);
      if (known == nullptr) peaks_.push_back(peak);
    }
    if (known != nullptr) known->weight += hypothesis.probability;
  }
  std::stable_sort(peaks_.begin(), peaks_.end(), [](const auto& a, const auto& b) {
    return a.weight > b.weight;
  });
  std::erase_if(peaks_, [least = w_mode * peaks_.front().weight](const OrientationPeak& peak) {
    return peak.weight < least;
  });
}

OrientationPeak OrientationFilter::PeakOf(const OrientationHypothesis& hypothesis) const {
  OrientationPeak peak;
  peak.q = hypothesis.q_world_object;
  peak.weight = hypothesis.probability;
  // As wide as the mass within reach, as those of the clusters are.
  std::vector<So3Grid::NearCell> cells;
  grid_->CellsWithin(peak.q, 2.0 * parameters_.sigma_cw, &cells);
  double mass = 0.0;
  for (const So3Grid::NearCell& cell : cells) {
    const double weight = static_cast<double>(histogram_.weights().At(cell.ordinal)) * cell.area;
    mass += weight;
    peak.spread += weight * cell.squared_angle;
  }
  peak.spread = mass > 0.0 ? std::sqrt(peak.spread / mass) : parameters_.sigma_cw;
  peak.covariance = peak.spread * peak.spread / 3.0 * Eigen::Matrix3d::Identity();
  return parameters_.final_orientation == FinalOrientation::kDensityMode ? AtMode(peak) : peak;
}

// What the histogram's weight (eq. 5) at an orientation would be on a grid without cells, modulo
// symmetry. Precision weights are left out: how well a detection fits tells how near it is to the
// mode that it is of, not which one is right.
double OrientationFilter::Support(const Eigen::Quaterniond& q) const {
  double support = 0.0;
  for (size_t i = 0; i < kernels_.size(); ++i) {
    const double angle = SymmetricAngle(knowledge_.symmetry, kernels_[i].q, q);
    const double sigma = std::hypot(parameters_.sigma_cw, kernels_[i].sigma);
    support += support_[i] * ConfidenceWeight(angle, sigma);
  }
  if (knowledge_.prior.is_uniform()) return support;
  return support * knowledge_.prior.Density(grid_->Ordinal(grid_->CellOf(q)));
}

Eigen::Quaterniond OrientationFilter::HeaviestCell() const {
  const CellWeights& weights = histogram_.weights();
  const std::vector<CellWeights::Placed> heaviest = weights.AtLeast(weights.Largest());
  std::vector<So3Grid::Cell> cell;
  grid_->CellsAt(heaviest.front().ordinal, 1, &cell);
  return Canonical(grid_->Representative(cell.front()));
}

Result<Eigen::Quaterniond> OrientationFilter::Estimate() const {
  if (peaks_.empty()) {
    return Error{ErrorCode::kNotFound, "no view with weight was fused, so there is no orientation"};
  }
  return Canonical(peaks_.front().q);
}

double OrientationFilter::last_change() const { return q_f_.size() < 2 ? -1.0 : ChangeAt(0); }

double OrientationFilter::ChangeAt(int age) const {
  const auto last = q_f_.end() - 1 - age;
  const auto before = last - 1;
  if (!last->has_value() || !before->has_value()) return -1.0;
  return SymmetricAngle(knowledge_.symmetry, **before, **last);
}

bool OrientationFilter::converged() const {
  const auto needed =
      static_cast<size_t>(std::max(parameters_.converge_views + 1, parameters_.min_views));
  if (peaks_.empty() || q_f_.size() < needed) return false;
  for (int i = 0; i < parameters_.converge_views; ++i) {
    const double change = ChangeAt(i);
    if (!(change >= 0.0 && change < parameters_.converge_angle)) return false;
  }
  return true;
}

Result<std::vector<Eigen::Quaterniond>> AllFinalOrientations(
    const So3Grid& grid,
    const OrientationFilterParameters& parameters,
    std::span<const OrientationView> views) {
  std::vector<Eigen::Quaterniond> all;
  for (const FinalOrientation final_orientation : kFinalOrientations) {
    OrientationFilterParameters one = parameters;
    one.final_orientation = final_orientation;
    OrientationFilter filter(grid, one);
    for (const OrientationView& view : views) {
      if (const auto added = filter.Add(view); !added) return added.error();
    }
    const auto q_f = filter.Estimate();
    if (!q_f) return q_f.error();
    all.push_back(*q_f);
  }
  return all;
}

}  // namespace vantage
