#include "perception/segmentation/support_plane.h"

#include <algorithm>

#include "common/format.h"

namespace vantage {
namespace {

double Cross(const Eigen::Vector2d& o, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return (a.x() - o.x()) * (b.y() - o.y()) - (a.y() - o.y()) * (b.x() - o.x());
}

}  // namespace

Result<void> SupportPlaneParameters::Validate() const {
  if (iterations < 1 || iterations > 100000 || max_planes < 1 || max_planes > 10) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("support plane: iterations = %d (expected 1 to 100000), max_planes = %d "
                        "(expected 1 to 10)",
                        iterations,
                        max_planes)};
  }
  if (!(inlier_sigmas > 0.0) || !(min_extent >= 0.0) || !(min_share >= 0.0 && min_share <= 1.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("support plane: inlier_sigmas = %g (expected above 0), min_extent = %g m "
                        "(expected 0 or more), min_share = %g (expected 0 to 1)",
                        inlier_sigmas,
                        min_extent,
                        min_share)};
  }
  if (grid_px < 0) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("support plane: grid_px = %d, expected 0 or more", grid_px)};
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

void ConvexHull(std::vector<Eigen::Vector2d>* points, std::vector<Eigen::Vector2d>* hull) {
  std::sort(points->begin(), points->end(), [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  points->erase(std::unique(points->begin(), points->end()), points->end());
  if (points->size() < 3) return;
  hull->clear();
  const auto extend = [hull](size_t fixed, const Eigen::Vector2d& point) {
    while (hull->size() >= fixed + 2 &&
           Cross((*hull)[hull->size() - 2], hull->back(), point) <= 0.0) {
      hull->pop_back();
    }
    hull->push_back(point);
  };
  for (const Eigen::Vector2d& point : *points) extend(0, point);
  const size_t lower = hull->size() - 1;
  for (size_t i = points->size() - 1; i-- > 0;) extend(lower, (*points)[i]);
  hull->pop_back();
  points->assign(hull->begin(), hull->end());
}

}  // namespace vantage
