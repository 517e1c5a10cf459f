#include "perception/segmentation/border_marker.h"

#include <algorithm>
#include <limits>

namespace vantage {
namespace {

bool IsMeasured(float z) { return z > 0.0F && z < std::numeric_limits<float>::infinity(); }

}  // namespace

void BorderMarker::FindFirst(const DepthImage& depth) {
  const int w = depth.width;
  const int h = depth.height;
  left_.assign(static_cast<size_t>(h), kFar);
  right_.assign(static_cast<size_t>(h), kFar);
  top_.assign(static_cast<size_t>(w), kFar);
  bottom_.assign(static_cast<size_t>(w), kFar);
  const auto keep_first = [](int distance, bool is_measured, int* first) {
    if (is_measured) *first = std::min(*first, distance);
  };
  for (int v = 0; v < h; ++v) {
    const auto row = static_cast<size_t>(v);
    for (int i = 0; i < std::min(w, left_[row]); ++i) {
      keep_first(i, IsMeasured(depth.at(i, v)), &left_[row]);
    }
    for (int i = 0; i < std::min(w, right_[row]); ++i) {
      keep_first(i, IsMeasured(depth.at(w - 1 - i, v)), &right_[row]);
    }
  }
  for (int i = 0; i < std::min(h, kFar); ++i) {
    for (int u = 0; u < w; ++u) {
      const auto column = static_cast<size_t>(u);
      keep_first(i, IsMeasured(depth.at(u, i)), &top_[column]);
      keep_first(i, IsMeasured(depth.at(u, h - 1 - i)), &bottom_[column]);
    }
  }
}

bool BorderMarker::IsAtBorder(const DepthImage& depth, int u, int v) const {
  const auto reaches = [](int distance, int first) {
    return distance < kNear || (distance < kFar && first >= distance);
  };
  const auto row = static_cast<size_t>(v);
  const auto column = static_cast<size_t>(u);
  return reaches(u, left_[row]) || reaches(depth.width - 1 - u, right_[row]) ||
         reaches(v, top_[column]) || reaches(depth.height - 1 - v, bottom_[column]);
}

void BorderMarker::Mark(const DepthImage& depth, std::span<Cluster> clusters) {
  bool is_prepared = false;
  for (Cluster& cluster : clusters) {
    const PixelWindow& window = cluster.window;
    cluster.touches_border = false;
    const int distance =
        std::min({window.u0, window.v0, depth.width - 1 - window.u1, depth.height - 1 - window.v1});
    if (distance >= kFar) continue;
    if (!is_prepared) FindFirst(depth);
    is_prepared = true;
    cluster.touches_border =
        std::any_of(cluster.pixels.begin(), cluster.pixels.end(), [&](uint32_t pixel) {
          const auto width = static_cast<uint32_t>(depth.width);
          return IsAtBorder(
              depth, static_cast<int>(pixel % width), static_cast<int>(pixel / width));
        });
  }
}

}  // namespace vantage
