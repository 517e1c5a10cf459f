#include "perception/refinement/view_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>
#include <span>

#include "common/simd.h"

namespace vantage {
namespace {

constexpr size_t kMargin = 8;        // Around the drawn pixels: what the smoothing reads.
constexpr float kLeastWhite = 0.2F;  // Where slants add smooth noise: it bounds the time.
constexpr size_t kTaps = 15;         // Of the correlation; reaches no farther than the margin.
constexpr float kStep = 0.02F;       // 1/m, of inverse depth: an edge.
constexpr float kSteepest = 0.06F;   // Squared cosine, of 76 deg.
constexpr float kFarthest = 100.0F;  // m
constexpr float kWhiteShare = 1.0F / 3.0F;  // Of the noise's variance.

using Taps = std::array<float, kTaps>;

// Correlation of white noise under a Gaussian of `sigma`, along one axis.
Taps CorrelationTaps(double sigma) {
  Taps taps{};
  for (size_t k = 0; k < kTaps; ++k) {
    const double x = (static_cast<double>(k) - static_cast<double>(kTaps / 2)) / sigma;
    taps[k] = static_cast<float>(std::exp(-0.25 * x * x));
  }
  return taps;
}

[[gnu::always_inline]] inline void Load(const float* from, F8* lanes) {
  std::memcpy(lanes, from, sizeof(F8));
}

// Every number the sum of those around, `stride` apart.
VANTAGE_SIMD void Convolve(
    const float* in, size_t count, std::span<const float> taps, size_t stride, float* out) {
  for (size_t i = 0; i < count; i += kLanes) {
    F8 sum{};
    F8 lanes;
    for (size_t k = 0; k < kTaps; ++k) {
      Load(in + i + k * stride - kTaps / 2 * stride, &lanes);
      sum += taps[k] * lanes;
    }
    std::memcpy(out + i, &sum, sizeof(sum));
  }
}

// out = a * b
VANTAGE_SIMD void Scale(const float* a, const float* b, size_t count, float* out) {
  for (size_t i = 0; i < count; ++i) out[i] = a[i] * b[i];
}

// out = a * out + b * x
VANTAGE_SIMD void Mix(const float* a, const float* b, const float* x, size_t count, float* out) {
  for (size_t i = 0; i < count; ++i) out[i] = a[i] * out[i] + b[i] * x[i];
}

// m, noise along z that a slant adds beyond 60 deg: eq. 2 of Nguyen, Izadi, Lovell, "Modeling
// Kinect Sensor Noise for Improved 3D Reconstruction and Tracking", 3DIMPVT 2012.
float GrazingNoise(float depth, float cosine) {
  constexpr float kGrazing = 0.5F;
  constexpr float kScale = 1e-4F;  // m^(3/2)
  if (cosine >= kGrazing) return 0.0F;
  const float angle = std::acos(cosine);
  const float left = static_cast<float>(0.5 * M_PI) - angle;
  return kScale / std::sqrt(depth) * angle * angle / (left * left);
}

double Total(const F8& lanes) {
  double total = 0.0;
  for (int i = 0; i < kLanes; ++i) total += static_cast<double>(lanes[i]);
  return total;
}

// Sum of products; `count` is a multiple of kLanes.
VANTAGE_SIMD void Multiply(const float* a, const float* b, size_t count, F8* sum) {
  *sum = F8{};
  for (size_t i = 0; i < count; i += kLanes) {
    F8 of_a;
    F8 of_b;
    Load(a + i, &of_a);
    Load(b + i, &of_b);
    *sum += of_a * of_b;
  }
}

double Product(const float* a, const float* b, size_t count) {
  F8 sum;
  Multiply(a, b, count, &sum);
  return Total(sum);
}

// out += factor * x
VANTAGE_SIMD void AddTimes(float factor, const float* x, size_t count, float* out) {
  for (size_t i = 0; i < count; ++i) out[i] += factor * x[i];
}

// out = a * out + b * x
VANTAGE_SIMD void Blend(float a, float b, const float* x, size_t count, float* out) {
  for (size_t i = 0; i < count; ++i) out[i] = a * out[i] + b * x[i];
}

void Spread(const uint8_t* in, size_t count, uint8_t* out) {
  for (size_t i = 0; i < count; ++i) out[i] |= in[i];
}

// Every so many pixels, for about `points` of the model to be drawn.
int StepFor(const PixelWindow& window, int points) {
  constexpr double kFilled = 0.35;  // Of its ball's window, by a model.
  constexpr int kCoarsest = 16;     // px
  const double area = static_cast<double>(window.width()) * window.height();
  return std::clamp(
      static_cast<int>(std::lround(std::sqrt(kFilled * area / points))), 1, kCoarsest);
}

}  // namespace

// Marks what is not drawn, and steps of the drawn depth, and all within reach.
void ViewEvidenceGatherer::MarkEdges(int reach) {
  near_edge_.assign(plane_, 1);
  const int columns = drawn_.width();
  for (int j = 0; j < drawn_.height(); ++j) {
    const float* depth = view_.inverse_depth() + view_.Index(drawn_.u0, drawn_.v0 + j);
    uint8_t* row = &near_edge_[Place(0, j)];
    for (int i = 0; i < columns; ++i) row[i] = depth[i] == 0.0F ? 1 : 0;
    for (int i = 0; i + 1 < columns; ++i) {
      const uint8_t step = std::abs(depth[i + 1] - depth[i]) > kStep ? 1 : 0;
      row[i] |= step;
      row[i + 1] |= step;
    }
    if (j == 0) continue;
    const float* above = depth - view_.stride();
    uint8_t* row_above = row - stride_;
    for (int i = 0; i < columns; ++i) {
      const uint8_t step = std::abs(above[i] - depth[i]) > kStep ? 1 : 0;
      row[i] |= step;
      row_above[i] |= step;
    }
  }
  spread_ = near_edge_;
  const auto far = static_cast<size_t>(reach);
  for (size_t k = 1; k <= far; ++k) {
    Spread(near_edge_.data() + k, plane_ - k, spread_.data());
    Spread(near_edge_.data(), plane_ - k, spread_.data() + k);
  }
  near_edge_ = spread_;
  for (size_t k = 1; k <= far; ++k) {
    Spread(spread_.data() + k * stride_, plane_ - k * stride_, near_edge_.data());
    Spread(spread_.data(), plane_ - k * stride_, near_edge_.data() + k * stride_);
  }
}

void ViewEvidenceGatherer::Fill(const ModelShape& model,
                                const Pose& T_camera_object,
                                const CameraModel& camera,
                                const DepthImage& depth,
                                double noise_variance,
                                const MultiViewParameters& parameters,
                                ViewEvidence* evidence) {
  const Eigen::Matrix3f R = T_camera_object.linear().cast<float>();
  const Eigen::Vector3f center = (T_camera_object * model.center).cast<float>();
  const auto model_error = static_cast<float>(parameters.single.model_error);
  const double cut = parameters.single.tukey_sigmas;
  const auto scale_of_noise = static_cast<float>(noise_variance);
  const auto inverse_cut = static_cast<float>(1.0 / (cut * cut));
  planes_.assign(kPlanes * plane_, 0.0F);
  white_.assign(plane_, 0.0F);
  smooth_.assign(plane_, 0.0F);
  view_.ForEachPixel([&](const ModelView::Pixel& pixel) {
    const size_t place = Place((pixel.u - view_.u0()) / view_.step() - drawn_.u0,
                               (pixel.v - view_.v0()) / view_.step() - drawn_.v0);
    if (near_edge_[place] != 0) return;
    const float measured = depth.at(pixel.u, pixel.v);
    if (!(measured > 0.0F && measured < kFarthest)) return;
    const Eigen::Vector3f ray = camera.Unproject(pixel.u, pixel.v, 1.0).cast<float>();
    const Eigen::Vector3f normal = VisibleNormal(model.mesh, R, pixel.triangle, ray);
    const float along = normal.dot(ray);
    if (!(along * along > kSteepest * ray.squaredNorm())) return;
    const auto axial =
        static_cast<float>(parameters.single.noise.Axial(static_cast<double>(pixel.depth)));
    const float off_surface = model_error / along;
    const float slanted = GrazingNoise(pixel.depth, std::abs(along) / ray.norm());
    const float base = scale_of_noise * axial * axial;
    const float variance = base + off_surface * off_surface + slanted * slanted;
    const float inverse_sigma = 1.0F / std::sqrt(variance);
    const float step = measured - pixel.depth;
    const float residual = step * inverse_sigma;
    const float loose = variance + (1.0F - scale_of_noise) * axial * axial;
    const float rest = 1.0F - step * step * inverse_cut / loose;  // Of Tukey's biweight.
    ++evidence->compared;
    if (!(rest > 0.0F)) {
      evidence->cost += 1.0;
      return;
    }
    ++evidence->pixels;
    evidence->cost += 1.0 - static_cast<double>(rest * rest * rest);
    evidence->weight += static_cast<double>(rest * rest);
    const float distance = rest * step * along;
    evidence->weighted_square += static_cast<double>(distance * distance);
    const Eigen::Vector3f arm = pixel.depth * ray - center;
    const Eigen::Vector3f turn = arm.cross(normal);
    const float scale = rest * inverse_sigma / along;
    float* at = &planes_[place];
    at[0] = rest;
    at[plane_] = rest * residual;
    white_[place] = std::max(kWhiteShare * base / variance, kLeastWhite);
    smooth_[place] = std::sqrt(1.0F - white_[place]);
    for (Eigen::Index k = 0; k < 3; ++k) {
      at[static_cast<size_t>(k + 2) * plane_] = scale * turn[k];
      at[static_cast<size_t>(k + 5) * plane_] = scale * normal[k];
    }
  });
}

void ViewEvidenceGatherer::Correlate(const float* x, std::span<const float> taps, float* out) {
  const size_t columns = stride_ - 2 * kMargin;
  const size_t margin = kMargin;
  Scale(smooth_.data(), x, plane_, scaled_.data());
  for (size_t j = margin; j + margin < rows_; ++j) {
    const size_t row = j * stride_ + margin;
    Convolve(&scaled_[row], columns, taps, 1, &along_rows_[row]);
  }
  for (size_t j = margin; j + margin < rows_; ++j) {
    const size_t row = j * stride_ + margin;
    Convolve(&along_rows_[row], columns, taps, stride_, out + row);
    Mix(&smooth_[row], &white_[row], x + row, columns, out + row);
  }
}

// Chebyshev's iteration (Golub, Varga 1961), the same polynomial of the correlation for every
// plane: what it leaves unsolved takes weight off, and lets the equations be those of least squares
// still.
void ViewEvidenceGatherer::Whiten(const float* plane, double correlation, float* solution) {
  constexpr int kIterations = 24;
  const Taps taps = CorrelationTaps(correlation);
  const float sum = std::accumulate(taps.begin(), taps.end(), 0.0F);
  const float largest = 1.0F + sum * sum;  // At least the largest eigenvalue.
  const float middle = 0.5F * (largest + kLeastWhite);
  const float half = 0.5F * (largest - kLeastWhite);
  float ratio = half / middle;
  std::fill_n(solution, plane_, 0.0F);
  rest_.assign(plane, plane + plane_);
  direction_.assign(plane_, 0.0F);
  AddTimes(1.0F / middle, plane, plane_, direction_.data());
  for (int i = 0; i < kIterations; ++i) {
    AddTimes(1.0F, direction_.data(), plane_, solution);
    Correlate(direction_.data(), taps, correlated_.data());
    AddTimes(-1.0F, correlated_.data(), plane_, rest_.data());
    const float next = 1.0F / (2.0F * middle / half - ratio);
    Blend(next * ratio, 2.0F * next / half, rest_.data(), plane_, direction_.data());
    ratio = next;
  }
}

void ViewEvidenceGatherer::Sum(Weighing weighing, double correlation, ViewEvidence* evidence) {
  const auto plane = [&](size_t p) { return &planes_[p * plane_]; };
  double scale = 1.0;
  if (weighing == Weighing::kWhitened) {
    along_rows_.assign(plane_, 0.0F);
    scaled_.resize(plane_);
    correlated_.assign(plane_, 0.0F);
    whitened_.resize(6 * plane_);
    for (size_t k = 0; k < 6; ++k) Whiten(plane(k + 2), correlation, &whitened_[k * plane_]);
  } else {
    whitened_.assign(planes_.begin() + static_cast<std::ptrdiff_t>(2 * plane_), planes_.end());
    // So many pixels tell as much as one.
    const double white = static_cast<double>(kWhiteShare);
    scale = 1.0 / (white + (1.0 - white) * std::max(1.0, 4.0 * M_PI * correlation * correlation));
  }
  for (int i = 0; i < 6; ++i) {
    const float* of_i = &whitened_[static_cast<size_t>(i) * plane_];
    evidence->right[i] = scale * Product(of_i, plane(1), plane_);
    for (int j = i; j < 6; ++j) {
      evidence->information(i, j) = evidence->information(j, i) =
          scale * Product(of_i, plane(static_cast<size_t>(j) + 2), plane_);
    }
  }
  evidence->noise_variance = Product(plane(1), plane(1), plane_) / evidence->weight;
}

ViewEvidence ViewEvidenceGatherer::Gather(const ModelShape& model,
                                          const Pose& T_camera_object,
                                          const CameraModel& camera,
                                          const DepthImage& depth,
                                          int points,
                                          Weighing weighing,
                                          double noise_variance,
                                          const MultiViewParameters& parameters) {
  ViewEvidence evidence;
  const PixelWindow window = ModelWindow(camera, model, T_camera_object);
  if (window.empty()) return evidence;
  const int step = StepFor(window, points);
  view_.Render(model.mesh, T_camera_object, camera, window, step);
  if (view_.empty()) return evidence;
  drawn_ = view_.touched();
  const auto columns = static_cast<size_t>(drawn_.width());
  stride_ = (columns + kLanes - 1) / kLanes * kLanes + 2 * kMargin;
  rows_ = static_cast<size_t>(drawn_.height()) + 2 * kMargin;
  plane_ = stride_ * rows_;
  MarkEdges((parameters.edge_px + step - 1) / step);
  Fill(model, T_camera_object, camera, depth, noise_variance, parameters, &evidence);
  if (evidence.pixels > 0) Sum(weighing, parameters.correlation_px / step, &evidence);
  return evidence;
}

}  // namespace vantage
