#include "drivers/sim/noise_tile.h"

#include <algorithm>
#include <cmath>

#include "common/simd.h"

namespace vantage {
namespace {

/// Smooths rows or columns (`stride` apart along the line, `count` values) of a periodic field.
void SmoothLine(const std::vector<float>& kernel,
                size_t count,
                size_t stride,
                float* line,
                std::vector<float>* scratch) {
  const size_t radius = kernel.size() - 1;
  scratch->resize(count + 2 * radius);
  for (size_t i = 0; i < scratch->size(); ++i) {
    (*scratch)[i] = line[((i + count - radius % count) % count) * stride];
  }
  for (size_t i = 0; i < count; ++i) {
    const float* center = scratch->data() + i + radius;
    float sum = kernel[0] * *center;
    for (size_t j = 1; j <= radius; ++j) {
      sum += kernel[j] * (*(center - j) + *(center + j));
    }
    line[i * stride] = sum;
  }
}

VANTAGE_SIMD void AddRows(
    const float* first, const float* second, size_t count, float factor, float* out) {
  for (size_t i = 0; i < count; ++i) out[i] = factor * (first[i] + second[i]);
}

}  // namespace

NoiseTile::NoiseTile(double correlation, uint64_t seed) : values_(kWidth * kHeight) {
  Rng rng(seed, 0x74696c65);
  for (float& value : values_) value = static_cast<float>(rng.Normal());
  if (correlation > 0.0) {
    std::vector<float> kernel;
    for (int i = 0; i <= static_cast<int>(std::ceil(3.0 * correlation)); ++i) {
      kernel.push_back(static_cast<float>(std::exp(-0.5 * i * i / (correlation * correlation))));
    }
    std::vector<float> scratch;
    for (size_t v = 0; v < kHeight; ++v) {
      SmoothLine(kernel, kWidth, 1, values_.data() + v * kWidth, &scratch);
    }
    for (size_t u = 0; u < kWidth; ++u) {
      SmoothLine(kernel, kHeight, kWidth, values_.data() + u, &scratch);
    }
  }
  double sum = 0.0;
  double sum_squares = 0.0;
  for (const float value : values_) {
    sum += static_cast<double>(value);
    sum_squares += static_cast<double>(value) * static_cast<double>(value);
  }
  const double mean = sum / static_cast<double>(values_.size());
  const double sigma = std::sqrt(sum_squares / static_cast<double>(values_.size()) - mean * mean);
  for (float& value : values_) {
    value = static_cast<float>((static_cast<double>(value) - mean) / sigma);
  }
}

NoiseTile::Window::Window(const NoiseTile& tile, Rng& rng)
    : values_(tile.values_.data()),
      u1_(rng.Below(kWidth)),
      v1_(rng.Below(kHeight)),
      u2_(rng.Below(kWidth)),
      v2_(rng.Below(kHeight)) {}

void NoiseTile::Window::Row(int u, int v, std::span<float> row) const {
  const auto x = static_cast<uint32_t>(u);
  const auto y = static_cast<uint32_t>(v);
  const float* first = values_ + Index(0, y + v1_);
  const float* second = values_ + Index(0, y + v2_);
  // In pieces that neither window's wrapping cuts.
  for (size_t done = 0; done < row.size();) {
    const size_t a = (x + u1_ + done) & (kWidth - 1);
    const size_t b = (x + u2_ + done) & (kWidth - 1);
    const size_t count = std::min(row.size() - done, kWidth - std::max(a, b));
    AddRows(first + a, second + b, count, kHalf, row.data() + done);
    done += count;
  }
}

}  // namespace vantage
