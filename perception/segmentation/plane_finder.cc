#include "perception/segmentation/plane_finder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "common/simd.h"
#include "common/so3.h"

namespace vantage {
namespace {

constexpr size_t kFewestPoints = 50;
constexpr size_t kFewestInliers = 20;
constexpr size_t kCountedPoints = 1000;

struct Hypothesis {
  float a;  // 1/m of inverse depth a pixel
  float b;
  float c;
};

VANTAGE_SIMD int32_t CountInliers(const Hypothesis& plane,
                                  const float* u,
                                  const float* v,
                                  const float* rho,
                                  const float* tolerance,
                                  size_t size) {
  int32_t count = 0;
  for (size_t i = 0; i < size; ++i) {
    const float error = plane.a * u[i] + plane.b * v[i] + plane.c - rho[i];
    count += std::abs(error) <= tolerance[i] ? 1 : 0;
  }
  return count;
}

// Smallest distance between two parallel lines that hold a convex polygon.
double Width(const std::vector<Eigen::Vector2d>& hull) {
  double width = hull.size() < 3 ? 0.0 : std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d side = (hull[(i + 1) % hull.size()] - hull[i]).normalized();
    double farthest = 0.0;
    for (const Eigen::Vector2d& corner : hull) {
      const Eigen::Vector2d along = corner - hull[i];
      farthest = std::max(farthest, side.x() * along.y() - side.y() * along.x());
    }
    width = std::min(width, farthest);
  }
  return width;
}

double Diameter(const std::vector<Eigen::Vector2d>& hull) {
  double diameter = 0.0;
  for (const Eigen::Vector2d& a : hull) {
    for (const Eigen::Vector2d& b : hull) diameter = std::max(diameter, (a - b).norm());
  }
  return diameter;
}

}  // namespace

void PlaneFinder::Points::Clear() {
  for (std::vector<float>* column : {&u, &v, &rho, &tolerance}) column->clear();
}

void PlaneFinder::Points::Add(float at_u, float at_v, float at_rho, float at_tolerance) {
  u.push_back(at_u);
  v.push_back(at_v);
  rho.push_back(at_rho);
  tolerance.push_back(at_tolerance);
}

// Row by row.
void PlaneFinder::Collect(const DepthImage& depth, double min_depth, double max_depth) {
  const int step = std::max(1, depth.width / 80);
  points_.Clear();
  for (int v = step / 2; v < depth.height; v += step) {
    for (int u = step / 2; u < depth.width; u += step) {
      const auto z = static_cast<double>(depth.at(u, v));
      if (!(z >= min_depth && z <= max_depth)) continue;
      const double tolerance = parameters_.inlier_sigmas * noise_.Axial(z) / (z * z);
      points_.Add(static_cast<float>(u),
                  static_cast<float>(v),
                  static_cast<float>(1.0 / z),
                  static_cast<float>(tolerance));
    }
  }
}

bool PlaneFinder::BestOfRandom(Rng& rng, Eigen::Vector3d* affine) {
  few_.Clear();
  const size_t step = std::max<size_t>(1, points_.size() / kCountedPoints);
  for (size_t i = 0; i < points_.size(); i += step) {
    few_.Add(points_.u[i], points_.v[i], points_.rho[i], points_.tolerance[i]);
  }
  const auto size = static_cast<uint32_t>(few_.size());
  int32_t best = 0;
  double needed = parameters_.iterations;
  for (int i = 0; i < std::min<double>(needed, parameters_.iterations); ++i) {
    std::array<uint32_t, 3> chosen{};
    for (uint32_t& index : chosen) index = rng.Below(size);
    const auto [p, q, r] = chosen;
    const double qu = static_cast<double>(few_.u[q] - few_.u[p]);
    const double qv = static_cast<double>(few_.v[q] - few_.v[p]);
    const double ru = static_cast<double>(few_.u[r] - few_.u[p]);
    const double rv = static_cast<double>(few_.v[r] - few_.v[p]);
    const double twice_area = qu * rv - qv * ru;
    if (!(std::abs(twice_area) > 100.0)) continue;  // px^2: too small to tell a direction.
    const double q_rho = static_cast<double>(few_.rho[q] - few_.rho[p]);
    const double r_rho = static_cast<double>(few_.rho[r] - few_.rho[p]);
    const double a = (q_rho * rv - r_rho * qv) / twice_area;
    const double b = (r_rho * qu - q_rho * ru) / twice_area;
    const double c = static_cast<double>(few_.rho[p]) - a * static_cast<double>(few_.u[p]) -
                     b * static_cast<double>(few_.v[p]);
    const Hypothesis plane{static_cast<float>(a), static_cast<float>(b), static_cast<float>(c)};
    const int32_t count = CountInliers(
        plane, few_.u.data(), few_.v.data(), few_.rho.data(), few_.tolerance.data(), size);
    if (count <= best) continue;
    best = count;
    *affine = {a, b, c};
    // So many draws hit three points of this plane but once in 10,000 times (Fischler, Bolles).
    const double share = static_cast<double>(count) / size;
    needed = std::log(1e-4) / std::log(std::max(1.0 - share * share * share, 1e-9));
  }
  return best > 0;
}

