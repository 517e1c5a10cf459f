#include "perception/segmentation/part_splitter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "common/simd.h"
#include "common/so3.h"

namespace vantage {
namespace {

constexpr int kPatch = 4;               // px
constexpr double kFewestPixels = 24.0;  // Of 144, for a plane.
constexpr double kLeastSpread = 2.0;    // px^2, product of the standard deviations across.

}  // namespace

// Row by row, in stretches within one patch.
void PartSplitter::AddPixels(const DepthImage& depth, std::span<const uint32_t> pixels) {
  const auto width = static_cast<uint32_t>(depth.width);
  size_t i = 0;
  while (i < pixels.size()) {
    const uint32_t row = pixels[i] / width;
    const uint32_t row_end = (row + 1) * width;
    const int v = static_cast<int>(row) - window_.v0;
    const uint32_t corner = row * width + static_cast<uint32_t>(window_.u0);
    const size_t patch_row =
        static_cast<size_t>(v / kPatch + 1) * static_cast<size_t>(columns_) + 1;
    while (i < pixels.size() && pixels[i] < row_end) {
      const uint32_t column = (pixels[i] - corner) / kPatch;
      const uint32_t end = std::min(row_end, corner + (column + 1) * kPatch);
      float n = 0.0F;
      float sum_u = 0.0F;
      float sum_uu = 0.0F;
      float sum_rho = 0.0F;
      float sum_u_rho = 0.0F;
      const auto middle = static_cast<float>(column * kPatch);
      for (; i < pixels.size() && pixels[i] < end; ++i) {
        const float u = static_cast<float>(pixels[i] - corner) - middle;
        const float rho = 1.0F / depth.depth[pixels[i]];
        n += 1.0F;
        sum_u += u;
        sum_uu += u * u;
        sum_rho += rho;
        sum_u_rho += u * rho;
      }
      const std::array<double, 5> s = {static_cast<double>(n),
                                       static_cast<double>(sum_u),
                                       static_cast<double>(sum_uu),
                                       static_cast<double>(sum_rho),
                                       static_cast<double>(sum_u_rho)};
      const double shift = static_cast<double>(middle);
      const double u_sum = s[1] + shift * s[0];
      Moments& moments = moments_[patch_row + column];
      moments[0] += s[0];
      moments[1] += u_sum;
      moments[2] += v * s[0];
      moments[3] += s[2] + shift * (2.0 * s[1] + shift * s[0]);
      moments[4] += v * u_sum;
      moments[5] += static_cast<double>(v) * v * s[0];
      moments[6] += s[3];
      moments[7] += s[4] + shift * s[3];
      moments[8] += v * s[3];
    }
  }
}

namespace {

VANTAGE_SIMD void SumThree(
    const double* a, const double* b, const double* c, size_t size, double* sum) {
  for (size_t i = 0; i < size; ++i) sum[i] = a[i] + b[i] + c[i];
}

}  // namespace

// Over 3 x 3 patches: along columns, then along rows.
void PartSplitter::SumNeighbors() {
  const auto columns = static_cast<size_t>(columns_);
  const size_t terms = columns * std::tuple_size_v<Moments>;
  for (size_t row = 1; row + 1 < static_cast<size_t>(rows_); ++row) {
    const double* middle = moments_[row * columns].data();
    SumThree(middle - terms, middle, middle + terms, terms, sums_[row * columns].data());
  }
  for (size_t row = 1; row + 1 < static_cast<size_t>(rows_); ++row) {
    Moments left = sums_[row * columns];
    for (size_t i = row * columns + 1; i + 1 < (row + 1) * columns; ++i) {
      const Moments here = sums_[i];
      for (size_t k = 0; k < here.size(); ++k) sums_[i][k] += left[k] + sums_[i + 1][k];
      left = here;
    }
  }
}

void PartSplitter::FitPlanes(const CameraModel& camera) {
  for (int row = 1; row + 1 < rows_; ++row) {
    for (int column = 1; column + 1 < columns_; ++column) {
      const auto i = static_cast<size_t>(row * columns_ + column);
      Fit& fit = fits_[i];
      fit.is_valid = false;
      const auto& [n, su, sv, suu, suv, svv, sr, sur, svr] = sums_[i];
      if (moments_[i][0] < 1.0 || n < kFewestPixels) continue;
      const double uu = suu - su * su / n;
      const double uv = suv - su * sv / n;
      const double vv = svv - sv * sv / n;
      const double ur = sur - su * sr / n;
      const double vr = svr - sv * sr / n;
      const double determinant = uu * vv - uv * uv;
      if (!(determinant > kLeastSpread * kLeastSpread * n * n)) continue;
      const double a = (ur * vv - vr * uv) / determinant;
      const double b = (vr * uu - ur * uv) / determinant;
      const double c = (sr - a * su - b * sv) / n;
      const double u = kPatch * (column - 0.5) - 0.5;
      const double v = kPatch * (row - 0.5) - 0.5;
      const double rho = a * u + b * v + c;
      if (!(rho > 0.0)) continue;
      const Eigen::Vector3d away(a * camera.fx,
                                 b * camera.fy,
                                 c + a * (camera.cx - window_.u0) + b * (camera.cy - window_.v0));
      fit = {true,
             static_cast<float>(a),
             static_cast<float>(b),
             static_cast<float>(c),
             (-away.normalized()).cast<float>(),
             camera.Unproject(window_.u0 + u, window_.v0 + v, 1.0 / rho).cast<float>()};
    }
  }
}

// Two surfaces that meet at (u, v) from the window's corner: concave when their normals converge.
bool PartSplitter::IsCut(const Fit& before, const Fit& after, float u, float v) const {
  if (!before.is_valid || !after.is_valid) return false;
  const auto least_cosine = static_cast<float>(std::cos(parameters_.concave_angle_deg * kDegree));
  const bool is_concave = (before.normal - after.normal).dot(after.center - before.center) > 0.0F;
  if (is_concave && before.normal.dot(after.normal) < least_cosine) return true;
  const float rho_before = before.a * u + before.b * v + before.c;
  const float rho_after = after.a * u + after.b * v + after.c;
  if (!(rho_before > 0.0F && rho_after > 0.0F)) return false;
  const auto focal = static_cast<float>(camera_.fx);
  const float z = 1.0F / std::max(rho_before, rho_after);
  const float step = std::abs(1.0F / rho_before - 1.0F / rho_after) *
                     std::max(-before.normal.z(), -after.normal.z());
  return step > 0.5F * (static_cast<float>(parameters_.largest_gap) + kPatch * z / focal);
}

// Between neighbors, by the planes of the 3 x 3 patches on either side of the edge.
void PartSplitter::CutEdges() {
  const auto cut = [&](int column, int row, int along_u, int along_v) {
    const int step = along_v * columns_ + along_u;
    const int here = row * columns_ + column;
    const auto fit_at = [&](int outer, int inner) -> const Fit& {
      const Fit& far = fits_[static_cast<size_t>(outer)];
      return far.is_valid ? far : fits_[static_cast<size_t>(inner)];
    };
    const float u = static_cast<float>(kPatch * (column - 1 + along_u)) +
                    (along_u == 1 ? -0.5F : 0.5F * kPatch - 0.5F);
    const float v = static_cast<float>(kPatch * (row - 1 + along_v)) +
                    (along_v == 1 ? -0.5F : 0.5F * kPatch - 0.5F);
    const int last = columns_ * rows_ - 1;
    return IsCut(fit_at(std::max(here - step, 0), here),
                 fit_at(std::min(here + 2 * step, last), here + step),
                 u,
                 v);
  };
  for (int row = 1; row + 1 < rows_; ++row) {
    for (int column = 1; column + 1 < columns_; ++column) {
      const auto i = static_cast<size_t>(row * columns_ + column);
      Patch& patch = patches_[i];
      if (patch.count == 0) continue;
      if (patches_[i + 1].count > 0) patch.cut_right = cut(column, row, 1, 0);
      if (patches_[i + static_cast<size_t>(columns_)].count > 0) {
        patch.cut_down = cut(column, row, 0, 1);
      }
    }
  }
}

// Four patches around a corner belong together when none of their edges is cut.
void PartSplitter::LinkCores() {
  const auto columns = static_cast<size_t>(columns_);
  for (size_t i = 0; i + columns + 1 < patches_.size(); ++i) {
    Patch& patch = patches_[i];
    Patch& right = patches_[i + 1];
    Patch& down = patches_[i + columns];
    const Patch& across = patches_[i + columns + 1];
    if (patch.count == 0 || right.count == 0 || down.count == 0 || across.count == 0) continue;
    if (patch.cut_right || patch.cut_down || down.cut_right || right.cut_down) continue;
    patch.link_right = patch.link_down = true;
    down.link_right = true;
    right.link_down = true;
  }
}

// Numbers the linked patches; small groups are left for others to grow over.
int PartSplitter::FindCores() {
  const auto columns = static_cast<size_t>(columns_);
  int32_t parts = 0;
  constexpr int32_t kTooSmall = -2;
  for (uint32_t seed = 0; seed < patches_.size(); ++seed) {
    if (patches_[seed].part != -1 || !(patches_[seed].link_right || patches_[seed].link_down)) {
      continue;
    }
    queue_.assign(1, seed);
    patches_[seed].part = parts;
    int32_t size = 0;
    for (size_t next = 0; next < queue_.size(); ++next) {
      const size_t i = queue_[next];
      size += patches_[i].count;
      const auto visit = [&](size_t neighbor, bool is_linked) {
        if (!is_linked || patches_[neighbor].part != -1) return;
        patches_[neighbor].part = parts;
        queue_.push_back(static_cast<uint32_t>(neighbor));
      };
      visit(i + 1, patches_[i].link_right);
      visit(i + columns, patches_[i].link_down);
      visit(i - 1, patches_[i - 1].link_right);
      visit(i - columns, patches_[i - columns].link_down);
    }
    if (size >= parameters_.min_points) {
      ++parts;
    } else {
      for (const uint32_t i : queue_) patches_[i].part = kTooSmall;
    }
  }
  for (Patch& patch : patches_) patch.part = std::max(patch.part, -1);
  return parts;
}

// The cores over all other patches, one ring after another.
void PartSplitter::Grow() {
  const int columns = columns_;
  queue_.clear();
  for (uint32_t i = 0; i < patches_.size(); ++i) {
    patches_[i].source = i;
    if (patches_[i].part >= 0) queue_.push_back(i);
  }
  for (size_t next = 0; next < queue_.size(); ++next) {
    const auto i = static_cast<int>(queue_[next]);
    for (const int step :
         {1, columns, -1, -columns, columns + 1, columns - 1, 1 - columns, -1 - columns}) {
      Patch& neighbor = patches_[static_cast<size_t>(i + step)];
      if (neighbor.count == 0 || neighbor.part >= 0) continue;
      neighbor.part = patches_[static_cast<size_t>(i)].part;
      neighbor.source = patches_[static_cast<size_t>(i)].source;
      queue_.push_back(static_cast<uint32_t>(i + step));
    }
  }
}

// Of the parts in and around a patch, the one whose plane passes nearest to a pixel.
int32_t PartSplitter::NearestPlane(uint32_t patch, float u, float v, float rho) const {
  int32_t best = patches_[patch].part;
  const auto error = [&](const Patch& at) {
    const Fit& fit = fits_[at.source];
    return fit.is_valid ? std::abs(fit.a * u + fit.b * v + fit.c - rho)
                        : std::numeric_limits<float>::infinity();
  };
  float nearest = error(patches_[patch]);
  for (const int step : {-1, 1, -columns_, columns_}) {
    const Patch& neighbor = patches_[static_cast<size_t>(static_cast<int>(patch) + step)];
    if (neighbor.part < 0 || neighbor.part == best || !(error(neighbor) < nearest)) continue;
    nearest = error(neighbor);
    best = neighbor.part;
  }
  return best;
}

void PartSplitter::AssignPixels(const DepthImage& depth, std::span<const uint32_t> pixels) {
  parts_.resize(pixels.size());
  const auto width = static_cast<uint32_t>(depth.width);
  uint32_t row = 0;
  uint32_t row_end = 0;
  uint32_t last = 0;
  bool is_inside = false;
  for (size_t i = 0; i < pixels.size(); ++i) {
    if (pixels[i] >= row_end) {
      row = pixels[i] / width;
      row_end = (row + 1) * width;
    }
    const int u = static_cast<int>(pixels[i] + width - row_end) - window_.u0;
    const int v = static_cast<int>(row) - window_.v0;
    const auto patch = static_cast<uint32_t>((v / kPatch + 1) * columns_ + u / kPatch + 1);
    if (patch != last) {
      last = patch;
      is_inside = true;
      for (const int step : {-1, 1, -columns_, columns_}) {
        const Patch& neighbor = patches_[static_cast<size_t>(static_cast<int>(patch) + step)];
        is_inside = is_inside && (neighbor.part < 0 || neighbor.part == patches_[patch].part);
      }
    }
    parts_[i] = is_inside ? patches_[patch].part
                          : NearestPlane(patch,
                                         static_cast<float>(u),
                                         static_cast<float>(v),
                                         1.0F / depth.depth[pixels[i]]);
    parts_[i] = std::max(parts_[i], 0);
  }
}

int PartSplitter::Split(const DepthImage& depth,
                        const CameraModel& camera,
                        std::span<const uint32_t> pixels,
                        const PixelWindow& window) {
  if (parameters_.concave_angle_deg >= 180.0) return 1;
  window_ = window;
  camera_ = camera;
  columns_ = (window.u1 - window.u0) / kPatch + 3;
  rows_ = (window.v1 - window.v0) / kPatch + 3;
  const auto size = static_cast<size_t>(columns_) * static_cast<size_t>(rows_);
  moments_.assign(size, Moments{});
  sums_.assign(size, Moments{});
  fits_.assign(size, Fit{});
  patches_.assign(size, Patch{});
  AddPixels(depth, pixels);
  for (size_t i = 0; i < size; ++i) patches_[i].count = static_cast<int32_t>(moments_[i][0]);
  SumNeighbors();
  FitPlanes(camera);
  CutEdges();
  LinkCores();
  const int parts = FindCores();
  if (parts < 2) return 1;
  Grow();
  AssignPixels(depth, pixels);
  return parts;
}

}  // namespace vantage
