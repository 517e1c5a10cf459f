#include "drivers/sim/board_painter.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "common/check.h"
#include "common/rng.h"

namespace vantage {
namespace {

constexpr int kSamples = 3;  // A pixel's, along each of its sides.

/// What black and white ink send back of the light, of 255.
constexpr double kBlack = 25.0;
constexpr double kWhite = 225.0;

/// One half of the kernel that a pixel's side and a Gaussian make together, in steps of a sample.
std::vector<float> PixelKernel(double blur) {
  const double scale = std::sqrt(2.0) * std::max(blur, 1e-3);
  const auto radius = static_cast<int>(std::ceil((0.5 + 3.0 * blur) * kSamples));
  std::vector<double> kernel;
  double sum = 0.0;
  for (int i = 0; i <= radius; ++i) {
    const double x = static_cast<double>(i) / kSamples;
    kernel.push_back(0.5 * (std::erf((x + 0.5) / scale) - std::erf((x - 0.5) / scale)));
    sum += (i == 0 ? 1.0 : 2.0) * kernel.back();
  }
  std::vector<float> normalized;
  for (const double value : kernel) normalized.push_back(static_cast<float>(value / sum));
  return normalized;
}

/// Pixel (u, v, 1) to the place on the board (m, homogeneous) that it shows.
Eigen::Matrix3d BoardFromPixel(const CameraModel& camera, const Pose& T_board_camera) {
  Eigen::Matrix3d K_inverse;
  K_inverse << 1.0 / camera.fx, 0.0, -camera.cx / camera.fx, 0.0, 1.0 / camera.fy,
      -camera.cy / camera.fy, 0.0, 0.0, 1.0;
  // A ray t + s d meets z = 0 where s = -t_z / d_z.
  const Eigen::Vector3d t = T_board_camera.translation();
  Eigen::Matrix3d meet;
  meet << -t.z(), 0.0, t.x(), 0.0, -t.z(), t.y(), 0.0, 0.0, 1.0;
  return meet * T_board_camera.linear() * K_inverse;
}

/// Of the neighbors before, at and after, at an offset of -0.5 to 0.5.
std::array<double, 3> SplineWeights(double offset) {
  const double before = 0.5 - offset;
  const double after = 0.5 + offset;
  return {0.5 * before * before, 0.75 - offset * offset, 0.5 * after * after};
}

PixelWindow WindowOf(const RenderedView& view, uint32_t surface) {
  PixelWindow window{view.window.u1 + 1, view.window.v1 + 1, -1, -1};
  size_t i = 0;
  for (int v = view.window.v0; v <= view.window.v1; ++v) {
    for (int u = view.window.u0; u <= view.window.u1; ++u, ++i) {
      if (view.surface[i] != surface) continue;
      window.u0 = std::min(window.u0, u);
      window.u1 = std::max(window.u1, u);
      window.v0 = std::min(window.v0, v);
      window.v1 = std::max(window.v1, v);
    }
  }
  return window;
}

}  // namespace

BoardPainter::BoardPainter(const SimBoard& board, uint64_t seed)
    : T_world_board_(board.T_world_board),
      size_(board.size),
      noise_(board.noise),
      seed_(seed),
      tile_(0.0, seed),
      kernel_(PixelKernel(board.blur)) {
  VANTAGE_CHECK(board.print.width > 2 && board.print.height > 2, "a print has 3 x 3 px or more");
  levels_.push_back({board.print.width, board.print.height, {}});
  levels_[0].values.assign(board.print.pixels.begin(), board.print.pixels.end());
  while (levels_.back().width > 8 && levels_.back().height > 8) {
    const Level& fine = levels_.back();
    Level coarse{(fine.width + 1) / 2, (fine.height + 1) / 2, {}};
    const auto at = [&fine](int x, int y) {
      const int column = std::min(x, fine.width - 1);
      const int row = std::min(y, fine.height - 1);
      return fine.values[static_cast<size_t>(row) * static_cast<size_t>(fine.width) +
                         static_cast<size_t>(column)];
    };
    for (int y = 0; y < coarse.height; ++y) {
      for (int x = 0; x < coarse.width; ++x) {
        coarse.values.push_back(0.25F * (at(2 * x, 2 * y) + at(2 * x + 1, 2 * y) +
                                         at(2 * x, 2 * y + 1) + at(2 * x + 1, 2 * y + 1)));
      }
    }
    levels_.push_back(std::move(coarse));
  }
}

/// The print at (x, y) pixels of its finest level from its corner, by quadratic B-splines. Their
/// center of gravity stays where it is, and so do edges; bilinear weights, whose slope jumps, would
/// shift those in phase with the samples by some hundredths of a pixel.
double BoardPainter::Interpolated(size_t level, double x, double y) const {
  const Level& print = levels_[level];
  const double scale = std::ldexp(1.0, -static_cast<int>(level));
  const double px = std::clamp(x * scale - 0.5, 1.0, print.width - 2.0);
  const double py = std::clamp(y * scale - 0.5, 1.0, print.height - 2.0);
  const auto column = static_cast<int>(px + 0.5);
  const auto row = static_cast<int>(py + 0.5);
  const std::array<double, 3> across = SplineWeights(px - column);
  const std::array<double, 3> down = SplineWeights(py - row);
  const float* middle = print.values.data() +
                        static_cast<size_t>(row) * static_cast<size_t>(print.width) +
                        static_cast<size_t>(column);
  double sum = 0.0;
  for (int i = -1; i <= 1; ++i) {
    const float* line = middle + i * print.width;
    sum += down[static_cast<size_t>(i + 1)] *
           (across[0] * static_cast<double>(line[-1]) + across[1] * static_cast<double>(line[0]) +
            across[2] * static_cast<double>(line[1]));
  }
  return sum;
}

/// The finest level whose pixels are as wide as samples are apart, on average over directions: of
/// a finer one they would see some pixels and miss others.
size_t BoardPainter::LevelFor(const Eigen::Matrix3d& H, double u, double v) const {
  const auto place = [&](double at_u, double at_v) -> Eigen::Vector2d {
    return levels_[0].width / size_.x() * (H * Eigen::Vector3d(at_u, at_v, 1.0)).hnormalized();
  };
  Eigen::Matrix2d step;
  step.col(0) = (place(u + 0.5, v) - place(u - 0.5, v)) / kSamples;
  step.col(1) = (place(u, v + 0.5) - place(u, v - 0.5)) / kSamples;
  const double spacing = std::sqrt(std::abs(step.determinant()));
  const double level = std::ceil(std::log2(std::max(spacing, 1.0)));
  return std::min(static_cast<size_t>(level), levels_.size() - 1);
}

void BoardPainter::Sample(const Eigen::Matrix3d& H, const PixelWindow& window) {
  const size_t level = LevelFor(H, 0.5 * (window.u0 + window.u1), 0.5 * (window.v0 + window.v1));
  const double x_scale = levels_[0].width / size_.x();
  const double y_scale = levels_[0].height / size_.y();
  const auto margin = static_cast<int>(kernel_.size()) - 1;
  const int columns = kSamples * (window.width() - 1) + 1 + 2 * margin;
  const int rows = kSamples * (window.height() - 1) + 1 + 2 * margin;
  samples_.resize(static_cast<size_t>(columns) * static_cast<size_t>(rows));
  size_t i = 0;
  for (int row = 0; row < rows; ++row) {
    const double v = window.v0 + static_cast<double>(row - margin) / kSamples;
    for (int column = 0; column < columns; ++column, ++i) {
      const double u = window.u0 + static_cast<double>(column - margin) / kSamples;
      const Eigen::Vector3d place = H * Eigen::Vector3d(u, v, 1.0);
      // A ray that runs along the board, or away from it, shows another surface.
      const double inverse = place.z() != 0.0 ? 1.0 / place.z() : 0.0;
      samples_[i] =
          static_cast<float>(Interpolated(level,
                                          (place.x() * inverse + 0.5 * size_.x()) * x_scale,
                                          (place.y() * inverse + 0.5 * size_.y()) * y_scale));
    }
  }
}

void BoardPainter::Blur(const PixelWindow& window) {
  const size_t margin = kernel_.size() - 1;
  const auto width = static_cast<size_t>(window.width());
  const auto height = static_cast<size_t>(window.height());
  const size_t columns = kSamples * (width - 1) + 1 + 2 * margin;
  const size_t num_rows = kSamples * (height - 1) + 1 + 2 * margin;
  const auto along = [this, margin](const float* middle, size_t stride) {
    float sum = kernel_[0] * *middle;
    for (size_t j = 1; j <= margin; ++j) {
      sum += kernel_[j] * (*(middle - j * stride) + *(middle + j * stride));
    }
    return sum;
  };
  rows_.resize(width * num_rows);
  for (size_t row = 0; row < num_rows; ++row) {
    const float* line = samples_.data() + row * columns + margin;
    for (size_t u = 0; u < width; ++u) rows_[row * width + u] = along(line + kSamples * u, 1);
  }
  blurred_.resize(width * height);
  for (size_t v = 0; v < height; ++v) {
    const float* line = rows_.data() + (kSamples * v + margin) * width;
    for (size_t u = 0; u < width; ++u) blurred_[v * width + u] = along(line + u, width);
  }
}

void BoardPainter::Paint(const RenderedView& view,
                         const Pose& T_world_camera,
                         uint32_t surface,
                         int64_t frame,
                         std::vector<uint8_t>* rgb) {
  const PixelWindow window = WindowOf(view, surface);
  if (window.empty()) return;
  const Pose T_board_camera = T_world_board_.inverse(Eigen::Isometry) * T_world_camera;
  Sample(BoardFromPixel(view.camera, T_board_camera), window);
  Blur(window);
  Rng rng(seed_, static_cast<uint64_t>(frame));
  const NoiseTile::Window noise(tile_, rng);
  constexpr double kAmbient = 0.25;  // As other surfaces have it.
  for (int v = window.v0; v <= window.v1; ++v) {
    for (int u = window.u0; u <= window.u1; ++u) {
      const size_t i =
          static_cast<size_t>(v - view.window.v0) * static_cast<size_t>(view.window.width()) +
          static_cast<size_t>(u - view.window.u0);
      if (view.surface[i] != surface) continue;
      const size_t at = static_cast<size_t>(v - window.v0) * static_cast<size_t>(window.width()) +
                        static_cast<size_t>(u - window.u0);
      const double light = kAmbient + (1.0 - kAmbient) * static_cast<double>(view.cos_incidence[i]);
      const double ink = kBlack + (kWhite - kBlack) / 255.0 * static_cast<double>(blurred_[at]);
      const double value = light * ink + noise_ * static_cast<double>(noise.at(u, v));
      const auto gray = static_cast<uint8_t>(std::clamp(value + 0.5, 0.0, 255.0));
      std::fill_n(rgb->begin() + static_cast<std::ptrdiff_t>(3 * i), 3, gray);
    }
  }
}

}  // namespace vantage
