#include "drivers/sim/sensor_model.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/check.h"
#include "common/simd.h"

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

// Disparity of each depth, px; 0 where there is none.
VANTAGE_SIMD void FindDisparities(const float* depth,
                                  size_t count,
                                  float focal_baseline,
                                  float* disparity) {
  for (size_t i = 0; i < count; ++i) {
    const float d = focal_baseline / depth[i];
    disparity[i] = depth[i] > 0.0F ? d : 0.0F;
  }
}

// The least of those above 0 and the largest; 0 stands for none. As bits, disparities from 0 on are
// in the same order.
VANTAGE_SIMD void FindExtremes(const float* disparity, size_t count, float* least, float* largest) {
  uint32_t low = std::numeric_limits<uint32_t>::max();  // Less 1: 0 comes last.
  uint32_t high = 0;
  for (size_t i = 0; i < count; ++i) {
    const auto bits = std::bit_cast<uint32_t>(disparity[i]);
    low = bits - 1U < low ? bits - 1U : low;
    high = bits > high ? bits : high;
  }
  *least = std::bit_cast<float>(low + 1U);
  *largest = std::bit_cast<float>(high);
}

// Shifts of edges in whole px, at most `largest`.
VANTAGE_SIMD void RoundShifts(
    const float* sigma, const float* noise, size_t count, int largest, int* shift) {
  const auto middle = static_cast<float>(largest);
  for (size_t i = 0; i < count; ++i) {
    const int rounded = static_cast<int>(sigma[i] * noise[i] + middle + 0.5F) - largest;
    const int not_above = rounded < largest ? rounded : largest;
    shift[i] = not_above > -largest ? not_above : -largest;
  }
}

// The depth that is reported of one row.
struct Report {
  float focal_baseline;     // px m
  float nearest, farthest;  // m
  float step;               // px
};

template <bool kQuantize>
[[gnu::always_inline]] inline void ReportRow(const Report& report,
                                             const float* exact_depth,
                                             const float* exact_disparity,
                                             const float* observed,
                                             const float* offset,
                                             size_t count,
                                             float* out) {
  const float inverse_step = 1.0F / report.step;
  for (size_t i = 0; i < count; ++i) {
    float d = observed[i] + offset[i];
    if (kQuantize) {
      d = static_cast<float>(static_cast<int>(d * inverse_step + 0.5F)) * report.step;
    }
    // An untouched pixel keeps its exact depth.
    const float other = report.focal_baseline / d;
    const float z = d == exact_disparity[i] ? exact_depth[i] : other;
    const bool valid = (observed[i] > 0.0F) & (z >= report.nearest) & (z <= report.farthest);
    out[i] = valid ? z : DepthImage::kInvalid;
  }
}

VANTAGE_SIMD void ReportQuantized(const Report& report,
                                  const float* exact_depth,
                                  const float* exact_disparity,
                                  const float* observed,
                                  const float* offset,
                                  size_t count,
                                  float* out) {
  ReportRow<true>(report, exact_depth, exact_disparity, observed, offset, count, out);
}

VANTAGE_SIMD void ReportContinuous(const Report& report,
                                   const float* exact_depth,
                                   const float* exact_disparity,
                                   const float* observed,
                                   const float* offset,
                                   size_t count,
                                   float* out) {
  ReportRow<false>(report, exact_depth, exact_disparity, observed, offset, count, out);
}

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
  projector_.resize(static_cast<size_t>(camera.width + kProjectorMargin) + 1);
}

void SensorModel::Prepare(const RenderedView& view) {
  VANTAGE_CHECK(view.camera == camera_, "the view is of another camera");
  window_ = view.window;
  VANTAGE_CHECK(window_.u0 % kAlignment == 0 && window_.v0 % kAlignment == 0,
                "the window begins at multiples of 16 px");
  const size_t size = view.depth.depth.size();
  const auto width = static_cast<size_t>(window_.width());
  disparity_.resize(size);
  observed_.resize(size);
  projector_column_.resize(width);
  offset_row_.resize(width);
  noise_row_.resize(width);
  sigma_row_.resize(width);
  shift_u_row_.resize(width);
  shift_v_row_.resize(width);
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
  bias_waves_.clear();
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
  bias_phase_ = rng.Uniform(0.0, 2.0 * std::numbers::pi);
}

void SensorModel::SetDevice(uint64_t device_id) {
  parameters_.device_id = device_id;
  MakeBias();
}

double SensorModel::BiasField(double u, double v, double time) const {
  double sum = 0.0;
  for (const BiasWave& wave : bias_waves_) {
    sum += std::cos(wave.ku * u + wave.kv * v + wave.phase + wave.drift * time);
  }
  return bias_amplitude_ * (1.0 - kBiasDepthShare) * sum / static_cast<double>(bias_waves_.size());
}

