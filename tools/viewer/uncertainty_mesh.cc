#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "tools/viewer/viewer_scene.h"

namespace vantage {
namespace {

constexpr uint32_t kAround = 24;  // Corners of a circle.
constexpr uint32_t kRings = 12;   // From pole to pole.

// Columns: the principal axes, each as long as its standard deviation.
Eigen::Matrix3d PrincipalAxes(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  return solver.eigenvectors() *
         solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal().toDenseMatrix();
}

Eigen::Matrix3d Cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return matrix;
}

}  // namespace

TriangleMesh EllipsoidMesh(const Eigen::Vector3d& center,
                           const Eigen::Matrix3d& covariance,
                           double sigmas) {
  const Eigen::Matrix3d axes = sigmas * PrincipalAxes(covariance);
  TriangleMesh mesh;
  for (uint32_t ring = 0; ring <= kRings; ++ring) {
    const double polar = std::numbers::pi * ring / kRings;
    for (uint32_t i = 0; i < kAround; ++i) {
      const double around = 2.0 * std::numbers::pi * i / kAround;
      const Eigen::Vector3d unit(
          std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around), std::cos(polar));
      mesh.vertices.push_back((center + axes * unit).cast<float>());
    }
  }
  for (uint32_t ring = 0; ring < kRings; ++ring) {
    for (uint32_t i = 0; i < kAround; ++i) {
      const uint32_t a = ring * kAround + i;
      const uint32_t b = ring * kAround + (i + 1) % kAround;
      mesh.triangles.push_back({a, a + kAround, b});
      mesh.triangles.push_back({b, a + kAround, b + kAround});
    }
  }
  return mesh;
}

TriangleMesh AxisConeMesh(const Eigen::Vector3d& center,
                          const Eigen::Vector3d& arm,
                          const Eigen::Matrix3d& covariance,
                          double sigmas) {
  // The tip moves by r x arm, of covariance [arm] C [arm]^T: flat, across the arm.
  const Eigen::Matrix3d tip = Cross(arm) * covariance * Cross(arm).transpose();
  const Eigen::Matrix3d axes = sigmas * PrincipalAxes(tip);
  TriangleMesh mesh;
  mesh.vertices.push_back(center.cast<float>());
  mesh.vertices.push_back((center + arm).cast<float>());
  for (uint32_t i = 0; i < kAround; ++i) {
    const double around = 2.0 * std::numbers::pi * i / kAround;
    // The eigenvalues ascend, so that the last two axes span the ellipse. Turned by more than a
    // right angle the tip's way is no straight line: it stays on the arm's sphere.
    const Eigen::Vector3d to =
        arm + std::cos(around) * axes.col(1) + std::sin(around) * axes.col(2);
    mesh.vertices.push_back((center + arm.norm() * to.normalized()).cast<float>());
  }
  for (uint32_t i = 0; i < kAround; ++i) {
    const uint32_t a = 2 + i;
    const uint32_t b = 2 + (i + 1) % kAround;
    mesh.triangles.push_back({0, a, b});
    mesh.triangles.push_back({1, b, a});
  }
  return mesh;
}

}  // namespace vantage
