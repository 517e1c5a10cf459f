#include "drivers/sim/sensor_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/check.h"

namespace vantage {
namespace {

constexpr double kReferenceWidth = 640.0;  // px, of the image that disparities refer to.
constexpr int kProjectorMargin = 1024;     // px, larger than any disparity that casts a shadow.
constexpr float kShadowTolerance = 1.0F;   // px, one pixel of our image.
constexpr float kSurfaceStep = 3.0F;       // px, disparity step within one lit surface.
constexpr float kNeverDrops = -100.0F;     // Below any standard normal number.
constexpr float kAlwaysDrops = 100.0F;
constexpr double kLargestMeasuredAngle = 85.0 * kDegree;  // The laws of [N] diverge at 90 degrees.
constexpr double kBiasDepthShare = 0.3;        // Of the bias's amplitude, the part over disparity.
constexpr double kBiasDisparityPeriod = 14.0;  // px
constexpr double kBiasTermStep = 0.25;         // px, of the table over disparity.
constexpr double kLargestDisparity = 512.0;    // px, of that table.

/// z with P(Z <= z) = p for a standard normal Z, by bisection; 0 < p < 1.
double NormalQuantile(double p) {
  double lo = -10.0;
  double hi = 10.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (lo + hi);
    (0.5 * std::erfc(-middle / std::numbers::sqrt2) < p ? lo : hi) = middle;
  }
  return 0.5 * (lo + hi);
}

/// Nearest whole number of a value above -16.
int RoundOffset(float value) { return static_cast<int>(value + 16.5F) - 16; }

}  // namespace

SensorModel::SensorModel(const SensorModelParameters& parameters, const CameraModel& camera)
    : parameters_(parameters),
      camera_(camera),
      focal_baseline_(camera.fx * kReferenceWidth / camera.width * parameters.baseline),
      vga_scale_(kReferenceWidth / camera.width),
      tile_(parameters.correlation / vga_scale_, parameters.seed) {
  const Result<void> sound = parameters.Validate();
  VANTAGE_CHECK(sound.ok(), sound.error().message);
  MakeTables();
  MakeBias();
  const size_t size = static_cast<size_t>(camera.width) * static_cast<size_t>(camera.height);
  disparity_.resize(size);
  observed_.resize(size);
  projector_.resize(static_cast<size_t>(camera.width + kProjectorMargin) + 1);
  bias_row_.resize(static_cast<size_t>(camera.width));
}

void SensorModel::MakeTables() {
  for (size_t i = 0; i < kAngleSteps; ++i) {
    const double cosine = (static_cast<double>(i) + 0.5) / static_cast<double>(kAngleSteps);
    const double angle = std::acos(cosine);
    const double measured = std::min(angle, kLargestMeasuredAngle);
    const double slant = measured / (0.5 * std::numbers::pi - measured);
    lateral_table_.push_back(static_cast<float>(
        (parameters_.lateral_sigma + parameters_.lateral_sigma_angle * slant) / vga_scale_));
    grazing_table_.push_back(static_cast<float>(
        angle > 60.0 * kDegree ? parameters_.grazing_sigma * slant * slant : 0.0));
    const double probability =
        (angle - parameters_.dropout_start) / (parameters_.dropout_end - parameters_.dropout_start);
    dropout_table_.push_back(probability <= 0.0 ? kNeverDrops
                             : probability >= 1.0
                                 ? kAlwaysDrops
                                 : static_cast<float>(NormalQuantile(probability)));
  }
}

void SensorModel::MakeBias() {
  bias_amplitude_ = focal_baseline_ * parameters_.bias_at_1m;
  Rng rng(parameters_.device_id, 0x62696173);
  constexpr int kWaves = 5;
  for (int i = 0; i < kWaves; ++i) {
    const double wavelength = rng.Uniform(250.0, 900.0);  // px of the 640 px image
    const double direction = rng.Uniform(0.0, 2.0 * std::numbers::pi);
    const double k = 2.0 * std::numbers::pi / wavelength * vga_scale_;
    const double drift = 2.0 * std::numbers::pi / parameters_.bias_period * rng.Uniform(-1.0, 1.0);
    bias_waves_.push_back({k * std::cos(direction),
                           k * std::sin(direction),
                           rng.Uniform(0.0, 2.0 * std::numbers::pi),
                           drift});
  }
  const double phase = rng.Uniform(0.0, 2.0 * std::numbers::pi);
  for (double d = 0.0; d <= kLargestDisparity; d += kBiasTermStep) {
    const double angle = 2.0 * std::numbers::pi * d / kBiasDisparityPeriod + phase;
    bias_depth_term_.push_back(
        static_cast<float>(bias_amplitude_ * kBiasDepthShare * std::sin(angle)));
  }
}

