#include "perception/calibration/image_calibration.h"

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>

#include "common/format.h"
#include "common/statistics.h"
#include "perception/calibration/consensus.h"
#include "perception/calibration/observability.h"
#include "perception/calibration/pose_adjustment.h"
#include "perception/calibration/pose_calibration.h"
#include "perception/calibration/reprojection.h"
#include "perception/calibration/reprojection_adjustment.h"
#include "perception/calibration/target_pose.h"
#include "perception/calibration/variance_components.h"

namespace vantage {
namespace {

using Eigen::VectorXd;

constexpr int kMostRounds = 15;
/// Where the noise changes by less from round to round, it is settled.
constexpr double kSettled = 0.02;
/// Standard deviations beyond which a point counts less, by the square of how much it is beyond.
constexpr double kFarPoint = 3.0;
/// Chance that a set of views without outliers loses any.
constexpr double kFalseAlarms = 0.01;

Error Invalid(std::string message) { return {ErrorCode::kInvalidArgument, std::move(message)}; }

Result<void> CheckHand(const Pose& T_base_hand) {
  constexpr double kFarthest = 1e6;  // m
  if (!(T_base_hand.translation().norm() <= kFarthest)) {
    return Invalid(Format("the hand is at (%g, %g, %g) m, expected finite numbers within %g m",
                          T_base_hand.translation().x(),
                          T_base_hand.translation().y(),
                          T_base_hand.translation().z(),
                          kFarthest));
  }
  const auto rotation = ProjectToRotation(T_base_hand.linear(), 1e-3);
  if (!rotation) return rotation.error();
  return {};
}

/// A view with enough points.
struct Candidate {
  size_t index = 0;  ///< in the input
  std::vector<TargetPose> poses;
  size_t chosen = 0;
  bool is_used = false;
  double squared_deviation = 0.0;  ///< whitened, 6 degrees of freedom
};

class Calibration {
 public:
  Calibration(HandEyeSetup setup,
              std::span<const ImageView> views,
              const CameraModel& camera,
              const LensDistortion& distortion,
              const ImageCalibrationOptions& options)
      : views_(views), options_(options) {
    told_ = {.pixel = options.noise.pixel,
             .robot_rotation = options.noise.robot_rotation,
             .robot_translation = options.noise.robot_translation};
    problem_.setup = setup;
    problem_.estimates_robot_scale = options.estimate_robot_scale;
    problem_.estimates_pinhole = options.estimate_focal_lengths;
    problem_.estimates_distortion = options.estimate_distortion;
    problem_.trajectory = options.trajectory;
    problem_.expected_camera = camera;
    state_.camera = camera;
    state_.distortion = distortion;
    noise_.noise = told_;
  }

  Result<HandEyeResult> Run() {
    if (const auto found = FindPoses(); !found) return found.error();
    if (const auto agreed = Agree(); !agreed) return agreed.error();
    for (int round = 0; round < kMostRounds; ++round) {
      if (const auto adjusted = Adjust(); !adjusted) return adjusted.error();
      const bool is_noise_settled = UpdateNoise();
      WeighPoints();
      if (problem_.estimates_pinhole || problem_.estimates_distortion) FindPosesAnew();
      const bool is_choice_settled = !ChooseViews();
      if (NumUsed() < 3) {
        return Invalid(Format("no three of the %zu views of the target agree", candidates_.size()));
      }
      if (is_noise_settled && is_choice_settled) break;
      if (!is_choice_settled) RestartPoses();
    }
    return Collect();
  }

 private:
  Result<void> FindPoses() {
    for (size_t i = 0; i < views_.size(); ++i) {
      if (const auto valid = CheckHand(views_[i].T_base_hand); !valid) {
        return Named(i, valid.error());
      }
      if (views_[i].points.size() < 4) continue;
      auto poses = FindTargetPoses(views_[i].points, state_.camera, state_.distortion, told_.pixel);
      if (!poses) {
        // Points in a line are of no use; numbers that are none are an error.
        for (const TargetPoint& point : views_[i].points) {
          if (!point.pixel.allFinite() || !point.p_target.allFinite()) {
            return Named(i, poses.error());
          }
        }
        continue;
      }
      if (options_.trajectory != nullptr && !HandOf(views_[i], 0.0)) {
        return Named(i,
                     Invalid("the robot's poses do not reach around its time, which the time "
                             "offset needs"));
      }
      candidates_.push_back({.index = i, .poses = std::move(poses).value()});
    }
    if (candidates_.size() < 3) {
      return Invalid(
          Format("%zu of %zu views show 4 points of the target or more, expected at "
                 "least 3",
                 candidates_.size(),
                 views_.size()));
    }
    return {};
  }

