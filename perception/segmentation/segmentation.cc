#include "perception/segmentation/segmentation.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "common/check.h"
#include "common/format.h"

namespace vantage {
namespace {

bool IsUsable(float z, const SegmentationParameters& parameters) {
  return z >= static_cast<float>(parameters.min_depth) &&
         z <= static_cast<float>(parameters.max_depth);
}

// Points of a coarse grid of pixels, for the plane.
std::vector<Eigen::Vector3d> SparsePoints(const DepthImage& depth,
                                          const CameraModel& camera,
                                          const SegmentationParameters& parameters) {
  const int step = std::max(1, depth.width / 80);
  std::vector<Eigen::Vector3d> points;
  for (int v = step / 2; v < depth.height; v += step) {
    for (int u = step / 2; u < depth.width; u += step) {
      const float z = depth.at(u, v);
      if (IsUsable(z, parameters)) points.push_back(camera.Unproject(u, v, static_cast<double>(z)));
    }
  }
  return points;
}

// 1 where a pixel may belong to an object.
std::vector<uint8_t> ForegroundMask(const DepthImage& depth,
                                    const CameraModel& camera,
                                    const std::optional<SupportPlane>& plane,
                                    const SegmentationParameters& parameters) {
  std::vector<uint8_t> mask(depth.depth.size(), 0);
  for (int v = 0; v < depth.height; ++v) {
    for (int u = 0; u < depth.width; ++u) {
      const size_t pixel = depth.Index(u, v);
      const float z = depth.depth[pixel];
      if (!IsUsable(z, parameters)) continue;
      if (!plane) {
        mask[pixel] = 1;
        continue;
      }
      const Eigen::Vector3d point = camera.Unproject(u, v, static_cast<double>(z));
      const double height = plane->Height(point);
      if (height < parameters.min_height || height > parameters.max_height) continue;
      const double cosine = std::abs(plane->normal.dot(point)) / point.norm();
      if (height < 3.0 * parameters.noise.Axial(point.z()) * cosine) continue;
      if (plane->IsAboveHull(point, parameters.hull_margin)) mask[pixel] = 1;
    }
  }
  return mask;
}

// Union-find over pixels, by path halving; the smaller index is the root.
class DisjointSets {
 public:
  explicit DisjointSets(size_t size) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), 0U);
  }
  uint32_t Find(uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void Join(uint32_t a, uint32_t b) {
    a = Find(a);
    b = Find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<uint32_t> parent_;
};

struct Offset {
  int du;
  int dv;
  double distance;
};

// The half of the neighborhood of radius gap_px + 1 that precedes a pixel in row order.
std::vector<Offset> PrecedingNeighbors(int gap_px) {
  std::vector<Offset> offsets;
  for (int dv = -gap_px - 1; dv <= 0; ++dv) {
    for (int du = -gap_px - 1; du <= gap_px + 1; ++du) {
      if (dv == 0 && du >= 0) break;
      if (std::max(std::abs(du), -dv) > 1 && du != 0 && dv != 0) continue;  // Far: rows, columns.
      offsets.push_back({du, dv, std::hypot(du, dv)});
    }
  }
  return offsets;
}

DisjointSets Connect(const DepthImage& depth,
                     const CameraModel& camera,
                     const std::vector<uint8_t>& mask,
                     const SegmentationParameters& parameters) {
  DisjointSets sets(mask.size());
  const std::vector<Offset> offsets = PrecedingNeighbors(parameters.gap_px);
  const double spacing = 2.0 / std::min(camera.fx, camera.fy);
  for (int v = 0; v < depth.height; ++v) {
    for (int u = 0; u < depth.width; ++u) {
      const size_t pixel = depth.Index(u, v);
      if (mask[pixel] == 0) continue;
      const auto z = static_cast<double>(depth.depth[pixel]);
      for (const Offset& offset : offsets) {
        if (!depth.Contains(u + offset.du, v + offset.dv)) continue;
        const size_t neighbor = depth.Index(u + offset.du, v + offset.dv);
        if (mask[neighbor] == 0) continue;
        const double gap = std::abs(z - static_cast<double>(depth.depth[neighbor]));
        if (gap > parameters.largest_gap + spacing * z * offset.distance) continue;
        sets.Join(static_cast<uint32_t>(pixel), static_cast<uint32_t>(neighbor));
      }
    }
  }
  return sets;
}

void Extend(int u, int v, PixelWindow* window) {
  if (window->empty()) {
    *window = {u, v, u, v};
    return;
  }
  window->u0 = std::min(window->u0, u);
  window->v0 = std::min(window->v0, v);
  window->u1 = std::max(window->u1, u);
  window->v1 = std::max(window->v1, v);
}

}  // namespace

