#include "perception/calibration/drift_check.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <span>
#include <vector>

#include "common/format.h"
#include "perception/calibration/pose_adjustment.h"

namespace vantage {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kNothingKnown = 1e6;  // Variance (rad^2, m^2) of what has no prior.
// Standard deviations of how a camera or a target moves when it is knocked: what few views leave
// open is not told to be more.
constexpr double kKnockRotation = 10.0 * kDegree;  // rad
constexpr double kKnockTranslation = 0.05;         // m

/// The x that a chi-square variable of 6 degrees of freedom exceeds with a probability.
double ChiSquare6(double probability) {
  // Its survival function is exp(-h) (1 + h + h^2 / 2) with h = x / 2.
  double low = 0.0;
  double high = 1000.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    const double h = 0.5 * middle;
    (std::exp(-h) * (1.0 + h + 0.5 * h * h) > probability ? low : high) = middle;
  }
  return high;
}

/// The windows that are tested: 1, 3, 6, 12, ... views, and all.
std::vector<size_t> Windows(size_t num_views) {
  std::vector<size_t> windows;
  if (num_views > 1) windows.push_back(1);
  for (size_t length = 3; length < num_views; length *= 2) windows.push_back(length);
  if (num_views > 0) windows.push_back(num_views);
  return windows;
}

bool SamePlace(const Pose& a, const Pose& b) {
  constexpr double kDistance = 0.005;      // m
  constexpr double kTurn = 1.0 * kDegree;  // rad
  return (a.translation() - b.translation()).norm() < kDistance &&
         GeodesicAngle(Eigen::Quaterniond(a.linear()), Eigen::Quaterniond(b.linear())) < kTurn;
}

Error OutOfRange(const char* name, double value, const char* range) {
  return Error{ErrorCode::kInvalidArgument,
               Format("drift check: %s is %g, expected %s", name, value, range)};
}

}  // namespace

Result<void> DriftCheckParameters::Validate() const {
  if (!(window >= 3 && window <= 1000)) return OutOfRange("window", window, "3 to 1000");
  if (!(least_views >= 1 && least_views <= window)) {
    return OutOfRange("least_views", least_views, "1 to the window's");
  }
  if (!(false_alarms >= 1e-9 && false_alarms <= 1.0)) {
    return OutOfRange("false_alarms", false_alarms, "1e-9 to 1");
  }
  if (!(distortion_ratio >= 1.0 && distortion_ratio <= 100.0)) {
    return OutOfRange("distortion_ratio", distortion_ratio, "1 to 100");
  }
  return {};
}

/// An error of X, or of Y, that explains the residuals of the latest views.
struct DriftCheck::Estimate {
  Vector6 error = Vector6::Zero();
  HandEyeCovariance covariance = HandEyeCovariance::Identity();  // Of it if nothing has moved.
  double statistic = 0.0;  // Chi-square of 6 degrees of freedom if nothing has moved.
  double left_over = 0.0;  // Sum of squares that it does not explain.
};

DriftCheck::DriftCheck(const DriftCheckParameters& parameters,
                       const HandEyeResult& calibration,
                       double pixel_rms)
    : parameters_(parameters), calibration_(calibration), pixel_rms_(pixel_rms) {
  constexpr double kViews = 1000.0;
  const auto windows = static_cast<double>(Windows(static_cast<size_t>(parameters.window)).size());
  // Camera and target are tested.
  threshold_ = ChiSquare6(parameters.false_alarms / (2.0 * kViews * windows));
  // As much wider as the calibration's own noise is uncertain.
  constexpr double kCertain = 12.592;
  threshold_ *= std::max(1.0, calibration.squared_radius_95 / kCertain);
}

Pose DriftCheck::ReferencePose(int reference) const {
  for (const auto& [id, pose] : references_) {
    if (id == reference) return pose;
  }
  return calibration_.T_y;
}

void DriftCheck::Add(const DriftView& view) {
  const auto is_known = [&](const auto& each) { return each.first == view.reference; };
  if (view.reference != 0 && std::ranges::none_of(references_, is_known)) {
    references_.emplace_back(view.reference,
                             EquationOfHand(calibration_.setup, view.T_base_hand) *
                                 calibration_.T_x * view.T_camera_target);
  }
  const auto same =
      std::ranges::find_if(views_.rbegin(), views_.rend(), [&view](const DriftView& each) {
        return each.reference == view.reference;
      });
  if (same != views_.rend() && SamePlace(same->T_base_hand, view.T_base_hand)) {
    views_.erase(std::prev(same.base()));
  }
  views_.push_back(view);
  if (views_.size() > static_cast<size_t>(parameters_.window)) views_.pop_front();
  std::erase_if(references_, [this](const auto& each) {
    return std::ranges::none_of(
        views_, [&](const DriftView& seen) { return seen.reference == each.first; });
  });
}

