#include "perception/segmentation/support_plane.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "common/format.h"

namespace vantage {
namespace {

struct Candidate {
  Eigen::Vector3d normal;
  double offset;
};

double Cross(const Eigen::Vector2d& o, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return (a.x() - o.x()) * (b.y() - o.y()) - (a.y() - o.y()) * (b.x() - o.x());
}

// Noise that a point shows along the plane's normal.
double Sigma(const Candidate& plane, const Eigen::Vector3d& point, const DepthNoise& noise) {
  return std::max(noise.Axial(point.z()) * std::abs(plane.normal.dot(point)) / point.norm(), 5e-4);
}

std::vector<Eigen::Vector3d> Inliers(const Candidate& plane,
                                     std::span<const Eigen::Vector3d> points,
                                     const DepthNoise& noise,
                                     double sigmas) {
  std::vector<Eigen::Vector3d> inliers;
  for (const Eigen::Vector3d& point : points) {
    if (std::abs(plane.normal.dot(point) - plane.offset) <= sigmas * Sigma(plane, point, noise)) {
      inliers.push_back(point);
    }
  }
  return inliers;
}

std::optional<Candidate> BestOfRandom(std::span<const Eigen::Vector3d> points,
                                      const DepthNoise& noise,
                                      const SupportPlaneParameters& parameters,
                                      Rng& rng) {
  std::optional<Candidate> best;
  size_t best_count = 0;
  const auto size = static_cast<uint32_t>(points.size());
  for (int i = 0; i < parameters.iterations; ++i) {
    const Eigen::Vector3d& a = points[rng.Below(size)];
    const Eigen::Vector3d& b = points[rng.Below(size)];
    const Eigen::Vector3d& c = points[rng.Below(size)];
    Eigen::Vector3d normal = (b - a).cross(c - a);
    const double twice_area = normal.norm();
    if (!(twice_area > 1e-4)) continue;  // 1 cm by 1 cm: too small to tell a direction.
    normal /= twice_area;
    const double offset = normal.dot(a);
    const double tolerance = parameters.inlier_sigmas * noise.Axial(a.z());
    size_t count = 0;
    for (const Eigen::Vector3d& point : points) {
      count += std::abs(normal.dot(point) - offset) <= tolerance ? 1U : 0U;
    }
    if (count > best_count) {
      best_count = count;
      best = Candidate{normal, offset};
    }
  }
  return best;
}

// Total least squares; nothing when the points are nearly on a line.
std::optional<Candidate> LeastSquares(std::span<const Eigen::Vector3d> points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) mean += point;
  mean /= static_cast<double>(points.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& point : points) {
    scatter += (point - mean) * (point - mean).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
  if (!(solver.eigenvalues()(1) > 1e-3 * solver.eigenvalues()(2))) return std::nullopt;
  const Eigen::Vector3d normal = solver.eigenvectors().col(0);
  return Candidate{normal, normal.dot(mean)};
}

}  // namespace

Result<void> SupportPlaneParameters::Validate() const {
  if (iterations < 1 || iterations > 100000) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("iterations of the plane search = %d, expected 1 to 100000", iterations)};
  }
  if (!(inlier_sigmas > 0.0) || !(min_extent >= 0.0) || !(min_share >= 0.0 && min_share <= 1.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("support plane: inlier_sigmas = %g (expected above 0), min_extent = %g m "
                        "(expected 0 or more), min_share = %g (expected 0 to 1)",
                        inlier_sigmas,
                        min_extent,
                        min_share)};
  }
  return {};
}

bool SupportPlane::IsAboveHull(const Eigen::Vector3d& p_camera, double margin) const {
  const Eigen::Vector2d foot = Along(p_camera);
  for (size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d& a = hull[i];
    const Eigen::Vector2d& b = hull[(i + 1) % hull.size()];
    if (Cross(a, b, foot) < -margin * (b - a).norm()) return false;
  }
  return true;
}

std::optional<SupportPlane> FindSupportPlane(std::span<const Eigen::Vector3d> points,
                                             const DepthNoise& noise,
                                             const SupportPlaneParameters& parameters,
                                             Rng& rng) {
  if (points.size() < 50) return std::nullopt;
  std::optional<Candidate> candidate = BestOfRandom(points, noise, parameters, rng);
  std::vector<Eigen::Vector3d> inliers;
  for (int pass = 0; pass < 4; ++pass) {
    if (!candidate) return std::nullopt;
    inliers = Inliers(*candidate, points, noise, parameters.inlier_sigmas);
    if (inliers.size() < 20) return std::nullopt;
    if (pass < 3) candidate = LeastSquares(inliers);
  }
  if (static_cast<double>(inliers.size()) <
      parameters.min_share * static_cast<double>(points.size())) {
    return std::nullopt;
  }
  SupportPlane plane;
  const double sign = candidate->offset > 0.0 ? -1.0 : 1.0;
  plane.normal = sign * candidate->normal;
  plane.offset = sign * candidate->offset;
  plane.axis_x = plane.normal.unitOrthogonal();
  plane.axis_y = plane.normal.cross(plane.axis_x);
  std::vector<Eigen::Vector2d> feet;
  feet.reserve(inliers.size());
  for (const Eigen::Vector3d& point : inliers) feet.push_back(plane.Along(point));
  plane.hull = ConvexHull(std::move(feet));
  double extent = 0.0;
  for (const Eigen::Vector2d& a : plane.hull) {
    for (const Eigen::Vector2d& b : plane.hull) extent = std::max(extent, (a - b).norm());
  }
  if (extent < parameters.min_extent) return std::nullopt;
  return plane;
}

std::vector<Eigen::Vector2d> ConvexHull(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<Eigen::Vector2d> hull;
  const auto extend = [&hull](size_t fixed, const Eigen::Vector2d& point) {
    while (hull.size() >= fixed + 2 && Cross(hull[hull.size() - 2], hull.back(), point) <= 0.0) {
      hull.pop_back();
    }
    hull.push_back(point);
  };
  for (const Eigen::Vector2d& point : points) extend(0, point);
  const size_t lower = hull.size() - 1;
  for (size_t i = points.size() - 1; i-- > 0;) extend(lower, points[i]);
  hull.pop_back();
  return hull;
}

}  // namespace vantage