float SensorModel::BiasTerm(size_t index) const {
  const double d = kBiasTermStep * static_cast<double>(index);
  const double angle = 2.0 * std::numbers::pi * d / kBiasDisparityPeriod + bias_phase_;
  return static_cast<float>(bias_amplitude_ * kBiasDepthShare * std::sin(angle));
}

size_t SensorModel::BiasTermIndex(float disparity) {
  constexpr float kSteps = static_cast<float>(1.0 / kBiasTermStep);
  constexpr float kLast = static_cast<float>(kLargestDisparity) * kSteps;
  return static_cast<size_t>(static_cast<int>(std::min(disparity * kSteps, kLast)));
}

// Terms of the disparities in hand; where there is none, any will do.
void SensorModel::FillBiasTerms() {
  float least = 0.0F;
  float largest = 0.0F;
  FindExtremes(disparity_.data(), disparity_.size(), &least, &largest);
  bias_terms_.resize(BiasTermIndex(static_cast<float>(kLargestDisparity)) + 1);
  if (!(largest > 0.0F)) return;
  for (size_t i = BiasTermIndex(least); i <= BiasTermIndex(largest); ++i) {
    bias_terms_[i] = BiasTerm(i);
  }
}

double SensorModel::BiasDisparity(double u, double v, double disparity, double time) const {
  return BiasField(u, v, time) +
         static_cast<double>(BiasTerm(BiasTermIndex(static_cast<float>(disparity))));
}

void SensorModel::FillBiasGrid(double time) {
  const int columns = window_.width() / kBiasCell + 2;
  const int rows = window_.height() / kBiasCell + 2;
  bias_grid_.clear();
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      bias_grid_.push_back(static_cast<float>(
          BiasField(window_.u0 + column * kBiasCell, window_.v0 + row * kBiasCell, time)));
    }
  }
}

void SensorModel::AddBiasRow(int v) {
  const auto columns = static_cast<size_t>(window_.width() / kBiasCell + 2);
  const float* above = bias_grid_.data() + static_cast<size_t>(v / kBiasCell) * columns;
  const float* below = above + columns;
  constexpr float kPart = 1.0F / kBiasCell;
  const float part_v = kPart * static_cast<float>(v % kBiasCell);
  const float* truth = observed_.data() + static_cast<size_t>(v * window_.width());
  for (int u0 = 0; u0 < window_.width(); u0 += kBiasCell) {
    const int cell = u0 / kBiasCell;
    const float left = above[cell] + part_v * (below[cell] - above[cell]);
    const float right = above[cell + 1] + part_v * (below[cell + 1] - above[cell + 1]);
    const int count = std::min(kBiasCell, window_.width() - u0);
    float* offset = offset_row_.data() + u0;
    for (int i = 0; i < count; ++i) {
      offset[i] += left + kPart * static_cast<float>(i) * (right - left) +
                   bias_terms_[BiasTermIndex(truth[u0 + i])];
    }
  }
}

