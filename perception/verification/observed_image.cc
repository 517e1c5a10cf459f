#include "perception/verification/observed_image.h"

#include <algorithm>
#include <limits>

#include "common/check.h"
#include "common/simd.h"

namespace vantage {
namespace {

constexpr size_t kPadding = 8;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

bool IsMeasured(float depth) { return depth > 0.0F && depth < kInfinity; }

// Widens the ranges of depth by a row of an image.
VANTAGE_SIMD void WidenByRow(const float* depth, size_t count, float* low, float* high) {
  for (size_t i = 0; i < count; ++i) {
    const float z = depth[i];
    const bool is_measured = (z > 0.0F) & (z < kInfinity);
    const float as_low = is_measured ? z : kInfinity;
    const float as_high = is_measured ? z : -kInfinity;
    low[i] = as_low < low[i] ? as_low : low[i];
    high[i] = as_high > high[i] ? as_high : high[i];
  }
}

// Of every place the least and the greatest of `reach` values to either side. The inputs start
// `reach` values before the first place.
VANTAGE_SIMD void RangeAlongRow(
    const float* low, const float* high, size_t count, int reach, float* least, float* greatest) {
  std::fill(least, least + count, kInfinity);
  std::fill(greatest, greatest + count, -kInfinity);
  for (int k = 0; k <= 2 * reach; ++k) {
    for (size_t i = 0; i < count; ++i) {
      least[i] =
          low[i + static_cast<size_t>(k)] < least[i] ? low[i + static_cast<size_t>(k)] : least[i];
    }
    for (size_t i = 0; i < count; ++i) {
      greatest[i] = high[i + static_cast<size_t>(k)] > greatest[i]
                        ? high[i + static_cast<size_t>(k)]
                        : greatest[i];
    }
  }
}

PixelWindow Joined(const PixelWindow& a, const PixelWindow& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return {std::min(a.u0, b.u0), std::min(a.v0, b.v0), std::max(a.u1, b.u1), std::max(a.v1, b.v1)};
}

PixelWindow CutTo(const PixelWindow& window, int width, int height) {
  return {std::max(window.u0, 0),
          std::max(window.v0, 0),
          std::min(window.u1, width - 1),
          std::min(window.v1, height - 1)};
}

bool Holds(const PixelWindow& outer, const PixelWindow& inner) {
  return inner.u0 >= outer.u0 && inner.v0 >= outer.v0 && inner.u1 <= outer.u1 &&
         inner.v1 <= outer.v1;
}

}  // namespace

void ObservedImage::Reset(const SegmentedImage& image, int edge_px) {
  const size_t size =
      static_cast<size_t>(image.camera.width) * static_cast<size_t>(image.camera.height);
  VANTAGE_CHECK(image.depth.depth.size() == size && image.segmentation.labels.size() == size,
                "depth and labels of the camera's size");
  image_.emplace(image);
  edge_px_ = edge_px;
  for (Level& level : levels_) level.width = 0;
}

ObservedImage::Level& ObservedImage::Find(int step) {
  VANTAGE_CHECK(image_ && step >= 1, "an image and a step");
  auto found = std::find_if(
      levels_.begin(), levels_.end(), [step](const Level& level) { return level.step == step; });
  if (found != levels_.end() && found->width > 0) return *found;
  Level& level = found != levels_.end() ? *found : levels_.emplace_back();
  level.step = step;
  level.width = (image_->camera.width - 1) / step + 1;
  level.height = (image_->camera.height - 1) / step + 1;
  level.stride = static_cast<size_t>(level.width) + kPadding;
  const size_t size = level.stride * static_cast<size_t>(level.height);
  level.depth.resize(size);
  level.nearest.resize(size);
  level.farthest.resize(size);
  level.labels.resize(size);
  level.prepared = PixelWindow{};
  level.cluster_size.assign(image_->segmentation.clusters.size(), -1);
  return level;
}

const ObservedImage::Level& ObservedImage::Prepare(int step, const PixelWindow& window) {
  Level& level = Find(step);
  const PixelWindow asked = CutTo(window, level.width, level.height);
  if (asked.empty() || (!level.prepared.empty() && Holds(level.prepared, asked))) return level;
  constexpr int kAheadPx = 16;  // Of the image: hypotheses lie about the same place.
  const int ahead = (kAheadPx + step - 1) / step;
  const PixelWindow before = level.prepared;
  const PixelWindow after = CutTo(
      Joined(before, {asked.u0 - ahead, asked.v0 - ahead, asked.u1 + ahead, asked.v1 + ahead}),
      level.width,
      level.height);
  level.prepared = after;
  if (before.empty()) {
    Fill(after, &level);
  } else {
    Fill({after.u0, after.v0, after.u1, before.v0 - 1}, &level);
    Fill({after.u0, before.v0, before.u0 - 1, before.v1}, &level);
    Fill({before.u1 + 1, before.v0, after.u1, before.v1}, &level);
    Fill({after.u0, before.v1 + 1, after.u1, after.v1}, &level);
  }
  return level;
}

void ObservedImage::Fill(const PixelWindow& window, Level* level) {
  if (window.empty()) return;
  const DepthImage& depth = image_->depth;
  const std::vector<int32_t>& labels = image_->segmentation.labels;
  for (int j = window.v0; j <= window.v1; ++j) {
    size_t from = depth.Index(window.u0 * level->step, j * level->step);
    const size_t first = level->Index(window.u0, j);
    const size_t last = level->Index(window.u1, j);
    for (size_t i = first; i <= last; ++i, from += static_cast<size_t>(level->step)) {
      const float z = depth.depth[from];
      level->depth[i] = IsMeasured(z) ? z : 0.0F;
      level->labels[i] = labels[from];
    }
    FillRange(window.u0, window.u1, j, level);
  }
}

// `nearest` and `farthest` of the pixels `first` to `last` of a row.
void ObservedImage::FillRange(int first, int last, int row, Level* level) {
  const DepthImage& depth = image_->depth;
  const int u0 = first * level->step - edge_px_;
  const int u1 = last * level->step + edge_px_;
  const auto columns = static_cast<size_t>(u1 - u0 + 1);
  low_.assign(columns, kInfinity);
  high_.assign(columns, -kInfinity);
  const int from = std::max(u0, 0);
  const int to = std::min(u1, depth.width - 1);
  const int v = row * level->step;
  for (int dv = -edge_px_; dv <= edge_px_; ++dv) {
    if (v + dv < 0 || v + dv >= depth.height) continue;
    WidenByRow(&depth.depth[depth.Index(from, v + dv)],
               static_cast<size_t>(to - from + 1),
               &low_[static_cast<size_t>(from - u0)],
               &high_[static_cast<size_t>(from - u0)]);
  }
  const auto count = static_cast<size_t>(last - first) * static_cast<size_t>(level->step) + 1;
  float* nearest = &level->nearest[level->Index(first, row)];
  float* farthest = &level->farthest[level->Index(first, row)];
  if (level->step == 1) {
    RangeAlongRow(low_.data(), high_.data(), count, edge_px_, nearest, farthest);
    return;
  }
  least_.resize(count);
  greatest_.resize(count);
  RangeAlongRow(low_.data(), high_.data(), count, edge_px_, least_.data(), greatest_.data());
  for (size_t i = 0; i < count; i += static_cast<size_t>(level->step)) {
    *nearest++ = least_[i];
    *farthest++ = greatest_[i];
  }
}

int ObservedImage::ClusterSize(int step, size_t cluster) {
  Level& level = Find(step);
  int& size = level.cluster_size[cluster];
  if (size >= 0) return size;
  size = 0;
  const Cluster& own = image_->segmentation.clusters[cluster];
  const auto first = [step](int pixel) { return (pixel + step - 1) / step * step; };
  for (int v = first(own.window.v0); v <= own.window.v1; v += step) {
    for (int u = first(own.window.u0); u <= own.window.u1; u += step) {
      size += own.Holds(image_->segmentation.labels[image_->depth.Index(u, v)]) ? 1 : 0;
    }
  }
  return size;
}

}  // namespace vantage
