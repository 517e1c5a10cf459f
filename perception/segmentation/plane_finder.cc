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
constexpr double kParallel = 10.0 * kDegree;
constexpr double kLaterShare = 0.25;   // Of the share of points that the first plane needs.
constexpr double kLargestHoles = 0.5;  // Of a later plane's cells.
constexpr int kMostRejected = 3;       // Later planes; then no other is looked for.

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
  cell.clear();
}

void PlaneFinder::Points::Add(const Points& from, size_t i) {
  u.push_back(from.u[i]);
  v.push_back(from.v[i]);
  rho.push_back(from.rho[i]);
  tolerance.push_back(from.tolerance[i]);
  cell.push_back(from.cell[i]);
}

// Row by row.
void PlaneFinder::Collect(const DepthImage& depth, double min_depth, double max_depth) {
  const int step = parameters_.grid_px > 0 ? parameters_.grid_px : std::max(1, depth.width / 80);
  cells_.Clear();
  points_.Clear();
  is_free_.clear();
  grid_width_ = (depth.width - step / 2 + step - 1) / step;
  for (int v = step / 2; v < depth.height; v += step) {
    for (int u = step / 2; u < depth.width; u += step) {
      const auto z = static_cast<double>(depth.at(u, v));
      const bool is_measured = z >= min_depth && std::isfinite(z);
      const double tolerance = parameters_.inlier_sigmas * noise_.Axial(z) / (z * z);
      cells_.u.push_back(static_cast<float>(u));
      cells_.v.push_back(static_cast<float>(v));
      cells_.rho.push_back(is_measured ? static_cast<float>(1.0 / z)
                                       : std::numeric_limits<float>::quiet_NaN());
      cells_.tolerance.push_back(is_measured ? static_cast<float>(tolerance) : 0.0F);
      cells_.cell.push_back(static_cast<uint32_t>(is_free_.size()));
      is_free_.push_back(is_measured && z <= max_depth ? 1 : 0);
      if (is_free_.back() != 0) points_.Add(cells_, is_free_.size() - 1);
    }
  }
  fewest_ = parameters_.min_share * static_cast<double>(points_.size());
}