  [[nodiscard]] Error Named(size_t index, const Error& error) const {
    std::string name = views_[index].name.empty() ? Format("view %zu", index) : views_[index].name;
    return Error{error.code, name.append(": ").append(error.message)};
  }

  /// The start: views that agree in closed form, where the time offset is asked for with it.
  Result<void> Agree() {
    std::vector<PoseView> poses;
    for (const Candidate& candidate : candidates_) {
      PoseView view{.name = views_[candidate.index].name,
                    .utime = views_[candidate.index].utime,
                    .T_base_hand = *HandOf(views_[candidate.index], 0.0),
                    .T_camera_target = candidate.poses[0].T_camera_target,
                    .covariance = candidate.poses[0].covariance};
      for (size_t i = 1; i < candidate.poses.size(); ++i) {
        view.other_T_camera_target.push_back(candidate.poses[i].T_camera_target);
      }
      poses.push_back(std::move(view));
    }
    const auto start = Start(poses);
    if (!start) return start.error();
    std::vector<double> pixel_rms;
    for (size_t i = 0; i < candidates_.size(); ++i) {
      Candidate& candidate = candidates_[i];
      candidate.is_used = (*start)[i];
      if (!candidate.is_used) continue;
      candidate.chosen = Closest(candidate).first;
      const double count = 2.0 * static_cast<double>(views_[candidate.index].points.size());
      pixel_rms.push_back(candidate.poses[candidate.chosen].pixel_rms *
                          std::sqrt(count / std::max(1.0, count - 6.0)));
    }
    if (NumUsed() < 3) return Invalid("no three views of the target agree");
    noise_.noise.pixel = std::max(Median(pixel_rms), 0.1 * told_.pixel);
    // At first all that does not fit is the robot's.
    double squares = 0.0;
    for (const Candidate& candidate : candidates_) {
      if (candidate.is_used) squares += SquaredDeviation(candidate, candidate.chosen);
    }
    const double freedom = std::max(1.0, 6.0 * static_cast<double>(NumUsed()) - 12.0);
    const double scale = std::max(std::sqrt(squares / freedom), 0.1);
    noise_.noise.robot_rotation *= scale;
    noise_.noise.robot_translation *= scale;
    RestartPoses();
    return {};
  }

  /// Finds X and Y, and which candidates agree.
  Result<std::vector<bool>> Start(std::span<const PoseView> poses) {
    std::vector<bool> agrees;
    if (options_.trajectory != nullptr) {
      const auto calibrated = CalibrateFromPoses(
          problem_.setup,
          poses,
          {.noise = options_.noise, .trajectory = options_.trajectory, .seed = options_.seed});
      if (!calibrated) return calibrated.error();
      state_.transforms = {calibrated->T_x, calibrated->T_y};
      state_.time_offset = calibrated->time_offset.value_or(0.0);
      initial_method_ = calibrated->initial_method;
      for (const ViewResidual& view : calibrated->views) agrees.push_back(!view.is_outlier);
      return agrees;
    }
    const auto consensus = FindConsensus(problem_.setup, poses, options_.noise, options_.seed);
    if (!consensus) return consensus.error();
    state_.transforms = {consensus->T_x, consensus->T_y};
    initial_method_ = consensus->method;
    for (const int chosen : consensus->chosen) agrees.push_back(chosen >= 0);
    return agrees;
  }

  /// The hand as the robot tells it at a view's time and an offset, s.
  [[nodiscard]] std::optional<Pose> HandOf(const ImageView& view, double offset) const {
    if (options_.trajectory == nullptr) return view.T_base_hand;
    return options_.trajectory->At(static_cast<double>(view.utime) + 1e6 * offset);
  }

