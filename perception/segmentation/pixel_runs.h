#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/depth_image.h"

namespace vantage {

/// Neighboring pixels of a row without a step in depth.
struct PixelRun {
  int32_t v = 0;
  int32_t u0 = 0;
  int32_t u1 = 0;       ///< Inclusive.
  int32_t cluster = 0;  ///< Or -1.

  [[nodiscard]] int32_t size() const { return u1 - u0 + 1; }
};

/// When two pixels are of one cluster.
struct Connection {
  float largest_gap = 0.0F;  ///< m, between neighbors of one cluster, beyond their spacing
  float slope = 0.0F;        ///< m a pixel and m of depth, that a slanted surface adds
  int gap_px = 0;            ///< px that a link along a row or column may leave out
};

/// Connected components over runs of pixels: He, Chao, Suzuki, "A run-based two-scan labeling
/// algorithm", IEEE Transactions on Image Processing 2008. Two pixels are linked when they touch,
/// corners included, or lie in one row or column with at most `gap_px` between, and their depths
/// agree. Owns its buffers: allocates nothing once warm.
class PixelRuns {
 public:
  /// Finds all components of the pixels with mask 1; those of fewer than `min_points` get cluster
  /// -1, the others 0, 1 ...: largest first, equal ones by their first pixel.
  /// @return number of clusters
  int Connect(const DepthImage& depth,
              std::span<const uint8_t> mask,
              const Connection& connection,
              int min_points);

  /// Row by row, from left to right. Valid until the next call.
  [[nodiscard]] std::span<const PixelRun> runs() const { return runs_; }

 private:
  void FindRuns(const DepthImage& depth, std::span<const uint8_t> mask);
  void JoinAlongRow(const DepthImage& depth, size_t run);
  void JoinAcross(const DepthImage& depth, int v, int rows_before);
  [[nodiscard]] bool Agree(const DepthImage& depth, int u, int v, int du, int dv) const;
  [[nodiscard]] uint32_t Root(uint32_t run);
  void Join(uint32_t a, uint32_t b);
  int NumberClusters(int min_points);

  Connection connection_;
  std::vector<PixelRun> runs_;
  std::vector<uint32_t> row_begin_;  // Of each row in runs_; one more at the end.
  std::vector<uint32_t> parent_;     // Union-find over runs; the smaller index is the root.
  std::vector<uint8_t> continues_;   // Of a row: pixels that go on with the run to their left.
  std::vector<int32_t> sizes_;       // px, of a root
  std::vector<uint32_t> roots_;
};

}  // namespace vantage
