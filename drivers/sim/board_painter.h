#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "common/so3.h"
#include "drivers/sim/noise_tile.h"
#include "drivers/sim/scene.h"
#include "drivers/sim/scene_renderer.h"

namespace vantage {

/// Paints a printed board into color images as a camera sees it: every pixel is the print's mean
/// under the pixel's area and the lens's blur, so that corners found to a fraction of a pixel lie
/// where they are; with noise.
class BoardPainter {
 public:
  /// @param seed of the noise. The same frame of the same seed is the same always.
  BoardPainter(const SimBoard& board, uint64_t seed);

  /// Paints over those pixels of the view's color image that show the board.
  /// @param surface RenderedView::surface of the board. @param rgb RGB888, of the whole view.
  void Paint(const RenderedView& view,
             const Pose& T_world_camera,
             uint32_t surface,
             int64_t frame,
             std::vector<uint8_t>* rgb);

 private:
  /// The print at half the resolution of the level before.
  struct Level {
    int width = 0;
    int height = 0;
    std::vector<float> values;  // 0 to 255.
  };

  [[nodiscard]] double Interpolated(size_t level, double x, double y) const;
  [[nodiscard]] size_t LevelFor(const Eigen::Matrix3d& H, double u, double v) const;
  void Sample(const Eigen::Matrix3d& H, const PixelWindow& window);
  void Blur(const PixelWindow& window);

  Pose T_world_board_;
  Eigen::Vector2d size_;  // m
  double noise_;          // Of 255.
  uint64_t seed_;
  NoiseTile tile_;
  std::vector<Level> levels_;
  std::vector<float> kernel_;  // One half, its middle first.
  // Reused: the print on a grid finer than pixels, the same blurred along rows, and along both.
  std::vector<float> samples_, rows_, blurred_;
};

}  // namespace vantage