  [[nodiscard]] size_t NumUsed() const {
    return static_cast<size_t>(
        std::count_if(candidates_.begin(), candidates_.end(), [](const Candidate& candidate) {
          return candidate.is_used;
        }));
  }

  /// The problem's views are those that are used, each from its own pose.
  void RestartPoses() {
    problem_.views.clear();
    state_.T_camera_target.clear();
    for (const Candidate& candidate : candidates_) {
      if (!candidate.is_used) continue;
      const ImageView& view = views_[candidate.index];
      problem_.views.push_back({.points = view.points,
                                .weights = std::vector<double>(view.points.size(), 1.0),
                                .T_base_hand = view.T_base_hand,
                                .utime = view.utime});
      state_.T_camera_target.push_back(candidate.poses[candidate.chosen].T_camera_target);
    }
  }

  Result<void> Adjust() {
    if (!AdjustReprojection(problem_, noise_.noise, &state_) || !state_.camera.Validate().ok()) {
      return Invalid(
          "the least-squares problem of the hand-eye calibration has no solution; add "
          "views, or keep the camera's intrinsics as they are");
    }
    equations_ = LinearizeReprojection(problem_, state_);
    return {};
  }

  /// Whether the noise changed but little.
  bool UpdateNoise() {
    const ReprojectionNoise before = noise_.noise;
    noise_ = EstimateNoise(equations_, told_, before, PriorInformation(problem_));
    const auto is_settled = [](double now, double then) {
      return std::abs(now - then) <= kSettled * then;
    };
    return is_settled(noise_.noise.pixel, before.pixel) &&
           is_settled(noise_.noise.robot_rotation, before.robot_rotation) &&
           is_settled(noise_.noise.robot_translation, before.robot_translation);
  }

  void WeighPoints() {
    for (size_t i = 0; i < problem_.views.size(); ++i) {
      ReprojectionView& view = problem_.views[i];
      for (size_t k = 0; k < view.points.size(); ++k) {
        const Eigen::Vector2d shown = Reproject(state_.camera,
                                                state_.distortion,
                                                state_.T_camera_target[i] * view.points[k].p_target)
                                          .pixel;
        const double deviation = (shown - view.points[k].pixel).norm() / noise_.noise.pixel;
        const double share = kFarPoint / std::max(deviation, kFarPoint);
        view.weights[k] = share * share;
      }
    }
  }

  void FindPosesAnew() {
    for (Candidate& candidate : candidates_) {
      auto poses = FindTargetPoses(
          views_[candidate.index].points, state_.camera, state_.distortion, told_.pixel);
      if (!poses) continue;
      candidate.poses = std::move(poses).value();
      candidate.chosen = std::min(candidate.chosen, candidate.poses.size() - 1);
    }
  }

  /// A view as it is compared with X and Y: by its own pose of the target.
  [[nodiscard]] AdjustmentView PoseOnly(const Candidate& candidate,
                                        size_t chosen,
                                        const ReprojectionState& state) const {
    const TargetPose& pose = candidate.poses[chosen];
    const double scale = noise_.noise.pixel / told_.pixel;
    const ImageView& view = views_[candidate.index];
    return {.T_base_hand = HandOf(view, state.time_offset).value_or(view.T_base_hand),
            .T_camera_target = pose.T_camera_target,
            .camera_covariance = scale * scale * pose.covariance};
  }

  [[nodiscard]] AdjustmentState PoseState(const ReprojectionState& state) const {
    return {.transforms = state.transforms, .robot_scale = state.robot_scale};
  }

  [[nodiscard]] double SquaredDeviation(const Candidate& candidate, size_t chosen) const {
    const AdjustmentView view = PoseOnly(candidate, chosen, state_);
    const AdjustmentProblem problem{.setup = problem_.setup,
                                    .noise = {.robot_rotation = noise_.noise.robot_rotation,
                                              .robot_translation = noise_.noise.robot_translation,
                                              .scales = {}}};
    const auto error = ViewError(problem_.setup, view, PoseState(state_));
    const HandEyeCovariance covariance = ViewErrorCovariance(problem, view, PoseState(state_));
    return error.dot(covariance.ldlt().solve(error));
  }