void SensorModel::Measure(const RenderedView& view,
                          int64_t frame,
                          double time,
                          DepthImage* measured) {
  Prepare(view);
  Rng rng(parameters_.seed ^ parameters_.device_id, static_cast<uint64_t>(frame));
  const NoiseTile::Window axial(tile_, rng);
  const NoiseTile::Window along_u(tile_, rng);
  const NoiseTile::Window along_v(tile_, rng);
  const NoiseTile::Window dropout(tile_, rng);

  FindDisparities(view.depth.depth.data(),
                  disparity_.size(),
                  static_cast<float>(focal_baseline_),
                  disparity_.data());
  if (parameters_.bias) {
    FillBiasGrid(time);
    FillBiasTerms();
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

  measured->width = window_.width();
  measured->height = window_.height();
  measured->depth.resize(observed_.size());
  for (int v = 0; v < window_.height(); ++v) {
    std::fill(offset_row_.begin(), offset_row_.end(), 0.0F);
    if (parameters_.axial_noise) AddNoiseRow(view, v, axial);
    if (parameters_.bias) AddBiasRow(v);
    MeasureRow(view, v, measured->depth.data() + view.depth.Index(0, v));
  }
}

void SensorModel::CastShadows() {
  const auto width = static_cast<size_t>(window_.width());
  const auto steepest = static_cast<float>(vga_scale_);
  for (int v = 0; v < window_.height(); ++v) {
    float* row = disparity_.data() + static_cast<size_t>(v) * width;
    // Where disparity grows by less than a pixel a pixel, the projector sees all in the same order.
    int jumps = 0;
    for (size_t u = 1; u < width; ++u) jumps += row[u] - row[u - 1] >= steepest ? 1 : 0;
    if (jumps > 0) CastRowShadows({row, width});
  }
}

void SensorModel::CastRowShadows(std::span<float> row) {
  // A point of disparity d px at column u lies in the projector's column u - d. What of a column is
  // nearest gets the light.
  const auto scale = static_cast<float>(1.0 / vga_scale_);
  constexpr float kOffset = static_cast<float>(kProjectorMargin) + 0.5F;
  const auto first = static_cast<size_t>(window_.u0);
  const auto seen = [&](size_t u) {
    return std::min(row[u] * scale, static_cast<float>(kProjectorMargin));
  };
  for (size_t u = 0; u < row.size(); ++u) {
    projector_column_[u] = static_cast<int>(static_cast<float>(first + u) - seen(u) + kOffset);
  }
  const auto [least, largest] =
      std::minmax_element(projector_column_.begin(), projector_column_.end());
  std::fill(projector_.begin() + *least, projector_.begin() + *largest + 1, 0.0F);
  int last_column = 0;
  float last = 0.0F;
  for (size_t u = 0; u < row.size(); ++u) {
    const float d = seen(u);
    const int column = projector_column_[u];
    if (d > 0.0F) {
      float& lit = projector_[static_cast<size_t>(column)];
      lit = std::max(lit, d);
      // A surface that recedes to the right covers columns between those of its pixels.
      if (column > last_column + 1 && last - d < kSurfaceStep && last > d) {
        for (int between = last_column + 1; between < column; ++between) {
          float& gap = projector_[static_cast<size_t>(between)];
          gap = std::max(gap, d);
        }
      }
    }
    last_column = column;
    last = d;
  }
  for (size_t u = 0; u < row.size(); ++u) {
    const float light = projector_[static_cast<size_t>(projector_column_[u])];
    if (light > row[u] * scale + kShadowTolerance) row[u] = 0.0F;
  }
}

void SensorModel::DropAtGrazing(const RenderedView& view, const NoiseTile::Window& noise) {
  const auto harmless = static_cast<float>(std::cos(parameters_.dropout_start));
  size_t i = 0;
  for (int v = 0; v < window_.height(); ++v) {
    for (int u = 0; u < window_.width(); ++u, ++i) {
      const float cosine = view.cos_incidence[i];
      if (cosine >= harmless || disparity_[i] <= 0.0F) continue;
      const auto step = static_cast<size_t>(cosine * static_cast<float>(kAngleSteps));
      if (noise.at(window_.u0 + u, window_.v0 + v) < dropout_table_[step]) disparity_[i] = 0.0F;
    }
  }
}

void SensorModel::FindEdges(const RenderedView& view) {
  const auto edge = static_cast<float>(parameters_.edge_step);
  const int columns = EdgeColumns();
  const auto width = static_cast<size_t>(window_.width());
  edge_blocks_.assign(static_cast<size_t>(columns * EdgeRows()), 0);
  for (int v = 0; v < window_.height(); ++v) {
    // The last row and the last column have their neighbours before them.
    const size_t below = v + 1 < window_.height() ? width : 0;
    uint8_t* blocks = edge_blocks_.data() + v / kEdgeBlock * columns;
    for (int u0 = 0; u0 < window_.width(); u0 += kEdgeBlock) {
      const int u1 = std::min(u0 + kEdgeBlock, window_.width() - 1);
      const size_t row = view.depth.Index(0, v);
      int edges = 0;
      for (size_t i = row + static_cast<size_t>(u0); i < row + static_cast<size_t>(u1); ++i) {
        edges |= static_cast<int>(view.surface[i] != view.surface[i + 1]) |
                 static_cast<int>(view.surface[i] != view.surface[i + below]) |
                 static_cast<int>(std::abs(disparity_[i] - disparity_[i + 1]) > edge) |
                 static_cast<int>(std::abs(disparity_[i] - disparity_[i + below]) > edge);
      }
      blocks[u0 / kEdgeBlock] |= static_cast<uint8_t>(edges);
    }
  }
}

bool SensorModel::EdgeNear(int column, int row) const {
  for (int r = std::max(row - 1, 0); r <= std::min(row + 1, EdgeRows() - 1); ++r) {
    for (int c = std::max(column - 1, 0); c <= std::min(column + 1, EdgeColumns() - 1); ++c) {
      if (edge_blocks_[static_cast<size_t>(r * EdgeColumns() + c)] != 0) return true;
    }
  }
  return false;
}

void SensorModel::ShiftEdges(const RenderedView& view,
                             const NoiseTile::Window& along_u,
                             const NoiseTile::Window& along_v) {
  FindEdges(view);
  observed_ = disparity_;
  for (int row = 0; row < EdgeRows(); ++row) {
    const int v1 = std::min((row + 1) * kEdgeBlock, window_.height());
    for (int column = 0; column < EdgeColumns(); ++column) {
      const int first = column;
      while (column < EdgeColumns() && EdgeNear(column, row)) ++column;
      const int u1 = std::min(column * kEdgeBlock, window_.width());
      for (int v = row * kEdgeBlock; first < column && v < v1; ++v) {
        ShiftPixels(view, first * kEdgeBlock, u1, v, along_u, along_v);
      }
    }
  }
}

void SensorModel::ShiftPixels(const RenderedView& view,
                              int u0,
                              int u1,
                              int v,
                              const NoiseTile::Window& along_u,
                              const NoiseTile::Window& along_v) {
  const auto count = static_cast<size_t>(u1 - u0);
  const std::span<float> noise(noise_row_.data(), count);
  const float* cosines = view.cos_incidence.data() + view.depth.Index(u0, v);
  constexpr int kLast = static_cast<int>(kAngleSteps) - 1;
  for (size_t i = 0; i < count; ++i) {
    // Without a surface there is no angle either.
    const int angle = std::min(static_cast<int>(cosines[i] * float{kAngleSteps}), kLast);
    sigma_row_[i] = lateral_table_[static_cast<size_t>(cosines[i] > 0.0F ? angle : kLast)];
  }
  along_u.Row(window_.u0 + u0, window_.v0 + v, noise);
  RoundShifts(sigma_row_.data(), noise.data(), count, kEdgeBlock, shift_u_row_.data());
  along_v.Row(window_.u0 + u0, window_.v0 + v, noise);
  RoundShifts(sigma_row_.data(), noise.data(), count, kEdgeBlock, shift_v_row_.data());
  for (size_t i = 0; i < count; ++i) {
    const int u = u0 + static_cast<int>(i);
    const int from_u = u + shift_u_row_[i];
    const int from_v = v + shift_v_row_[i];
    if (!view.depth.Contains(from_u, from_v)) continue;
    const size_t to = view.depth.Index(u, v);
    const size_t from = view.depth.Index(from_u, from_v);
    if (view.surface[from] != view.surface[to] ||
        std::abs(disparity_[from] - disparity_[to]) > static_cast<float>(parameters_.edge_step)) {
      observed_[to] = disparity_[from];
    }
  }
}

void SensorModel::AddNoiseRow(const RenderedView& view, int v, const NoiseTile::Window& noise) {
  const size_t row = view.depth.Index(0, v);
  const auto width = static_cast<size_t>(window_.width());
  const auto focal_baseline = static_cast<float>(focal_baseline_);
  const auto sigma = static_cast<float>(parameters_.axial_sigma);
  constexpr float kGrazing = 0.5F;  // cos 60 degrees
  noise.Row(window_.u0, window_.v0 + v, noise_row_);
  int grazing = 0;
  for (size_t u = 0; u < width; ++u) {
    grazing += view.cos_incidence[row + u] < kGrazing ? 1 : 0;
    offset_row_[u] += sigma * noise_row_[u];
  }
  if (grazing == 0) return;
  for (size_t u = 0; u < width; ++u) {
    const float cosine = view.cos_incidence[row + u];
    if (cosine >= kGrazing || cosine <= 0.0F || observed_[row + u] <= 0.0F) continue;
    // sigma_z = c z^-1/2, in disparity c z^-5/2 f b.
    const float z = focal_baseline / observed_[row + u];
    const float extra = grazing_table_[static_cast<size_t>(cosine * kAngleSteps)];
    offset_row_[u] += extra * focal_baseline / (z * z * std::sqrt(z)) * noise_row_[u];
  }
}

void SensorModel::MeasureRow(const RenderedView& view, int v, float* out) const {
  const size_t row = view.depth.Index(0, v);
  const Report report{static_cast<float>(focal_baseline_),
                      static_cast<float>(parameters_.nearest),
                      static_cast<float>(parameters_.farthest),
                      static_cast<float>(parameters_.disparity_step)};
  (parameters_.quantization ? ReportQuantized : ReportContinuous)(
      report,
      view.depth.depth.data() + row,
      disparity_.data() + row,
      observed_.data() + row,
      offset_row_.data(),
      static_cast<size_t>(window_.width()),
      out);
}

}  // namespace vantage