double SensorModel::BiasField(double u, double v, double time) const {
  double sum = 0.0;
  for (const BiasWave& wave : bias_waves_) {
    sum += std::cos(wave.ku * u + wave.kv * v + wave.phase + wave.drift * time);
  }
  return bias_amplitude_ * (1.0 - kBiasDepthShare) * sum / static_cast<double>(bias_waves_.size());
}

float SensorModel::BiasDepthTerm(float disparity) const {
  const auto step = static_cast<size_t>(disparity * static_cast<float>(1.0 / kBiasTermStep));
  return bias_depth_term_[std::min(step, bias_depth_term_.size() - 1)];
}

double SensorModel::BiasDisparity(double u, double v, double disparity, double time) const {
  return BiasField(u, v, time) + static_cast<double>(BiasDepthTerm(static_cast<float>(disparity)));
}

void SensorModel::FillBiasGrid(double time) {
  const int columns = camera_.width / kBiasCell + 2;
  const int rows = camera_.height / kBiasCell + 2;
  bias_grid_.clear();
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      bias_grid_.push_back(
          static_cast<float>(BiasField(column * kBiasCell, row * kBiasCell, time)));
    }
  }
}

void SensorModel::InterpolateBiasRow(int v) {
  const auto columns = static_cast<size_t>(camera_.width / kBiasCell + 2);
  const float* above = bias_grid_.data() + static_cast<size_t>(v / kBiasCell) * columns;
  const float* below = above + columns;
  constexpr float kPart = 1.0F / kBiasCell;
  const float part_v = kPart * static_cast<float>(v % kBiasCell);
  for (int u = 0; u < camera_.width; ++u) {
    const int cell = u / kBiasCell;
    const float part_u = kPart * static_cast<float>(u % kBiasCell);
    const float left = above[cell] + part_v * (below[cell] - above[cell]);
    const float right = above[cell + 1] + part_v * (below[cell + 1] - above[cell + 1]);
    bias_row_[static_cast<size_t>(u)] = left + part_u * (right - left);
  }
}

void SensorModel::Measure(const RenderedView& view,
                          int64_t frame,
                          double time,
                          DepthImage* measured) {
  VANTAGE_CHECK(view.camera == camera_, "the view is of another camera");
  Rng rng(parameters_.seed ^ parameters_.device_id, static_cast<uint64_t>(frame));
  const NoiseTile::Window axial(tile_, rng);
  const NoiseTile::Window along_u(tile_, rng);
  const NoiseTile::Window along_v(tile_, rng);
  const NoiseTile::Window dropout(tile_, rng);

  const auto focal_baseline = static_cast<float>(focal_baseline_);
  for (size_t i = 0; i < disparity_.size(); ++i) {
    const float z = view.depth.depth[i];
    disparity_[i] = z > 0.0F ? focal_baseline / z : 0.0F;
  }
  // From here on 0 stands for no measurement. What is lost, is lost before edges shift: they shift
  // the borders of holes too.
  if (parameters_.shadow) CastShadows();
  if (parameters_.grazing_dropout) DropAtGrazing(view, dropout);
  if (parameters_.lateral_noise) {
    ShiftEdges(view, along_u, along_v);
  } else {
    observed_ = disparity_;
  }

  measured->width = camera_.width;
  measured->height = camera_.height;
  measured->depth.resize(observed_.size());
  if (parameters_.bias) FillBiasGrid(time);
  for (int v = 0; v < camera_.height; ++v) {
    MeasureRow(view,
               v,
               parameters_.axial_noise ? &axial : nullptr,
               measured->depth.data() + view.depth.Index(0, v));
  }
}

void SensorModel::CastShadows() {
  // A point of disparity d px at column u lies in the projector's column u - d. What of a column is
  // nearest gets the light.
  const auto scale = static_cast<float>(1.0 / vga_scale_);
  const auto width = static_cast<size_t>(camera_.width);
  constexpr float kOffset = static_cast<float>(kProjectorMargin) + 0.5F;
  for (int v = 0; v < camera_.height; ++v) {
    float* row = disparity_.data() + static_cast<size_t>(v) * width;
    std::fill(projector_.begin(), projector_.end(), 0.0F);
    size_t last_column = 0;
    float last = 0.0F;
    for (size_t u = 0; u < width; ++u) {
      const float d = std::min(row[u] * scale, static_cast<float>(kProjectorMargin));
      if (d > 0.0F) {
        const auto column = static_cast<size_t>(static_cast<float>(u) - d + kOffset);
        projector_[column] = std::max(projector_[column], d);
        // A surface that recedes to the right covers columns between those of its pixels.
        if (last > d && last - d < kSurfaceStep) {
          for (size_t between = last_column + 1; between < column; ++between) {
            projector_[between] = std::max(projector_[between], d);
          }
        }
        last_column = column;
      }
      last = d;
    }
    for (size_t u = 0; u < width; ++u) {
      const float d = std::min(row[u] * scale, static_cast<float>(kProjectorMargin));
      if (d <= 0.0F) continue;
      const auto column = static_cast<size_t>(static_cast<float>(u) - d + kOffset);
      if (projector_[column] > d + kShadowTolerance) row[u] = 0.0F;
    }
  }
}