  /// Which of a candidate's poses is closest to X and Y, and its squared deviation.
  [[nodiscard]] std::pair<size_t, double> Closest(const Candidate& candidate) const {
    std::pair<size_t, double> closest{0, SquaredDeviation(candidate, 0)};
    for (size_t i = 1; i < candidate.poses.size(); ++i) {
      const double squared = SquaredDeviation(candidate, i);
      if (squared < closest.second) closest = {i, squared};
    }
    return closest;
  }

  /// Whether another choice of views, or of their poses, was made.
  bool ChooseViews() {
    const double freedom = std::max(2.0, noise_.rotation_freedom + noise_.translation_freedom);
    const double chance = kFalseAlarms / static_cast<double>(candidates_.size());
    const double limit =
        6.0 * boost::math::quantile(boost::math::fisher_f_distribution<double>(6.0, freedom),
                                    1.0 - chance);
    bool is_changed = false;
    for (Candidate& candidate : candidates_) {
      const auto [best, least] = Closest(candidate);
      const bool is_used = least <= limit;
      is_changed |= is_used != candidate.is_used || (is_used && best != candidate.chosen);
      candidate.is_used = is_used;
      candidate.chosen = best;
      candidate.squared_deviation = least;
    }
    return is_changed;
  }

  Result<HandEyeResult> Collect() {
    equations_ = LinearizeReprojection(problem_, state_);
    const VectorXd prior = PriorInformation(problem_);
    const SharedEquations shared = ShareEquations(equations_, noise_.noise, prior);
    HandEyeResult result;
    result.setup = problem_.setup;
    result.T_x = state_.transforms.T_x;
    result.T_y = state_.transforms.T_y;
    result.initial_method = initial_method_;
    result.covariance = shared.covariance.topLeftCorner<6, 6>();
    result.target_covariance = shared.covariance.block<6, 6>(6, 6);
    result.cross_covariance = shared.covariance.block<6, 6>(0, 6);
    result.cross_covariance = shared.covariance.block<6, 6>(0, 6);
    const double freedom = EffectiveFreedom(equations_, noise_, prior);
    result.squared_radius_95 =
        6.0 * boost::math::quantile(boost::math::fisher_f_distribution<double>(6.0, freedom), 0.95);
    const HandEyeCovariance as_told =
        ShareEquations(equations_, told_, prior).covariance.topLeftCorner<6, 6>();
    result.noise_scale =
        std::pow(result.covariance.determinant() / as_told.determinant(), 1.0 / 12.0);
    CollectAskedFor(shared, &result);
    CollectViews(shared, &result);
    std::vector<Pose> hands;
    for (const ReprojectionView& view : problem_.views) hands.push_back(view.T_base_hand);
    result.observability = AssessObservability(
        problem_.setup, hands, result.covariance, noise_.noise.robot_rotation);
    return result;
  }

  void CollectAskedFor(const SharedEquations& shared, HandEyeResult* result) const {
    Eigen::Index next = 12;
    if (problem_.estimates_robot_scale) {
      result->robot_scale = state_.robot_scale;
      result->robot_scale_sigma = std::sqrt(shared.covariance(next, next));
      ++next;
    }
    if (problem_.trajectory != nullptr) {
      result->time_offset = state_.time_offset;
      result->time_offset_sigma = std::sqrt(shared.covariance(next, next));
    }
    if (problem_.estimates_pinhole) result->camera = state_.camera;
    if (problem_.estimates_distortion) result->distortion = state_.distortion;
  }

