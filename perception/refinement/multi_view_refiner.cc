#include "perception/refinement/multi_view_refiner.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "common/check.h"
#include "common/format.h"
#include "perception/refinement/multi_view_problem.h"
#include "perception/refinement/view_evidence.h"

namespace vantage {
namespace {

constexpr int kFewestPixels = 50;    // Of an object in a view that is to count.
constexpr int kFirstPoints = 1500;   // Drawn of a model in a view, but for the last round,
constexpr int kJudgedPoints = 2000;  // and to tell which of two poses the depth agrees with.
constexpr double kSharedBias = 0.5;  // Of the bias's variance, what all views have alike.
constexpr double kMostNoise = 4.0;
constexpr double kLeastNoise = 0.05;  // Variance of the noise, of the parameters' one.

bool IsRigid(const Pose& T) {
  constexpr double kTolerance = 1e-6;
  const Eigen::Matrix3d R = T.linear();
  return T.matrix().allFinite() && T.translation().norm() < 1e6 &&
         (R.transpose() * R - Eigen::Matrix3d::Identity()).norm() < kTolerance &&
         R.determinant() > 0.0;
}

bool IsUsable(const RefinementView& view) {
  return IsRigid(view.T_world_camera) && view.camera.Validate() && view.depth != nullptr &&
         view.depth->width == view.camera.width && view.depth->height == view.camera.height &&
         view.depth->depth.size() ==
             static_cast<size_t>(view.camera.width) * static_cast<size_t>(view.camera.height);
}

std::string WhyNotUsable(const RefinementStart& start, size_t num_views) {
  if (!IsRigid(start.T_world_object)) return "its start is no pose";
  if (!(start.model.radius > 0.0) || !start.model.center.allFinite() ||
      start.model.mesh.num_triangles() == 0) {
    return "its model has no extent";
  }
  if (!(start.max_rotation > 0.0) || !(start.max_translation > 0.0)) {
    return Format("its bounds are %g rad and %g m, expected above 0",
                  start.max_rotation,
                  start.max_translation);
  }
  for (size_t i = 0; i < start.views.size(); ++i) {
    if (start.views[i] < num_views && (i == 0 || start.views[i] > start.views[i - 1])) continue;
    return Format("its views are no ascending indices below %zu", num_views);
  }
  return {};
}

// A term that knows of an error of its own view: motions of the object with this covariance.
void AllowFor(const Vector6& variances, Matrix6* information, Vector6* right) {
  // (I + A B)^-1 A is the information of the sum of both errors.
  const Matrix6 share = (Matrix6::Identity() + *information * variances.asDiagonal()).inverse();
  const Matrix6 reduced = share * *information;
  *information = 0.5 * (reduced + reduced.transpose());
  *right = share * *right;
}

// How well an object's depth agrees with a pose.
struct Agreement {
  double cost = 0.0;  // Tukey's biweight, 0 to 1, of each measurement on the model.
  int64_t compared = 0;
  int64_t pixels = 0;
  double weight = 0.0;
  double weighted_square = 0.0;  // m^2
  int views = 0;

  void Add(const ViewEvidence& evidence) {
    cost += evidence.cost;
    compared += evidence.compared;
    pixels += evidence.pixels;
    weight += evidence.weight;
    weighted_square += evidence.weighted_square;
    views += evidence.pixels >= kFewestPixels ? 1 : 0;
  }
  [[nodiscard]] double mean() const {
    return compared > 0 ? cost / static_cast<double>(compared) : 1.0;
  }
  [[nodiscard]] double rms() const {
    return weight > 0.0 ? std::sqrt(weighted_square / weight) : 0.0;
  }
};

}  // namespace

class MultiViewRefiner::Impl {
 public:
  explicit Impl(const MultiViewParameters& parameters) : parameters_(parameters) {
    VANTAGE_CHECK(parameters.Validate().ok(), "parameters of the refinement over several views");
  }

  MultiViewResult Refine(std::span<const RefinementStart> starts,
                         std::span<const RefinementView> views) {
    starts_ = starts;
    views_ = views;
    MultiViewResult result;
    std::vector<size_t> active;
    for (size_t i = 0; i < starts.size(); ++i) {
      result.objects.push_back(Refused(i, WhyNotUsable(starts[i], views.size())));
      if (result.objects.back().note.empty()) active.push_back(i);
    }
    // An object that is refused pulls the cameras no longer: the others are refined without it.
    bool is_settled = false;
    while (!is_settled) {
      Start(active);
      std::vector<size_t> kept;
      for (const auto& [object, outcome] : Attempt(active)) {
        result.objects[object] = outcome;
        if (outcome.is_refined) kept.push_back(object);
      }
      is_settled = kept.size() == active.size() || kept.empty();
      if (kept.empty()) Start({});
      active = kept;
    }
    for (size_t view = 0; view < views.size(); ++view) {
      result.T_world_camera.push_back(state_.Camera(view, views[view].T_world_camera));
    }
    result.T_camera_adjusted.linear() = ExpSo3(state_.hand_eye.head<3>()).toRotationMatrix();
    result.T_camera_adjusted.translation() = state_.hand_eye.tail<3>();
    return result;
  }

