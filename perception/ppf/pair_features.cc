#include "perception/ppf/pair_features.h"

#include <cstring>
#include <numbers>

#include "common/simd.h"
#include "perception/ppf/point_pair_feature.h"

namespace vantage {
namespace {

constexpr float kFarAway = 1e9F;  // m

[[gnu::always_inline]] inline void Load(const float* from, F8* to) {
  std::memcpy(to, from, sizeof(F8));
}

[[gnu::always_inline]] inline void Store(const F8& from, float* to) {
  std::memcpy(to, &from, sizeof(F8));
}

// Newton's steps from the exponent's half; 0 gives something finite.
[[gnu::always_inline]] inline void InverseRoot(const F8& value, F8* root) {
  I8 bits;
  std::memcpy(&bits, &value, sizeof(bits));
  bits = 0x5f3759df - (bits >> 1);
  F8 y;
  std::memcpy(&y, &bits, sizeof(y));
  const F8 half = 0.5F * value;
  for (int i = 0; i < 3; ++i) y = y * (1.5F - half * y * y);
  *root = y;
}

// Abramowitz and Stegun 1964, 4.4.45: to within 7e-5 rad.
[[gnu::always_inline]] inline void ArcCosine(const F8& cosine, F8* angle) {
  F8 x = cosine < 0.0F ? -cosine : cosine;
  x = x > 1.0F ? x * 0.0F + 1.0F : x;
  const F8 rest = 1.0F - x;
  F8 inverse;
  InverseRoot(rest, &inverse);
  const F8 positive =
      rest * inverse * (1.5707288F + x * (-0.2121144F + x * (0.0742610F - 0.0187293F * x)));
  *angle = cosine < 0.0F ? std::numbers::pi_v<float> - positive : positive;
}

// Abramowitz and Stegun 1964, 4.4.49: to within 1e-5 rad.
[[gnu::always_inline]] inline void ArcTangent(const F8& y, const F8& x, F8* angle) {
  const F8 ax = x < 0.0F ? -x : x;
  const F8 ay = y < 0.0F ? -y : y;
  const F8 small = ax < ay ? ax : ay;
  const F8 large = (ax < ay ? ay : ax) + 1e-30F;
  const F8 t = small / large;
  const F8 s = t * t;
  F8 a =
      t * (0.9998660F + s * (-0.3302995F + s * (0.1801410F + s * (-0.0851330F + 0.0208351F * s))));
  a = ax < ay ? 0.5F * std::numbers::pi_v<float> - a : a;
  a = x < 0.0F ? std::numbers::pi_v<float> - a : a;
  *angle = y < 0.0F ? -a : a;
}

}  // namespace

void SurfaceLanes::Clear() {
  size = 0;
  for (std::vector<float>* row : {&x, &y, &z, &normal_x, &normal_y, &normal_z}) row->clear();
}

void SurfaceLanes::Add(const SurfacePoint& point) {
  x.push_back(point.position.x());
  y.push_back(point.position.y());
  z.push_back(point.position.z());
  normal_x.push_back(point.normal.x());
  normal_y.push_back(point.normal.y());
  normal_z.push_back(point.normal.z());
  ++size;
}

void SurfaceLanes::Pad() {
  const size_t real = size;
  while (size % kLanes != 0) {
    Add({Eigen::Vector3f::Constant(kFarAway), Eigen::Vector3f::UnitX()});
  }
  size = real;
}

void SurfaceLanes::Assign(std::span<const SurfacePoint> points) {
  Clear();
  for (const SurfacePoint& point : points) Add(point);
  Pad();
}

SurfacePoint SurfaceLanes::at(size_t i) const {
  return {{x[i], y[i], z[i]}, {normal_x[i], normal_y[i], normal_z[i]}};
}

VANTAGE_SIMD
void ComputePairFeatures(const SurfacePoint& reference,
                         const SurfaceLanes& points,
                         PairFeatures* features) {
  const size_t padded = points.x.size();
  for (std::vector<float>* row : {&features->distance,
                                  &features->angle_normal1,
                                  &features->angle_normal2,
                                  &features->angle_normals,
                                  &features->turn}) {
    row->resize(padded);
  }
  const Eigen::Vector3f& p = reference.position;
  const Eigen::Vector3f& n = reference.normal;
  const Eigen::Matrix3f R = AlignToXAxis(reference).linear();
  for (size_t i = 0; i < padded; i += kLanes) {
    F8 x, y, z, nx, ny, nz;
    Load(&points.x[i], &x);
    Load(&points.y[i], &y);
    Load(&points.z[i], &z);
    Load(&points.normal_x[i], &nx);
    Load(&points.normal_y[i], &ny);
    Load(&points.normal_z[i], &nz);
    x -= p.x();
    y -= p.y();
    z -= p.z();
    const F8 squared = x * x + y * y + z * z;
    F8 inverse;
    InverseRoot(squared, &inverse);
    Store(squared * inverse, &features->distance[i]);
    const F8 none = squared * 0.0F;
    F8 angle;
    ArcCosine((x * n.x() + y * n.y() + z * n.z()) * inverse, &angle);
    Store(squared > 0.0F ? angle : none, &features->angle_normal1[i]);
    ArcCosine((x * nx + y * ny + z * nz) * inverse, &angle);
    Store(squared > 0.0F ? angle : none, &features->angle_normal2[i]);
    ArcCosine(nx * n.x() + ny * n.y() + nz * n.z(), &angle);
    Store(angle, &features->angle_normals[i]);
    const F8 aligned_y = R(1, 0) * x + R(1, 1) * y + R(1, 2) * z;
    const F8 aligned_z = R(2, 0) * x + R(2, 1) * y + R(2, 2) * z;
    ArcTangent(-aligned_z, aligned_y, &angle);
    Store(angle, &features->turn[i]);
  }
}

}  // namespace vantage
