#include "fusion/position_filter.h"

#include <algorithm>
#include <cmath>

#include "common/check.h"
#include "common/format.h"

namespace vantage {
namespace {

std::vector<size_t> HeaviestCluster(std::span<const PositionView> views, double gate) {
  std::vector<size_t> best;
  double best_weight = -1.0;
  for (const PositionView& center : views) {
    std::vector<size_t> members;
    double weight = 0.0;
    for (size_t i = 0; i < views.size(); ++i) {
      if ((views[i].p_world - center.p_world).norm() > gate) continue;
      members.push_back(i);
      weight += views[i].weight;
    }
    if (weight > best_weight) {
      best_weight = weight;
      best = std::move(members);
    }
  }
  return best;
}

Eigen::Vector3d Median(std::span<const PositionView> views, const std::vector<size_t>& members) {
  Eigen::Vector3d median;
  std::vector<double> values(members.size());
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    for (size_t i = 0; i < members.size(); ++i) values[i] = views[members[i]].p_world[axis];
    std::sort(values.begin(), values.end());
    const size_t half = values.size() / 2;
    median[axis] = values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
  }
  return median;
}

}  // namespace

Result<void> PositionFilterParameters::Validate() const {
  for (const double value : {gate, huber, sigma_floor}) {
    if (!(value > 0.0 && std::isfinite(value))) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("gate = %g m, huber = %g m, sigma_floor = %g m, expected all above 0",
                          gate,
                          huber,
                          sigma_floor)};
    }
  }
  return {};
}

PositionEstimate FusePositions(std::span<const PositionView> views,
                               const PositionFilterParameters& parameters) {
  VANTAGE_CHECK(!views.empty(), "a position needs a view");
  PositionEstimate estimate;
  estimate.inliers = HeaviestCluster(views, parameters.gate);
  estimate.p_world = Median(views, estimate.inliers);

  constexpr int kIterations = 20;
  double sum = 0.0;
  double square_sum = 0.0;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (int iteration = 0; iteration <= kIterations; ++iteration) {
    sum = 0.0;
    square_sum = 0.0;
    scatter.setZero();
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const size_t i : estimate.inliers) {
      const Eigen::Vector3d offset = views[i].p_world - estimate.p_world;
      const double weight =
          views[i].weight * std::min(1.0, parameters.huber / std::max(1e-12, offset.norm()));
      sum += weight;
      square_sum += weight * weight;
      mean += weight * views[i].p_world;
      scatter += weight * offset * offset.transpose();
    }
    if (iteration < kIterations) estimate.p_world = mean / sum;
  }
  // The mean's covariance is that of one view over the effective number of views.
  const double num_effective = sum * sum / square_sum;
  const Eigen::Matrix3d floor =
      parameters.sigma_floor * parameters.sigma_floor * Eigen::Matrix3d::Identity();
  estimate.covariance = (scatter / sum + floor) / num_effective;
  return estimate;
}

}  // namespace vantage