 private:
  using Outcomes = std::vector<std::pair<size_t, MultiViewRefined>>;

  [[nodiscard]] MultiViewRefined Refused(size_t object, std::string why) const {
    MultiViewRefined refused;
    refused.note = std::move(why);
    refused.T_world_object = starts_[object].T_world_object;
    return refused;
  }

  void Start(const std::vector<size_t>& active) {
    state_ = {};
    problem_ = {};
    cameras_.clear();
    noise_.assign(active.size() * views_.size(), 1.0);
    for (const RefinementView& view : views_) {
      cameras_.push_back(IsUsable(view) ? view.T_world_camera : Pose::Identity());
    }
    state_.camera.assign(views_.size(), Vector6::Zero());
    problem_.T_world_camera = cameras_;
    problem_.camera_rotation = parameters_.camera_rotation;
    problem_.camera_translation = parameters_.camera_translation;
    problem_.bias_tilt = std::sqrt(kSharedBias) * parameters_.single.bias_tilt;
    problem_.bias_at_1m = std::sqrt(kSharedBias) * parameters_.single.bias_at_1m;
    if (parameters_.adjust_hand_eye) {
      problem_.hand_eye_rotation = parameters_.hand_eye_rotation;
      problem_.hand_eye_translation = parameters_.hand_eye_translation;
    }
    for (const size_t object : active) {
      state_.T_world_object.push_back(starts_[object].T_world_object);
      problem_.T_world_object_start.push_back(starts_[object].T_world_object);
      problem_.centers.push_back(starts_[object].model.center);
    }
  }

  // Draws all where they are thought to be. @param terms may be null.
  std::vector<Agreement> Look(const std::vector<size_t>& active,
                              int points,
                              Weighing weighing,
                              std::vector<ViewTerm>* terms) {
    std::vector<Agreement> agreements;
    for (size_t i = 0; i < active.size(); ++i) {
      const RefinementStart& start = starts_[active[i]];
      Agreement& agreement = agreements.emplace_back();
      for (const size_t view : start.views) {
        if (!IsUsable(views_[view])) continue;
        const Pose T_camera_object =
            state_.Camera(view, cameras_[view]).inverse(Eigen::Isometry) * state_.T_world_object[i];
        double& noise = noise_[i * views_.size() + view];
        const ViewEvidence evidence = gatherer_.Gather(start.model,
                                                       T_camera_object,
                                                       views_[view].camera,
                                                       *views_[view].depth,
                                                       points,
                                                       weighing,
                                                       noise,
                                                       parameters_);
        agreement.Add(evidence);
        if (terms == nullptr || evidence.pixels < kFewestPixels) continue;
        terms->push_back(Term(i, view, T_camera_object, evidence));
        noise = std::clamp(noise * evidence.noise_variance, kLeastNoise, kMostNoise);
      }
    }
    return agreements;
  }

  [[nodiscard]] ViewTerm Term(size_t object,
                              size_t view,
                              const Pose& T_camera_object,
                              const ViewEvidence& evidence) const {
    const double noise = std::max(evidence.noise_variance, kLeastNoise);
    ViewTerm term{
        object, view, T_camera_object, evidence.information / noise, evidence.right / noise};
    const double depth = (T_camera_object * problem_.centers[object]).z();
    // A sensor's bias is smooth over an object: it tilts and shifts the whole, by chance.
    const double tilt = parameters_.single.bias_tilt;
    const double shift = parameters_.single.bias_at_1m * depth * depth;
    Vector6 variances;
    variances << Eigen::Vector3d::Constant(parameters_.view_rotation * parameters_.view_rotation),
        Eigen::Vector3d::Constant(parameters_.view_translation * parameters_.view_translation);
    variances.head<2>().array() += (1.0 - kSharedBias) * tilt * tilt;
    variances[5] += (1.0 - kSharedBias) * shift * shift;
    AllowFor(variances, &term.information, &term.right);
    return term;
  }

