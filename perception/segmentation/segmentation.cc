#include "perception/segmentation/segmentation.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>

#include "common/check.h"

namespace vantage {
namespace {

void Extend(const PixelWindow& pixels, PixelWindow* window) {
  if (window->empty()) {
    *window = pixels;
    return;
  }
  window->u0 = std::min(window->u0, pixels.u0);
  window->v0 = std::min(window->v0, pixels.v0);
  window->u1 = std::max(window->u1, pixels.u1);
  window->v1 = std::max(window->v1, pixels.v1);
}

}  // namespace

Segmenter::Segmenter(const SegmentationParameters& parameters)
    : parameters_(parameters),
      planes_(parameters.plane, parameters.noise),
      foreground_(parameters),
      splitter_(parameters) {}

// A cluster without pixels at the end of those that are there, with a buffer that was used before.
Cluster& Segmenter::AddCluster() {
  if (spare_.empty()) spare_.emplace_back();
  result_.clusters.push_back(std::move(spare_.back()));
  spare_.pop_back();
  Cluster& cluster = result_.clusters.back();
  std::vector<uint32_t> pixels = std::move(cluster.pixels);
  pixels.clear();
  cluster = Cluster{};
  cluster.pixels = std::move(pixels);
  return cluster;
}

// Runs of one cluster after another, those of a cluster in their order.
void Segmenter::SortRuns(int num_clusters) {
  run_begin_.assign(static_cast<size_t>(num_clusters) + 1, 0);
  for (const PixelRun& run : runs_.runs()) {
    if (run.cluster >= 0) ++run_begin_[static_cast<size_t>(run.cluster) + 1];
  }
  std::partial_sum(run_begin_.begin(), run_begin_.end(), run_begin_.begin());
  sorted_runs_.resize(run_begin_.back());
  for (const PixelRun& run : runs_.runs()) {
    if (run.cluster >= 0) sorted_runs_[run_begin_[static_cast<size_t>(run.cluster)]++] = run;
  }
  std::rotate(run_begin_.begin(), run_begin_.end() - 1, run_begin_.end());
  run_begin_.front() = 0;
}

void Segmenter::AddWhole(std::span<const PixelRun> runs, int width) {
  Cluster& cluster = AddCluster();
  for (const PixelRun& run : runs) {
    Extend({run.u0, run.v, run.u1, run.v}, &cluster.window);
    const size_t size = cluster.pixels.size();
    cluster.pixels.resize(size + static_cast<size_t>(run.size()));
    std::iota(cluster.pixels.begin() + static_cast<std::ptrdiff_t>(size),
              cluster.pixels.end(),
              static_cast<uint32_t>(run.v * width + run.u0));
  }
}

// The parts of the last cluster, behind it.
void Segmenter::AddParts(int count, int width) {
  const size_t whole = result_.clusters.size() - 1;
  const std::span<const int32_t> part_of = splitter_.parts();
  part_size_.assign(static_cast<size_t>(count), 0);
  part_order_.clear();  // By first pixel.
  for (const int32_t part : part_of) {
    if (part_size_[static_cast<size_t>(part)]++ == 0) part_order_.push_back(part);
  }
  const auto is_larger = [this](int32_t a, int32_t b) {
    return part_size_[static_cast<size_t>(a)] > part_size_[static_cast<size_t>(b)];
  };
  // Stable, and without the buffer that std::stable_sort takes.
  for (auto next = part_order_.begin(); next != part_order_.end(); ++next) {
    std::rotate(std::upper_bound(part_order_.begin(), next, *next, is_larger), next, next + 1);
  }
  for (size_t i = 0; i < part_order_.size(); ++i) {
    part_size_[static_cast<size_t>(part_order_[i])] = static_cast<int32_t>(i);
    Cluster& part = AddCluster();
    part.parent = static_cast<int>(whole);
  }
  const std::vector<uint32_t>& pixels = result_.clusters[whole].pixels;
  for (size_t i = 0; i < pixels.size(); ++i) {
    const int32_t place = part_size_[static_cast<size_t>(part_of[i])];
    Cluster& part = result_.clusters[whole + 1 + static_cast<size_t>(place)];
    const int u = static_cast<int>(pixels[i]) % width;
    const int v = static_cast<int>(pixels[i]) / width;
    Extend({u, v, u, v}, &part.window);
    part.pixels.push_back(pixels[i]);
  }
}

// Each smallest segment gets one label; a cluster of parts has the labels of its parts.
void Segmenter::SetLabels(size_t num_pixels) {
  result_.labels.assign(num_pixels, Segmentation::kNoCluster);
  int32_t label = 0;
  std::vector<Cluster>& clusters = result_.clusters;
  for (size_t i = 0; i < clusters.size(); ++i) {
    clusters[i].first_label = clusters[i].last_label = label;
    const bool has_parts = i + 1 < clusters.size() && clusters[i + 1].parent == static_cast<int>(i);
    if (has_parts) continue;
    for (const uint32_t pixel : clusters[i].pixels) result_.labels[pixel] = label;
    if (clusters[i].parent >= 0) {
      clusters[static_cast<size_t>(clusters[i].parent)].last_label = label;
    }
    ++label;
  }
}

const Segmentation& Segmenter::Segment(const DepthImage& depth,
                                       const CameraModel& camera,
                                       Rng& rng) {
  VANTAGE_CHECK(camera.Validate().ok(), "the camera is not valid");
  VANTAGE_CHECK(depth.width == camera.width && depth.height == camera.height,
                "depth image and camera differ in size");
  if (parameters_.support == SegmentationParameters::Support::kAuto) {
    planes_.Find(depth, camera, parameters_.min_depth, parameters_.max_depth, rng, &result_.planes);
  }
  const std::span<const uint8_t> mask = foreground_.Find(depth, camera, result_.planes);
  const Connection connection{static_cast<float>(parameters_.largest_gap),
                              static_cast<float>(2.0 / std::min(camera.fx, camera.fy)),
                              parameters_.gap_px};
  const int num_clusters = runs_.Connect(depth, mask, connection, parameters_.min_points);
  SortRuns(num_clusters);
  while (!result_.clusters.empty()) {
    spare_.push_back(std::move(result_.clusters.back()));
    result_.clusters.pop_back();
  }
  for (size_t i = 0; i < static_cast<size_t>(num_clusters); ++i) {
    AddWhole(std::span(sorted_runs_).subspan(run_begin_[i], run_begin_[i + 1] - run_begin_[i]),
             depth.width);
    const Cluster& whole = result_.clusters.back();
    if (whole.pixels.size() < 2 * static_cast<size_t>(parameters_.min_points)) continue;
    const int parts = splitter_.Split(depth, camera, whole.pixels, whole.window);
    if (parts > 1) AddParts(parts, depth.width);
  }
  SetLabels(depth.depth.size());
  border_.Mark(depth, result_.clusters);
  return result_;
}

Segmentation Segment(const DepthImage& depth,
                     const CameraModel& camera,
                     const SegmentationParameters& parameters,
                     Rng& rng) {
  return Segmenter(parameters).Segment(depth, camera, rng);
}

}  // namespace vantage