  void CollectViews(const SharedEquations& shared, HandEyeResult* result) const {
    for (const ImageView& view : views_) {
      result->views.push_back({.name = view.name, .is_outlier = true});
    }
    size_t used = 0;
    Eigen::Vector4d squares = Eigen::Vector4d::Zero();
    for (const Candidate& candidate : candidates_) {
      ViewResidual& residual = result->views[candidate.index];
      residual.is_outlier = !candidate.is_used;
      residual.deviation = std::sqrt(candidate.squared_deviation / 6.0);
      residual.pixels = PixelResidual(candidate);
      const auto error = ErrorBy(candidate, state_);
      residual.rotation = error.head<3>().norm();
      residual.translation = error.tail<3>().norm();
      if (!candidate.is_used) continue;
      const auto left_out = ErrorBy(candidate, StateWithout(shared, used++));
      residual.left_out_rotation = left_out.head<3>().norm();
      residual.left_out_translation = left_out.tail<3>().norm();
      squares += Eigen::Vector4d(residual.rotation,
                                 residual.translation,
                                 residual.left_out_rotation,
                                 residual.left_out_translation)
                     .cwiseAbs2();
    }
    const Eigen::Vector4d rms = (squares / static_cast<double>(used)).cwiseSqrt();
    result->rotation_rms = rms[0];
    result->translation_rms = rms[1];
    result->left_out_rotation_rms = rms[2];
    result->left_out_translation_rms = rms[3];
  }

  [[nodiscard]] Eigen::Matrix<double, 6, 1> ErrorBy(const Candidate& candidate,
                                                    const ReprojectionState& state) const {
    return ViewError(
        problem_.setup, PoseOnly(candidate, candidate.chosen, state), PoseState(state));
  }

  /// The state without a view that was used: one step of Gauss-Newton from the optimum.
  [[nodiscard]] ReprojectionState StateWithout(const SharedEquations& shared, size_t used) const {
    const Eigen::MatrixXd information = shared.information - shared.of_view[used];
    const VectorXd step =
        information.completeOrthogonalDecomposition().solve(shared.gradient_of_view[used]);
    return MovedShared(problem_, state_, step);
  }

  /// px, of the points where X, Y and the robot say they are; the image's diagonal where they are
  /// behind the camera.
  [[nodiscard]] double PixelResidual(const Candidate& candidate) const {
    const AdjustmentView view = PoseOnly(candidate, candidate.chosen, state_);
    Pose T_base_hand = view.T_base_hand;
    T_base_hand.translation() *= state_.robot_scale;
    const Pose T_camera_target =
        (EquationOfHand(problem_.setup, T_base_hand) * state_.transforms.T_x).inverse() *
        state_.transforms.T_y;
    const std::vector<TargetPoint>& points = views_[candidate.index].points;
    double squares = 0.0;
    for (const TargetPoint& point : points) {
      const Eigen::Vector3d p_camera = T_camera_target * point.p_target;
      if (!(p_camera.z() > 1e-6)) return std::hypot(state_.camera.width, state_.camera.height);
      squares +=
          (Reproject(state_.camera, state_.distortion, p_camera).pixel - point.pixel).squaredNorm();
    }
    return std::sqrt(squares / (2.0 * static_cast<double>(points.size())));
  }

  std::span<const ImageView> views_;
  const ImageCalibrationOptions& options_;
  ReprojectionNoise told_;
  ReprojectionProblem problem_;
  ReprojectionState state_;
  std::vector<Candidate> candidates_;
  std::vector<ViewEquations> equations_;  // Of the views used.
  NoiseEstimate noise_;
  std::string initial_method_;
};

Result<void> CheckNoise(const HandEyeNoise& noise) {
  for (const double sigma : {noise.robot_rotation, noise.robot_translation, noise.pixel}) {
    if (!(sigma > 0.0 && sigma <= 1e3)) {
      return Invalid(
          Format("noise of the robot of %g rad and %g m and of points of %g px, expected "
                 "above 0 to 1000 each",
                 noise.robot_rotation,
                 noise.robot_translation,
                 noise.pixel));
    }
  }
  return {};
}

}  // namespace

Result<HandEyeResult> CalibrateFromImages(HandEyeSetup setup,
                                          std::span<const ImageView> views,
                                          const CameraModel& camera,
                                          const LensDistortion& distortion,
                                          const ImageCalibrationOptions& options) {
  if (const auto valid = camera.Validate(); !valid) return valid.error();
  if (const auto valid = CheckNoise(options.noise); !valid) return valid.error();
  return Calibration(setup, views, camera, distortion, options).Run();
}

}  // namespace vantage