  Outcomes Attempt(const std::vector<size_t>& active) {
    Outcomes outcomes;
    const auto refuse_all = [&](const char* why) {
      for (const size_t object : active) outcomes.emplace_back(object, Refused(object, why));
    };
    if (active.empty()) return outcomes;
    const std::vector<Agreement> before = Look(active, kJudgedPoints, Weighing::kAlike, nullptr);
    std::vector<Matrix6> covariances;
    for (int round = 0; round < parameters_.rounds; ++round) {
      const bool is_last = round + 1 == parameters_.rounds;
      problem_.terms.clear();
      Look(active,
           is_last ? parameters_.points : kFirstPoints,
           is_last ? Weighing::kWhitened : Weighing::kAlike,
           &problem_.terms);
      if (!SolveMultiView(problem_, &state_, is_last ? &covariances : nullptr)) {
        refuse_all("the least squares problem has no solution");
        return outcomes;
      }
    }
    std::fill(noise_.begin(), noise_.end(), 1.0);
    const std::vector<Agreement> after = Look(active, kJudgedPoints, Weighing::kAlike, nullptr);
    for (size_t i = 0; i < active.size(); ++i) {
      outcomes.emplace_back(active[i], Judge(active[i], i, before[i], after[i], covariances[i]));
    }
    return outcomes;
  }

  [[nodiscard]] MultiViewRefined Judge(size_t object,
                                       size_t i,
                                       const Agreement& before,
                                       const Agreement& after,
                                       const Matrix6& covariance) const {
    constexpr double kAsWell = 1.1;     // Times the cost at the start: it is not what is minimized.
    constexpr double kChance = 0.01;    // And a share of the measurements, which is chance.
    constexpr double kAsMuch = 0.5;     // Of the measurements: faces seen at a slant come and go.
    constexpr double kExplained = 0.5;  // Of the measurements, at least.
    const RefinementStart& start = starts_[object];
    const Pose& T = state_.T_world_object[i];
    if (after.views < parameters_.min_views) {
      return Refused(
          object,
          Format("%d views show enough of it, expected %d", after.views, parameters_.min_views));
    }
    const Eigen::Quaterniond q(T.linear());
    const double angle =
        SymmetricAngle(start.symmetry, Eigen::Quaterniond(start.T_world_object.linear()), q);
    const double shift =
        (T * start.model.center - start.T_world_object * start.model.center).norm();
    if (!(angle <= start.max_rotation) || !(shift <= start.max_translation)) {
      return Refused(
          object,
          Format("the depth lies %.2f deg and %.1f mm from the fused pose, at most %.2f deg "
                 "and %.1f mm are one mode",
                 angle / kDegree,
                 1e3 * shift,
                 start.max_rotation / kDegree,
                 1e3 * start.max_translation));
    }
    if (after.mean() > 1.0 - kExplained) {
      return Refused(
          object,
          Format("%.0f %% of its depth is off the model's surface, expected at most %.0f %%",
                 100.0 * after.mean(),
                 100.0 * (1.0 - kExplained)));
    }
    const bool is_as_much =
        static_cast<double>(after.compared) >= kAsMuch * static_cast<double>(before.compared);
    if (!(after.mean() <= kAsWell * before.mean() + kChance) || !is_as_much) {
      return Refused(
          object,
          Format("the fused pose explains the depth better: cost %.4f of %lld px, refined "
                 "%.4f of %lld px",
                 before.mean(),
                 static_cast<long long>(before.compared),
                 after.mean(),
                 static_cast<long long>(after.compared)));
    }
    MultiViewRefined refined;
    refined.is_refined = true;
    refined.T_world_object = T;
    refined.covariance = WithFreeTurn(start, T, covariance);
    refined.rms = after.rms();
    refined.views = after.views;
    refined.pixels = after.pixels;
    return refined;
  }

  // Nobody sees by how much a solid of revolution is turned, whatever its mesh's edges say.
  static Matrix6 WithFreeTurn(const RefinementStart& start, const Pose& T, Matrix6 covariance) {
    if (start.symmetry.kind != SymmetryGroup::Kind::kContinuous) return covariance;
    const Eigen::Vector3d axis = T.linear() * start.symmetry.axis;
    covariance.topLeftCorner<3, 3>() += axis * axis.transpose();  // A radian.
    return covariance;
  }

  MultiViewParameters parameters_;
  ViewEvidenceGatherer gatherer_;
  std::span<const RefinementStart> starts_;
  std::span<const RefinementView> views_;
  std::vector<Pose> cameras_;  // As the robot tells.
  std::vector<double> noise_;  // Variance of what was expected, by object and view.
  MultiViewProblem problem_;
  MultiViewState state_;
};

MultiViewRefiner::MultiViewRefiner(const MultiViewParameters& parameters)
    : impl_(std::make_unique<Impl>(parameters)) {}
MultiViewRefiner::~MultiViewRefiner() = default;

MultiViewResult MultiViewRefiner::Refine(std::span<const RefinementStart> starts,
                                         std::span<const RefinementView> views) {
  return impl_->Refine(starts, views);
}

}  // namespace vantage