/// Least squares over the error of X and that of every reference. What does not move has the
/// calibration's covariance as its prior, a camera or target that does a wide one, other things
/// none; that of X comes on top of its estimate's, since the calibration's own error shows there if
/// nothing has moved.
DriftCheck::Estimate DriftCheck::Fit(size_t num_views, bool camera_moves, bool target_moves) const {
  std::map<int, Eigen::Index> columns;  // Of references.
  const size_t first = views_.size() - num_views;
  for (size_t i = first; i < views_.size(); ++i) columns.emplace(views_[i].reference, 0);
  Eigen::Index size = 6;
  for (auto& [reference, column] : columns) {
    column = size;
    size += 6;
  }
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(size);
  double sum = 0.0;
  AdjustmentProblem problem;
  problem.setup = calibration_.setup;
  problem.noise.robot_rotation = parameters_.noise.robot_rotation;
  problem.noise.robot_translation = parameters_.noise.robot_translation;
  const double weight = 1.0 / (parameters_.noise_scale * parameters_.noise_scale);
  for (size_t i = first; i < views_.size(); ++i) {
    const DriftView& view = views_[i];
    AdjustmentView adjusted;
    adjusted.T_base_hand = view.T_base_hand;
    adjusted.T_camera_target = view.T_camera_target;
    adjusted.camera_covariance = view.camera_covariance;
    AdjustmentState state;
    state.transforms = {calibration_.T_x, ReferencePose(view.reference)};
    const AdjustmentLinearization line = Linearize(problem, std::span(&adjusted, 1), state);
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(6, size);
    J.leftCols<6>() = line.jacobian.leftCols<6>();
    J.middleCols<6>(columns.at(view.reference)) = line.jacobian.middleCols<6>(6);
    H += weight * J.transpose() * J;
    g -= weight * J.transpose() * line.residuals;
    sum += weight * line.residuals.squaredNorm();
  }
  const HandEyeCovariance none = kNothingKnown * HandEyeCovariance::Identity();
  HandEyeCovariance knock = HandEyeCovariance::Zero();
  knock.diagonal() << Eigen::Vector3d::Constant(kKnockRotation * kKnockRotation),
      Eigen::Vector3d::Constant(kKnockTranslation * kKnockTranslation);
  const auto add_prior = [&H](Eigen::Index at, const HandEyeCovariance& covariance) {
    H.block<6, 6>(at, at) += covariance.ldlt().solve(HandEyeCovariance::Identity());
  };
  add_prior(0, camera_moves ? knock : calibration_.covariance);
  for (const auto& [reference, column] : columns) {
    const bool moves = reference == 0 && target_moves;
    add_prior(column, reference != 0 ? none : moves ? knock : calibration_.target_covariance);
  }
  const Eigen::LDLT<Eigen::MatrixXd> solver(H);
  const Eigen::VectorXd found = solver.solve(g);
  const Eigen::MatrixXd covariance = solver.solve(Eigen::MatrixXd::Identity(size, size));
  Estimate estimate;
  const bool asks_for_camera = camera_moves || !columns.contains(0);
  const Eigen::Index at = asks_for_camera ? 0 : columns.at(0);
  estimate.error = found.segment<6>(at);
  estimate.covariance =
      covariance.block<6, 6>(at, at) +
      (asks_for_camera ? calibration_.covariance : calibration_.target_covariance);
  estimate.statistic = estimate.error.dot(estimate.covariance.ldlt().solve(estimate.error));
  estimate.left_over = sum - g.dot(found);
  return estimate;
}

DriftReport DriftCheck::Report() const {
  DriftReport report;
  report.num_views = static_cast<int>(views_.size());
  if (views_.empty()) {
    report.reason = "nothing was seen yet";
    return report;
  }
  const bool sees_target =
      std::ranges::any_of(views_, [](const DriftView& view) { return view.reference == 0; });
  // Without the target a window must tell the camera's error from where the objects are.
  Estimate shown = Fit(views_.size(), true, false);
  double largest = 0.0;
  bool is_camera = true;
  for (const size_t length : Windows(views_.size())) {
    const Estimate camera = Fit(length, true, false);
    std::array<Estimate, 2> both = {camera, camera};
    if (sees_target) both[1] = Fit(length, false, true);
    const double statistic = std::max(both[0].statistic, both[1].statistic);
    if (statistic <= threshold_ || statistic <= largest) continue;
    largest = statistic;
    is_camera = !sees_target || both[0].left_over <= both[1].left_over;
    shown = is_camera ? both[0] : both[1];
    report.num_views = static_cast<int>(length);
  }
  report.rotation = shown.error.head<3>().norm();
  report.translation = shown.error.tail<3>().norm();
  report.rotation_sigma = std::sqrt(shown.covariance.topLeftCorner<3, 3>().trace());
  report.translation_sigma = std::sqrt(shown.covariance.bottomRightCorner<3, 3>().trace());

  double squares = 0.0;
  int num_images = 0;
  for (const DriftView& view : views_) {
    if (view.pixel_rms <= 0.0) continue;
    squares += view.pixel_rms * view.pixel_rms;
    ++num_images;
  }
  if (num_images > 0) report.pixel_rms = std::sqrt(squares / num_images);

  if (pixel_rms_ > 0.0 && num_images >= parameters_.least_views &&
      report.pixel_rms > parameters_.distortion_ratio * pixel_rms_) {
    report.state = DriftReport::State::kDistorted;
    report.reason = Format(
        "the target's points are %.2f px off their places in single images, %.2f px when "
        "calibrated: focus, zoom or lens have changed, or another target is seen; calibrate "
        "the intrinsics anew",
        report.pixel_rms,
        pixel_rms_);
  } else if (largest > threshold_) {
    report.state = DriftReport::State::kDrifted;
    report.reason = Format(
        "the %s has moved by about %.2f mm +- %.2f and %.3f deg +- %.3f (chi-square %.0f, "
        "limit %.0f); %s",
        is_camera ? "camera" : "target",
        1e3 * report.translation,
        1e3 * report.translation_sigma,
        report.rotation / kDegree,
        report.rotation_sigma / kDegree,
        largest,
        threshold_,
        is_camera ? "fasten it and run vantage-handeye again"
                  : "put it back, or run vantage-handeye again to have its new place");
  } else if (report.num_views >= parameters_.least_views) {
    report.state = DriftReport::State::kHolds;
    report.reason = "residuals are within what robot, camera and calibration allow";
  } else {
    report.reason = Format(
        "%d views so far, %d are needed: move the hand", report.num_views, parameters_.least_views);
  }
  return report;
}

}  // namespace vantage