bool PlaneFinder::BestOfRandom(Rng& rng, Eigen::Vector3d* affine) {
  few_.Clear();
  const size_t step = std::max<size_t>(1, points_.size() / kCountedPoints);
  for (size_t i = 0; i < points_.size(); i += step) {
    few_.Add(points_, i);
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

// Least squares, weighted by the noise of those points of which `is_used` is 1; false when they are
// nearly on a line.
bool PlaneFinder::Fit(const Points& points,
                      std::span<const uint8_t> is_used,
                      Eigen::Vector3d* affine) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double weights = 0.0;
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  for (int pass = 0; pass < 2; ++pass) {
    for (size_t i = 0; i < points.size(); ++i) {
      if (is_used[i] == 0) continue;
      const Eigen::Vector3d point =
          Eigen::Vector3f(points.u[i], points.v[i], points.rho[i]).cast<double>();
      const double weight = 1.0 / static_cast<double>(points.tolerance[i] * points.tolerance[i]);
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
    if (num_inliers_ < kFewestInliers || !Fit(points_, is_inlier_, affine)) return false;
    MarkInliers(*affine);
  }
  return true;
}

// The first plane consists of all of its points.
bool PlaneFinder::TakeFirst(const CameraModel& camera, const Eigen::Vector3d& affine) {
  if (static_cast<double>(num_inliers_) < fewest_) return false;
  members_.assign(is_free_.size(), 0);
  for (size_t i = 0; i < points_.size(); ++i) members_[points_.cell[i]] = is_inlier_[i];
  SupportPlane& plane = spare_.back();
  MakePlane(camera, affine, &plane);
  plane.carries = true;
  return Diameter(plane.hull) >= parameters_.min_extent;
}

void PlaneFinder::FindPatch(const Eigen::Vector3d& affine) {
  sights_.resize(is_free_.size());
  const Eigen::Vector3f plane = affine.cast<float>();
  for (size_t i = 0; i < sights_.size(); ++i) {
    const float nearer =
        cells_.rho[i] - (plane.x() * cells_.u[i] + plane.y() * cells_.v[i] + plane.z());
    if (nearer < -cells_.tolerance[i]) {
      sights_[i] = PlaneSight::kBeyond;
    } else {
      const bool is_on = is_free_[i] != 0 && nearer <= cells_.tolerance[i];
      sights_[i] = is_on ? PlaneSight::kOn : PlaneSight::kHidden;
    }
  }
  patch_.Find(sights_, grid_width_);
}

// A later plane is the largest patch of its points, and fitted to that.
bool PlaneFinder::TakeLater(const CameraModel& camera, Eigen::Vector3d affine) {
  const double fewest = kLaterShare * fewest_;
  FindPatch(affine);
  if (static_cast<double>(patch_.size()) < fewest) return false;
  if (!Fit(cells_, patch_.members(), &affine)) return false;
  FindPatch(affine);
  const auto size = static_cast<double>(patch_.size());
  if (size < fewest || static_cast<double>(patch_.num_holes()) > kLargestHoles * size) return false;
  members_.assign(patch_.members().begin(), patch_.members().end());
  SupportPlane& plane = spare_.back();
  MakePlane(camera, affine, &plane);
  return Width(plane.hull) >= parameters_.min_extent;
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
  const auto add = [&](size_t cell) {
    const auto u = static_cast<double>(cells_.u[cell]);
    const auto v = static_cast<double>(cells_.v[cell]);
    const double rho = affine.x() * u + affine.y() * v + affine.z();
    plane->hull.push_back(plane->Along(camera.Unproject(u, v, 1.0 / rho)));
  };
  const auto width = static_cast<size_t>(grid_width_);
  for (size_t row = 0; row < members_.size(); row += width) {
    size_t first = row;
    size_t last = row + width;
    while (first < last && members_[first] == 0) ++first;
    if (first == last) continue;
    while (members_[last - 1] == 0) --last;
    add(first);
    add(last - 1);
  }
  ConvexHull(&plane->hull, &hull_);
}

// Of the points those of the plane that was tried; all cells of one that was taken.
void PlaneFinder::RemoveInliers(bool is_taken) {
  for (size_t i = 0; is_taken && i < is_free_.size(); ++i) {
    if (members_[i] != 0) is_free_[i] = 0;
  }
  size_t kept = 0;
  for (size_t i = 0; i < points_.size(); ++i) {
    if (is_taken ? is_free_[points_.cell[i]] == 0 : is_inlier_[i] != 0) continue;
    for (std::vector<float>* column : {&points_.u, &points_.v, &points_.rho, &points_.tolerance}) {
      (*column)[kept] = (*column)[i];
    }
    points_.cell[kept] = points_.cell[i];
    ++kept;
  }
  for (std::vector<float>* column : {&points_.u, &points_.v, &points_.rho, &points_.tolerance}) {
    column->resize(kept);
  }
  points_.cell.resize(kept);
}

// Points on no plane that are just above this one.
size_t PlaneFinder::CountStanding(const CameraModel& camera, const SupportPlane& plane) const {
  constexpr double kLowest = 0.01;   // m
  constexpr double kHighest = 0.06;  // m
  size_t count = 0;
  for (size_t i = 0; i < is_free_.size(); ++i) {
    if (is_free_[i] == 0) continue;
    const double z = 1.0 / static_cast<double>(cells_.rho[i]);
    const Eigen::Vector3d p_camera =
        camera.Unproject(static_cast<double>(cells_.u[i]), static_cast<double>(cells_.v[i]), z);
    const double height = plane.Height(p_camera);
    const bool is_low = height > std::max(kLowest, parameters_.inlier_sigmas * noise_.Axial(z)) &&
                        height < kHighest;
    count += is_low && plane.IsAboveHull(p_camera, 0.0) ? 1U : 0U;
  }
  return count;
}

void PlaneFinder::ChooseSupport(const CameraModel& camera, std::span<SupportPlane> planes) const {
  const auto is_parallel = [](const SupportPlane& a, const SupportPlane& b) {
    return a.normal.dot(b.normal) > std::cos(kParallel);
  };
  const SupportPlane* support = &planes.front();
  const auto has_wall = std::any_of(planes.begin(), planes.end(), [&](const SupportPlane& plane) {
    return !is_parallel(plane, *support);
  });
  if (has_wall) {
    // So much more must stand on another plane than on the first.
    constexpr size_t kTimes = 2;
    constexpr size_t kPoints = 10;
    size_t least = kTimes * CountStanding(camera, planes.front()) + kPoints;
    for (const SupportPlane& plane : planes.subspan(1)) {
      const size_t count = CountStanding(camera, plane);
      if (count < least) continue;
      least = count + 1;
      support = &plane;
    }
  }
  for (SupportPlane& plane : planes) plane.carries = is_parallel(plane, *support);
}

void PlaneFinder::Find(const DepthImage& depth,
                       const CameraModel& camera,
                       double min_depth,
                       double max_depth,
                       Rng& rng,
                       std::vector<SupportPlane>* planes) {
  Collect(depth, min_depth, max_depth);
  while (!planes->empty()) {
    spare_.push_back(std::move(planes->back()));
    planes->pop_back();
  }
  for (int rejected = 0; planes->size() < static_cast<size_t>(parameters_.max_planes);) {
    if (spare_.empty()) spare_.emplace_back();
    const bool is_first = planes->empty();
    Eigen::Vector3d affine;
    const double fewest = (is_first ? 1.0 : kLaterShare) * fewest_;
    if (static_cast<double>(points_.size()) < fewest || !FindOne(rng, &affine)) break;
    const bool is_taken = is_first ? TakeFirst(camera, affine) : TakeLater(camera, affine);
    if (is_taken) {
      planes->push_back(std::move(spare_.back()));
      spare_.pop_back();
    } else if (is_first || ++rejected == kMostRejected) {
      break;
    }
    RemoveInliers(is_taken);
  }
  if (planes->size() > 1) ChooseSupport(camera, *planes);
}

}  // namespace vantage