Result<void> SegmentationParameters::Validate() const {
  if (Result<void> valid = plane.Validate(); !valid) return valid;
  if (!(min_depth > 0.0 && max_depth > min_depth)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("segmentation: depth from %g to %g m, expected 0 < min_depth < max_depth",
                        min_depth,
                        max_depth)};
  }
  if (!(min_height >= 0.0 && max_height > min_height)) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("segmentation: height from %g to %g m, expected 0 <= min_height < max_height",
               min_height,
               max_height)};
  }
  if (!(largest_gap > 0.0) || gap_px < 0 || gap_px > 20 || min_points < 1) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("segmentation: largest_gap = %g m (expected above 0), gap_px = %d (expected "
               "0 to 20), min_points = %d (expected 1 or more)",
               largest_gap,
               gap_px,
               min_points)};
  }
  return {};
}

Segmentation Segment(const DepthImage& depth,
                     const CameraModel& camera,
                     const SegmentationParameters& parameters,
                     Rng& rng) {
  VANTAGE_CHECK(depth.width == camera.width && depth.height == camera.height,
                "depth image and camera differ in size");
  Segmentation result;
  std::optional<SupportPlane> plane;
  if (parameters.support == SegmentationParameters::Support::kAuto) {
    plane = FindSupportPlane(
        SparsePoints(depth, camera, parameters), parameters.noise, parameters.plane, rng);
  }
  if (plane) result.planes.push_back(*plane);
  const std::vector<uint8_t> mask = ForegroundMask(depth, camera, plane, parameters);
  DisjointSets sets = Connect(depth, camera, mask, parameters);

  std::vector<uint32_t> sizes(mask.size(), 0);
  for (uint32_t i = 0; i < mask.size(); ++i) {
    if (mask[i] != 0) ++sizes[sets.Find(i)];
  }
  std::vector<uint32_t> roots;
  for (uint32_t i = 0; i < mask.size(); ++i) {
    if (sizes[i] >= static_cast<uint32_t>(parameters.min_points)) roots.push_back(i);
  }
  std::stable_sort(
      roots.begin(), roots.end(), [&](uint32_t a, uint32_t b) { return sizes[a] > sizes[b]; });

  result.labels.assign(mask.size(), Segmentation::kNoCluster);
  result.clusters.resize(roots.size());
  for (size_t i = 0; i < roots.size(); ++i) {
    result.labels[roots[i]] = static_cast<int32_t>(i);
    result.clusters[i].pixels.reserve(sizes[roots[i]]);
    result.clusters[i].first_label = result.clusters[i].last_label = static_cast<int32_t>(i);
  }
  // A root is the smallest index of its set, so its label is there before it is asked for.
  for (uint32_t i = 0; i < mask.size(); ++i) {
    if (mask[i] == 0) continue;
    const int32_t label = result.labels[sets.Find(i)];
    result.labels[i] = label;
    if (label == Segmentation::kNoCluster) continue;
    Cluster& cluster = result.clusters[static_cast<size_t>(label)];
    cluster.pixels.push_back(i);
    const int u = static_cast<int>(i) % depth.width;
    const int v = static_cast<int>(i) / depth.width;
    Extend(u, v, &cluster.window);
    cluster.touches_border =
        cluster.touches_border || u == 0 || v == 0 || u == depth.width - 1 || v == depth.height - 1;
  }
  return result;
}

const Segmentation& Segmenter::Segment(const DepthImage& depth,
                                       const CameraModel& camera,
                                       Rng& rng) {
  result_ = vantage::Segment(depth, camera, parameters_, rng);
  return result_;
}

}  // namespace vantage
