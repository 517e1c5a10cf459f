#include "perception/ppf/point_pair_feature.h"

#include <algorithm>
#include <cmath>

namespace vantage {
namespace {

float AngleFromCosine(float cosine) { return std::acos(std::clamp(cosine, -1.0F, 1.0F)); }

}  // namespace

PointPairFeature ComputePointPairFeature(const SurfacePoint& first, const SurfacePoint& second) {
  PointPairFeature feature;
  const Eigen::Vector3f d = second.position - first.position;
  feature.distance = d.norm();
  feature.angle_normals = AngleFromCosine(first.normal.dot(second.normal));
  if (feature.distance > 0.0F) {
    const float inverse = 1.0F / feature.distance;
    feature.angle_normal1 = AngleFromCosine(first.normal.dot(d) * inverse);
    feature.angle_normal2 = AngleFromCosine(second.normal.dot(d) * inverse);
  }
  return feature;
}

Eigen::Isometry3f AlignToXAxis(const SurfacePoint& point) {
  // Shortest rotation of the normal onto x; about y by half a turn when they are opposite.
  const Eigen::Vector3f& n = point.normal;
  Eigen::Isometry3f T = Eigen::Isometry3f::Identity();
  const float c = n.x();
  if (c < -0.99999F) {
    T.linear() = Eigen::Vector3f(-1.0F, 1.0F, -1.0F).asDiagonal();
  } else {
    const Eigen::Vector3f axis(0.0F, n.z(), -n.y());  // n x e_x
    Eigen::Matrix3f cross;
    cross << 0.0F, -axis.z(), axis.y(), axis.z(), 0.0F, -axis.x(), -axis.y(), axis.x(), 0.0F;
    T.linear() = Eigen::Matrix3f::Identity() + cross + cross * cross / (1.0F + c);
  }
  T.translation() = -(T.linear() * point.position);
  return T;
}

float AngleAboutX(const Eigen::Isometry3f& T_aligned, const Eigen::Vector3f& other) {
  const float y = T_aligned.linear().row(1).dot(other) + T_aligned.translation().y();
  const float z = T_aligned.linear().row(2).dot(other) + T_aligned.translation().z();
  return std::atan2(-z, y);
}

}  // namespace vantage