void PlaneFinder::MarkInliers(const Eigen::Vector3d& affine) {
  is_inlier_.resize(points_.size());
  num_inliers_ = 0;
  const Eigen::Vector3f plane = affine.cast<float>();
  for (size_t i = 0; i < points_.size(); ++i) {
    const float error =
        plane.x() * points_.u[i] + plane.y() * points_.v[i] + plane.z() - points_.rho[i];
    is_inlier_[i] = std::abs(error) <= points_.tolerance[i] ? 1 : 0;
    num_inliers_ += is_inlier_[i];
  }
}

// Least squares, weighted by the points' noise; false when they are nearly on a line.
bool PlaneFinder::FitToInliers(Eigen::Vector3d* affine) const {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double weights = 0.0;
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  for (int pass = 0; pass < 2; ++pass) {
    for (size_t i = 0; i < points_.size(); ++i) {
      if (is_inlier_[i] == 0) continue;
      const Eigen::Vector3d point =
          Eigen::Vector3f(points_.u[i], points_.v[i], points_.rho[i]).cast<double>();
      const double weight = 1.0 / static_cast<double>(points_.tolerance[i] * points_.tolerance[i]);
      if (pass == 0) {
        mean += weight * point;
        weights += weight;
      } else {
        moments += weight * (point - mean) * (point - mean).transpose();
      }
    }
    if (pass == 0) mean /= weights;
  }
  const double determinant = moments(0, 0) * moments(1, 1) - moments(0, 1) * moments(1, 0);
  const double trace = moments(0, 0) + moments(1, 1);
  if (!(determinant > 1e-4 * trace * trace)) return false;
  const double a = (moments(0, 2) * moments(1, 1) - moments(1, 2) * moments(0, 1)) / determinant;
  const double b = (moments(1, 2) * moments(0, 0) - moments(0, 2) * moments(0, 1)) / determinant;
  *affine = {a, b, mean.z() - a * mean.x() - b * mean.y()};
  return true;
}

// The plane of most points; they are marked.
bool PlaneFinder::FindOne(Rng& rng, Eigen::Vector3d* affine) {
  if (points_.size() < kFewestPoints || !BestOfRandom(rng, affine)) return false;
  MarkInliers(*affine);
  for (int pass = 0; pass < 3; ++pass) {
    if (num_inliers_ < kFewestInliers || !FitToInliers(affine)) return false;
    MarkInliers(*affine);
  }
  return static_cast<double>(num_inliers_) >=
         parameters_.min_share * static_cast<double>(points_.size());
}

void PlaneFinder::MakePlane(const CameraModel& camera,
                            const Eigen::Vector3d& affine,
                            SupportPlane* plane) {
  // rho = m . ray, and 1 = m . p on the plane.
  const Eigen::Vector3d m(affine.x() * camera.fx,
                          affine.y() * camera.fy,
                          affine.z() + affine.x() * camera.cx + affine.y() * camera.cy);
  plane->normal = -m.normalized();
  plane->offset = -1.0 / m.norm();
  plane->axis_x = plane->normal.unitOrthogonal();
  plane->axis_y = plane->normal.cross(plane->axis_x);
  // A hull's corners are ends of rows: a view of a plane keeps what is convex.
  plane->hull.clear();
  const auto add = [&](size_t i) {
    const auto u = static_cast<double>(points_.u[i]);
    const auto v = static_cast<double>(points_.v[i]);
    const double rho = affine.x() * u + affine.y() * v + affine.z();
    plane->hull.push_back(plane->Along(camera.Unproject(u, v, 1.0 / rho)));
  };
  size_t last = points_.size();
  for (size_t i = 0; i < points_.size(); ++i) {
    if (is_inlier_[i] == 0) continue;
    const bool is_first = last == points_.size() || points_.v[last] != points_.v[i];
    if (is_first && last != points_.size()) add(last);
    if (is_first) add(i);
    last = i;
  }
  if (last != points_.size()) add(last);
  ConvexHull(&plane->hull, &hull_);
}

void PlaneFinder::RemoveInliers() {
  size_t kept = 0;
  for (size_t i = 0; i < points_.size(); ++i) {
    if (is_inlier_[i] != 0) continue;
    for (std::vector<float>* column : {&points_.u, &points_.v, &points_.rho, &points_.tolerance}) {
      (*column)[kept] = (*column)[i];
    }
    ++kept;
  }
  for (std::vector<float>* column : {&points_.u, &points_.v, &points_.rho, &points_.tolerance}) {
    column->resize(kept);
  }
}

void PlaneFinder::Find(const DepthImage& depth,
                       const CameraModel& camera,
                       double min_depth,
                       double max_depth,
                       Rng& rng,
                       std::vector<SupportPlane>* planes) {
  constexpr double kParallel = 10.0 * kDegree;
  Collect(depth, min_depth, max_depth);
  while (!planes->empty()) {
    spare_.push_back(std::move(planes->back()));
    planes->pop_back();
  }
  Eigen::Vector3d affine;
  while (planes->size() < static_cast<size_t>(parameters_.max_planes) && FindOne(rng, &affine)) {
    if (spare_.empty()) spare_.emplace_back();
    SupportPlane& plane = spare_.back();
    MakePlane(camera, affine, &plane);
    const double extent = planes->empty() ? Diameter(plane.hull) : Width(plane.hull);
    if (extent < parameters_.min_extent) break;
    plane.carries =
        planes->empty() || plane.normal.dot(planes->front().normal) > std::cos(kParallel);
    planes->push_back(std::move(plane));
    spare_.pop_back();
    RemoveInliers();
  }
}

}  // namespace vantage