void SensorModel::DropAtGrazing(const RenderedView& view, const NoiseTile::Window& noise) {
  const auto harmless = static_cast<float>(std::cos(parameters_.dropout_start));
  size_t i = 0;
  for (int v = 0; v < camera_.height; ++v) {
    for (int u = 0; u < camera_.width; ++u, ++i) {
      const float cosine = view.cos_incidence[i];
      if (cosine >= harmless || disparity_[i] <= 0.0F) continue;
      const auto step = static_cast<size_t>(cosine * static_cast<float>(kAngleSteps));
      if (noise.at(u, v) < dropout_table_[step]) disparity_[i] = 0.0F;
    }
  }
}

void SensorModel::ShiftEdges(const RenderedView& view,
                             const NoiseTile::Window& along_u,
                             const NoiseTile::Window& along_v) {
  const auto edge = static_cast<float>(parameters_.edge_step);
  size_t i = 0;
  for (int v = 0; v < camera_.height; ++v) {
    for (int u = 0; u < camera_.width; ++u, ++i) {
      observed_[i] = disparity_[i];
      const auto step =
          std::min(static_cast<size_t>(view.cos_incidence[i] * static_cast<float>(kAngleSteps)),
                   kAngleSteps - 1);
      // No surface: cos_incidence 0 would stand for a grazing one.
      const float sigma = lateral_table_[view.cos_incidence[i] > 0.0F ? step : kAngleSteps - 1];
      const int from_u = u + std::clamp(RoundOffset(sigma * along_u.at(u, v)), -15, 15);
      const int from_v = v + std::clamp(RoundOffset(sigma * along_v.at(u, v)), -15, 15);
      if (!view.depth.Contains(from_u, from_v)) continue;
      const size_t from = view.depth.Index(from_u, from_v);
      if (view.surface[from] != view.surface[i] ||
          std::abs(disparity_[from] - disparity_[i]) > edge) {
        observed_[i] = disparity_[from];
      }
    }
  }
}

void SensorModel::MeasureRow(const RenderedView& view,
                             int v,
                             const NoiseTile::Window* noise,
                             float* out) {
  const size_t row = view.depth.Index(0, v);
  const auto focal_baseline = static_cast<float>(focal_baseline_);
  const auto sigma = static_cast<float>(parameters_.axial_sigma);
  const auto nearest = static_cast<float>(parameters_.nearest);
  const auto farthest = static_cast<float>(parameters_.farthest);
  const auto step = static_cast<float>(parameters_.disparity_step);
  const float inverse_step = 1.0F / step;
  constexpr float kGrazing = 0.5F;  // cos 60 degrees
  if (parameters_.bias) InterpolateBiasRow(v);
  for (int u = 0; u < camera_.width; ++u) {
    const size_t i = row + static_cast<size_t>(u);
    const float truth = observed_[i];
    float d = truth;
    if (noise != nullptr && truth > 0.0F) {
      float total = sigma;
      if (view.cos_incidence[i] < kGrazing && view.cos_incidence[i] > 0.0F) {
        // sigma_z = c z^-1/2, in disparity c z^-5/2 f b.
        const float z = focal_baseline / truth;
        const auto angle = static_cast<size_t>(view.cos_incidence[i] * kAngleSteps);
        total += grazing_table_[angle] * focal_baseline / (z * z * std::sqrt(z));
      }
      d += total * noise->at(u, v);
    }
    if (parameters_.bias) d += bias_row_[static_cast<size_t>(u)] + BiasDepthTerm(truth);
    if (parameters_.quantization) {
      d = static_cast<float>(static_cast<int>(d * inverse_step + 0.5F)) * step;
    }
    // An untouched pixel keeps its exact depth.
    const float z = d == disparity_[i] ? view.depth.depth[i] : focal_baseline / d;
    out[u] = truth > 0.0F && z >= nearest && z <= farthest ? z : DepthImage::kInvalid;
  }
}

}  // namespace vantage
