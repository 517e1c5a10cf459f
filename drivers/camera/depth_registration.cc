#include "drivers/camera/depth_registration.h"

#include <algorithm>
#include <cstring>

#include "common/check.h"
#include "common/simd.h"

namespace vantage {
namespace {

constexpr float kFar = RayProjection::kFar;
// Neighbors whose depths differ by more, relatively, are not of one surface: seen under less than 5
// degrees at 570 px of focal length.
constexpr float kLargestStep = 0.02F;
constexpr float kMargin = 0.05F;          // px, by which pieces overlap, against gaps from noise
constexpr float kLargestSpacing = 16.0F;  // px
constexpr uint16_t kNothing = 0xffff;     // Of the image while it is drawn.

// A row of pixels in the color image.
struct Pixels {
  const float* u;  // px
  const float* v;  // px
  const float* z;  // mm
};

struct PieceArrays {
  int32_t* u0;
  int32_t* v0;
  int32_t* u1;
  int32_t* v1;
  float* z;
  float* z_u;
  float* z_v;
};

// Eight pixels, or how they differ from eight others.
struct Pixel8 {
  F8 u, v, z;
};

[[gnu::always_inline]] inline void Load(const Pixels& pixels, int i, Pixel8* pixel) {
  std::memcpy(&pixel->u, pixels.u + i, sizeof(F8));
  std::memcpy(&pixel->v, pixels.v + i, sizeof(F8));
  std::memcpy(&pixel->z, pixels.z + i, sizeof(F8));
}
[[gnu::always_inline]] inline void Store(const F8& value, float* at) {
  std::memcpy(at, &value, sizeof(F8));
}
// Rounded towards 0.
[[gnu::always_inline]] inline void Truncate(const F8& value, I8* truncated) {
  *truncated = __builtin_convertvector(value, I8);
}
// NaN becomes `lowest`.
[[gnu::always_inline]] inline void Clamp(const F8& lowest, const F8& highest, F8* value) {
  *value = *value > lowest ? *value : lowest;
  *value = *value < highest ? *value : highest;
}
[[gnu::always_inline]] inline void Abs(const F8& value, F8* absolute) {
  *absolute = value < 0.0F ? -value : value;
}

// How place and depth change from a pixel to the next one along a row or a column: by the neighbor
// that is nearer in depth, and as `*step` has it where neither is of one surface with it.
[[gnu::always_inline]] inline void FindStep(
    const Pixels& before, const Pixel8& here, const Pixels& after, int i, Pixel8* step) {
  Pixel8 from;
  Pixel8 to;
  Load(before, i, &from);
  Load(after, i, &to);
  F8 distance_from;
  F8 distance_to;
  Abs(here.z - from.z, &distance_from);
  Abs(to.z - here.z, &distance_to);
  const I8 is_to = distance_to < distance_from;
  const F8 distance = is_to ? distance_to : distance_from;
  const I8 is_one_surface = distance < kLargestStep * here.z;
  step->u = is_one_surface ? (is_to ? to.u - here.u : here.u - from.u) : step->u;
  step->v = is_one_surface ? (is_to ? to.v - here.v : here.v - from.v) : step->v;
  step->z = is_one_surface ? (is_to ? to.z - here.z : here.z - from.z) : step->z;
}

// The whole pixels within `half` of `center`, from 0 to size - 1: first > last where there is none.
// -1 to `size` is positive once 2^15 or 1 is added or subtracted from, so that truncating rounds.
[[gnu::always_inline]] inline void FindRange(
    const F8& center, const F8& half, float size, I8* first, I8* last) {
  const F8 before = F8{} - 1.0F;
  F8 begin = center - half;
  Clamp(before, F8{} + size, &begin);
  Truncate(32768.0F - begin, first);
  *first = 32768 - *first;
  *first = *first > 0 ? *first : I8{};
  F8 end = center + half;
  Clamp(before, F8{} + (size - 1.0F), &end);
  Truncate(end + 1.0F, last);
  *last -= 1;
}

// `here` lies between `left` and `right`, and between `above` and `below`.
struct Neighborhood {
  Pixels left, right, above, below, here;
};

VANTAGE_SIMD void FindPiecesOfRow(const Neighborhood& pixels,
                                  int count,
                                  const CameraModel& color,
                                  float spacing,
                                  const PieceArrays& pieces) {
  const F8 least = F8{} + spacing;
  for (int i = 0; i < count; i += kLanes) {
    Pixel8 here;
    Load(pixels.here, i, &here);
    Pixel8 along{.u = least, .v = {}, .z = {}};
    Pixel8 down{.u = {}, .v = least, .z = {}};
    FindStep(pixels.left, here, pixels.right, i, &along);
    FindStep(pixels.above, here, pixels.below, i, &down);
    // The depth's slope in the color image: (z_u z_v) J = (along.z down.z).
    const F8 determinant = along.u * down.v - down.u * along.v;
    F8 area;
    Abs(determinant, &area);
    const I8 is_open = area > 0.25F * spacing * spacing;
    const F8 inverse = 1.0F / (is_open ? determinant : F8{} + 1.0F);
    const F8 z_u = is_open ? (along.z * down.v - down.z * along.v) * inverse : F8{};
    const F8 z_v = is_open ? (down.z * along.u - along.z * down.u) * inverse : F8{};
    F8 along_u, along_v, down_u, down_v;
    Abs(along.u, &along_u);
    Abs(along.v, &along_v);
    Abs(down.u, &down_u);
    Abs(down.v, &down_v);
    F8 width = along_u + down_u;
    F8 height = along_v + down_v;
    Clamp(least, least + least, &width);
    Clamp(least, least + least, &height);
    I8 u0, u1, v0, v1;
    FindRange(here.u, 0.5F * width + kMargin, static_cast<float>(color.width), &u0, &u1);
    FindRange(here.v, 0.5F * height + kMargin, static_cast<float>(color.height), &v0, &v1);
    u1 = here.z < kFar ? u1 : I8{} - 1;
    F8 z = here.z + z_u * (__builtin_convertvector(u0, F8) - here.u) +
           z_v * (__builtin_convertvector(v0, F8) - here.v);
    Clamp((1.0F - kLargestStep) * here.z, (1.0F + kLargestStep) * here.z, &z);
    std::memcpy(pieces.u0 + i, &u0, sizeof(I8));
    std::memcpy(pieces.v0 + i, &v0, sizeof(I8));
    std::memcpy(pieces.u1 + i, &u1, sizeof(I8));
    std::memcpy(pieces.v1 + i, &v1, sizeof(I8));
    Store(z, pieces.z + i);
    Store(z_u, pieces.z_u + i);
    Store(z_v, pieces.z_v + i);
  }
}

// 0 where nothing was drawn.
void ClearNothing(std::vector<uint16_t>* image) {
  for (uint16_t& value : *image) value = value == kNothing ? uint16_t{0} : value;
}

// Whole mm; depths beyond what the image holds become kNothing, as those that are not positive.
[[gnu::always_inline]] inline uint16_t Millimetres(float z) {
  const int32_t rounded = static_cast<int32_t>(z + 0.5F);
  return static_cast<uint16_t>(rounded >= 1 && rounded < kNothing ? rounded : kNothing);
}

}  // namespace

DepthRegistration::DepthRegistration(const CameraIntrinsics& depth,
                                     const CameraModel& color,
                                     const Pose& T_color_depth)
    : color_(color), projection_(depth, color, T_color_depth) {
  const double spacing = std::max(color.fx / depth.camera.fx, color.fy / depth.camera.fy);
  spacing_ = std::min(static_cast<float>(spacing), kLargestSpacing);
  const size_t size = projection_.stride();
  for (Row& row : rows_) {
    row.u.assign(size + 2, 0.0F);
    row.v.assign(size + 2, 0.0F);
    row.z.assign(size + 2, kFar);
  }
  for (auto* values : {&pieces_.u0, &pieces_.v0, &pieces_.u1, &pieces_.v1}) values->resize(size);
  for (auto* values : {&pieces_.z, &pieces_.z_u, &pieces_.z_v}) values->resize(size);
}

void DepthRegistration::Register(std::span<const uint16_t> depth_mm,
                                 std::vector<uint16_t>* registered) {
  const int height = projection_.height();
  VANTAGE_CHECK(
      depth_mm.size() == static_cast<size_t>(projection_.width()) * static_cast<size_t>(height),
      "a depth image of another size");
  registered->assign(static_cast<size_t>(color_.width) * static_cast<size_t>(color_.height),
                     kNothing);
  std::ranges::fill(rows_[2].z, kFar);  // Above the first row.
  ProjectRow(depth_mm, 0);
  for (int row = 0; row < height; ++row) {
    if (row + 1 < height) {
      ProjectRow(depth_mm, row + 1);
    } else {
      std::ranges::fill(rows_[static_cast<size_t>(row + 1) % 3].z, kFar);
    }
    FindPieces(row);
    Draw(registered->data());
  }
  ClearNothing(registered);
}

void DepthRegistration::ProjectRow(std::span<const uint16_t> depth_mm, int row) {
  Row& place = rows_[static_cast<size_t>(row) % 3];
  projection_.ProjectRow(
      row,
      &depth_mm[static_cast<size_t>(row) * static_cast<size_t>(projection_.width())],
      &place.u[1],
      &place.v[1],
      &place.z[1]);
}

void DepthRegistration::FindPieces(int row) {
  const auto at = [](const Row& place, size_t first) {
    return Pixels{&place.u[first], &place.v[first], &place.z[first]};
  };
  const Row& above = rows_[static_cast<size_t>(row + 2) % 3];
  const Row& here = rows_[static_cast<size_t>(row) % 3];
  const Row& below = rows_[static_cast<size_t>(row + 1) % 3];
  FindPiecesOfRow({at(here, 0), at(here, 2), at(above, 1), at(below, 1), at(here, 1)},
                  projection_.width(),
                  color_,
                  spacing_,
                  {pieces_.u0.data(),
                   pieces_.v0.data(),
                   pieces_.u1.data(),
                   pieces_.v1.data(),
                   pieces_.z.data(),
                   pieces_.z_u.data(),
                   pieces_.z_v.data()});
}

void DepthRegistration::Draw(uint16_t* image) const {
  const size_t width = static_cast<size_t>(color_.width);
  const size_t count = static_cast<size_t>(projection_.width());
  for (size_t i = 0; i < count; ++i) {
    const int32_t u0 = pieces_.u0[i];
    const int32_t v0 = pieces_.v0[i];
    const int32_t u1 = pieces_.u1[i];
    const int32_t v1 = pieces_.v1[i];
    if (u1 < u0 || v1 < v0) continue;
    uint16_t* first = image + static_cast<size_t>(v0) * width + static_cast<size_t>(u0);
    *first = std::min(*first, Millimetres(pieces_.z[i]));
    if (u0 == u1 && v0 == v1) continue;
    for (int32_t v = v0; v <= v1; ++v, first += width) {
      float z = pieces_.z[i] + static_cast<float>(v - v0) * pieces_.z_v[i];
      for (int32_t u = u0; u <= u1; ++u, z += pieces_.z_u[i]) {
        first[u - u0] = std::min(first[u - u0], Millimetres(z));
      }
    }
  }
}

}  // namespace vantage
