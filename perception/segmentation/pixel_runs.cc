#include "perception/segmentation/pixel_runs.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/simd.h"

namespace vantage {
namespace {

// 1 where a pixel and the one to its left belong to one run.
VANTAGE_SIMD void MarkContinued(
    const float* depth, const uint8_t* mask, int width, float gap, float slope, uint8_t* marks) {
  marks[0] = 0;
  for (int u = 1; u < width; ++u) {
    const bool is_smooth = std::abs(depth[u] - depth[u - 1]) <= gap + slope * depth[u];
    marks[u] = static_cast<uint8_t>(mask[u] & mask[u - 1] & static_cast<int>(is_smooth));
  }
}

// First pixel from `u` on whose byte is not `value`.
int SkipWhile(const uint8_t* bytes, int u, int width, uint8_t value) {
  const uint64_t pattern = 0x0101010101010101U * value;
  while (u + kLanes <= width) {
    uint64_t eight = 0;
    std::memcpy(&eight, bytes + u, sizeof(eight));
    if (eight != pattern) break;
    u += kLanes;
  }
  while (u < width && bytes[u] == value) ++u;
  return u;
}

}  // namespace

void PixelRuns::FindRuns(const DepthImage& depth, std::span<const uint8_t> mask) {
  runs_.clear();
  row_begin_.clear();
  const int width = depth.width;
  continues_.resize(static_cast<size_t>(width));
  for (int v = 0; v < depth.height; ++v) {
    row_begin_.push_back(static_cast<uint32_t>(runs_.size()));
    const uint8_t* row = mask.data() + depth.Index(0, v);
    int u = SkipWhile(row, 0, width, 0);
    if (u == width) continue;
    MarkContinued(depth.depth.data() + depth.Index(0, v),
                  row,
                  width,
                  connection_.largest_gap,
                  connection_.slope,
                  continues_.data());
    while (u < width) {
      const int end = SkipWhile(continues_.data(), u + 1, width, 1);
      runs_.push_back({v, u, end - 1, -1});
      u = SkipWhile(row, end, width, 0);
    }
  }
  row_begin_.push_back(static_cast<uint32_t>(runs_.size()));
}

// Pixel (u, v) with one before it in row order.
bool PixelRuns::Agree(const DepthImage& depth, int u, int v, int du, int dv) const {
  const float z = depth.at(u, v);
  const float distance = du == 0 || dv == 0 ? static_cast<float>(std::abs(du + dv)) : 1.41421356F;
  return std::abs(z - depth.at(u + du, v + dv)) <=
         connection_.largest_gap + connection_.slope * z * distance;
}

uint32_t PixelRuns::Root(uint32_t run) {
  while (parent_[run] != run) run = parent_[run] = parent_[parent_[run]];
  return run;
}

void PixelRuns::Join(uint32_t a, uint32_t b) {
  a = Root(a);
  b = Root(b);
  parent_[std::max(a, b)] = std::min(a, b);
}

// With runs to the left, across missing data or a step.
void PixelRuns::JoinAlongRow(const DepthImage& depth, size_t run) {
  const PixelRun& right = runs_[run];
  const int reach = connection_.gap_px + 1;
  for (size_t other = run; other-- > row_begin_[static_cast<size_t>(right.v)];) {
    const PixelRun& left = runs_[other];
    if (right.u0 - left.u1 > reach) break;
    for (int u = right.u0; u <= std::min(right.u1, left.u1 + reach); ++u) {
      for (int p = std::max(left.u0, u - reach); p <= left.u1; ++p) {
        if (!Agree(depth, u, right.v, p - u, 0)) continue;
        Join(static_cast<uint32_t>(run), static_cast<uint32_t>(other));
        u = right.u1;
        break;
      }
    }
  }
}

// The runs of a row with those of a row above.
void PixelRuns::JoinAcross(const DepthImage& depth, int v, int rows_before) {
  const int above = v - rows_before;
  const int side = rows_before == 1 ? 1 : 0;
  uint32_t first = row_begin_[static_cast<size_t>(above)];
  const uint32_t end = row_begin_[static_cast<size_t>(above) + 1];
  for (uint32_t i = row_begin_[static_cast<size_t>(v)]; i < row_begin_[static_cast<size_t>(v) + 1];
       ++i) {
    const PixelRun& run = runs_[i];
    while (first < end && runs_[first].u1 + side < run.u0) ++first;
    for (uint32_t j = first; j < end && runs_[j].u0 - side <= run.u1; ++j) {
      if (Root(i) == Root(j)) continue;
      const PixelRun& other = runs_[j];
      bool is_joined = false;
      for (int u = std::max(run.u0, other.u0 - side);
           u <= std::min(run.u1, other.u1 + side) && !is_joined;
           ++u) {
        for (int p = std::max(other.u0, u - side); p <= std::min(other.u1, u + side); ++p) {
          is_joined = is_joined || Agree(depth, u, v, p - u, -rows_before);
        }
      }
      if (is_joined) Join(i, j);
    }
  }
}

int PixelRuns::NumberClusters(int min_points) {
  sizes_.assign(runs_.size(), 0);
  roots_.clear();
  // A root is the first run of its set.
  for (uint32_t i = 0; i < runs_.size(); ++i) sizes_[Root(i)] += runs_[i].size();
  for (uint32_t i = 0; i < runs_.size(); ++i) {
    if (sizes_[i] >= min_points) roots_.push_back(i);
  }
  std::sort(roots_.begin(), roots_.end(), [this](uint32_t a, uint32_t b) {
    return sizes_[a] != sizes_[b] ? sizes_[a] > sizes_[b] : a < b;
  });
  for (size_t i = 0; i < roots_.size(); ++i) runs_[roots_[i]].cluster = static_cast<int32_t>(i);
  for (uint32_t i = 0; i < runs_.size(); ++i) runs_[i].cluster = runs_[Root(i)].cluster;
  return static_cast<int>(roots_.size());
}

int PixelRuns::Connect(const DepthImage& depth,
                       std::span<const uint8_t> mask,
                       const Connection& connection,
                       int min_points) {
  connection_ = connection;
  FindRuns(depth, mask);
  parent_.resize(runs_.size());
  for (uint32_t i = 0; i < parent_.size(); ++i) parent_[i] = i;
  for (int v = 0; v < depth.height; ++v) {
    const uint32_t end = row_begin_[static_cast<size_t>(v) + 1];
    for (uint32_t i = row_begin_[static_cast<size_t>(v)]; i < end; ++i) JoinAlongRow(depth, i);
    for (int rows = 1; rows <= std::min(v, connection.gap_px + 1); ++rows) {
      JoinAcross(depth, v, rows);
    }
  }
  return NumberClusters(min_points);
}

}  // namespace vantage
