#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "perception/model/generated_shapes.h"
#include "perception/model/mesh_primitives.h"

namespace vantage {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kSegments = 48;  // of round bodies

struct Section {
  double half_x, half_y, z;  // m
};

// A bottle's body of superelliptic sections.
template <size_t kCount>
TriangleMesh Flattened(const std::array<Section, kCount>& sections, double exponent) {
  std::vector<Ring> rings;
  for (const auto& [a, b, z] : sections) {
    rings.push_back(SuperellipseRing(a, b, exponent, z, kSegments));
  }
  return Loft(rings);
}

}  // namespace

// A jug: hollow, waisted, with a lip towards +x and a handle towards -x.
TriangleMesh Pitcher() {
  // Radius, height, and how far the lip stands out there; up the outside, down the inside.
  const std::array<std::array<double, 3>, 19> profile = {{{0.038, 0.000, 0.000},
                                                          {0.042, 0.003, 0.000},
                                                          {0.051, 0.022, 0.000},
                                                          {0.057, 0.045, 0.000},
                                                          {0.058, 0.068, 0.000},
                                                          {0.053, 0.095, 0.000},
                                                          {0.044, 0.120, 0.002},
                                                          {0.041, 0.135, 0.006},
                                                          {0.042, 0.150, 0.013},
                                                          {0.045, 0.164, 0.022},
                                                          {0.0445, 0.167, 0.024},
                                                          {0.042, 0.165, 0.022},
                                                          {0.0385, 0.150, 0.012},
                                                          {0.0375, 0.135, 0.005},
                                                          {0.0405, 0.120, 0.001},
                                                          {0.0495, 0.095, 0.000},
                                                          {0.0545, 0.068, 0.000},
                                                          {0.0535, 0.045, 0.000},
                                                          {0.036, 0.006, 0.000}}};
  std::vector<Ring> rings;
  for (const auto& [radius, height, lip] : profile) {
    // What is lifted at the lip is lifted by half of what stands out.
    Ring ring;
    for (int i = 0; i < 72; ++i) {
      const double angle = 2.0 * kPi * i / 72;
      const double share = lip * std::pow(std::max(0.0, std::cos(angle)), 12.0);
      const double r = radius + share;
      ring.emplace_back(r * std::cos(angle), r * std::sin(angle), height + 0.5 * share);
    }
    rings.push_back(std::move(ring));
  }
  TriangleMesh mesh;
  Append(Loft(rings), Pose::Identity(), &mesh);
  // The handle is a cubic Bezier curve whose ends are inside the wall.
  const std::array<Eigen::Vector3d, 4> control = {Eigen::Vector3d(-0.041, 0.0, 0.153),
                                                  Eigen::Vector3d(-0.122, 0.0, 0.172),
                                                  Eigen::Vector3d(-0.108, 0.0, 0.065),
                                                  Eigen::Vector3d(-0.056, 0.0, 0.056)};
  std::vector<Eigen::Vector3d> path;
  constexpr int kSteps = 24;
  for (int i = 0; i <= kSteps; ++i) {
    const double t = static_cast<double>(i) / kSteps;
    const double s = 1.0 - t;
    path.emplace_back(s * s * s * control[0] + 3.0 * s * s * t * control[1] +
                      3.0 * s * t * t * control[2] + t * t * t * control[3]);
  }
  Append(Rod(path, Eigen::Vector3d::UnitY(), 0.0075, 16), Pose::Identity(), &mesh);
  return mesh;
}

// A flat squeezing bottle with a nozzle; a thumb rest on one narrow side tells the two apart.
TriangleMesh Sauce() {
  const std::array<Section, 11> sections = {{{0.031, 0.018, 0.000},
                                             {0.035, 0.022, 0.004},
                                             {0.037, 0.024, 0.020},
                                             {0.036, 0.023, 0.045},
                                             {0.034, 0.021, 0.070},
                                             {0.036, 0.023, 0.095},
                                             {0.035, 0.023, 0.112},
                                             {0.030, 0.021, 0.126},
                                             {0.022, 0.018, 0.137},
                                             {0.016, 0.015, 0.143},
                                             {0.014, 0.014, 0.145}}};
  TriangleMesh mesh;
  Append(Flattened(sections, 2.5), Pose::Identity(), &mesh);
  const std::array<Eigen::Vector2d, 9> cap = {Eigen::Vector2d(0.0, 0.143),
                                              Eigen::Vector2d(0.016, 0.143),
                                              Eigen::Vector2d(0.018, 0.145),
                                              Eigen::Vector2d(0.018, 0.158),
                                              Eigen::Vector2d(0.015, 0.162),
                                              Eigen::Vector2d(0.009, 0.164),
                                              Eigen::Vector2d(0.005, 0.188),
                                              Eigen::Vector2d(0.004, 0.190),
                                              Eigen::Vector2d(0.0, 0.190)};
  Append(Revolve(cap, kSegments), Pose::Identity(), &mesh);
  Append(Ellipsoid({0.013, 0.011, 0.026}, 32), At(0.033, 0.0, 0.072), &mesh);
  return mesh;
}

// A spray bottle; nozzle and trigger point to +x.
TriangleMesh Spray() {
  const std::array<Section, 10> sections = {{{0.033, 0.025, 0.000},
                                             {0.037, 0.029, 0.004},
                                             {0.038, 0.030, 0.020},
                                             {0.038, 0.030, 0.080},
                                             {0.036, 0.029, 0.100},
                                             {0.030, 0.025, 0.120},
                                             {0.022, 0.020, 0.136},
                                             {0.016, 0.016, 0.148},
                                             {0.0145, 0.0145, 0.154},
                                             {0.0145, 0.0145, 0.160}}};
  TriangleMesh mesh;
  Append(Flattened(sections, 2.3), Pose::Identity(), &mesh);
  Append(Cylinder(0.018, 0.154, 0.174, 0.002, kSegments), Pose::Identity(), &mesh);
  Append(Cylinder(0.012, 0.172, 0.190, 0.001, 32), Pose::Identity(), &mesh);
  // The head lies along x: height, width and place of its sections, and how far they are raised.
  const std::array<std::array<double, 4>, 8> head = {{{0.014, 0.016, -0.040, -0.003},
                                                      {0.022, 0.023, -0.037, -0.001},
                                                      {0.027, 0.026, -0.028, 0.001},
                                                      {0.030, 0.027, -0.005, 0.002},
                                                      {0.028, 0.026, 0.016, 0.002},
                                                      {0.024, 0.023, 0.030, 0.001},
                                                      {0.022, 0.021, 0.036, 0.000},
                                                      {0.018, 0.018, 0.038, 0.000}}};
  std::vector<Ring> rings;
  for (const auto& [height, width, x, raised] : head) {
    Ring ring = RoundedRectangleRing(height, width, 0.3 * std::min(height, width), x, 6);
    for (Eigen::Vector3d& point : ring) point.x() -= raised;
    rings.push_back(std::move(ring));
  }
  // Maps z to x and -x to z.
  const Pose along_x = At(0.0, 0.0, 0.196) * Turned(0.5 * kPi, Eigen::Vector3d::UnitY());
  Append(Loft(rings), along_x, &mesh);
  Append(Cylinder(0.0095, 0.034, 0.055, 0.0015, 24), along_x, &mesh);
  const std::array<Eigen::Vector3d, 6> trigger = {Eigen::Vector3d(0.022, 0.0, 0.190),
                                                  Eigen::Vector3d(0.029, 0.0, 0.178),
                                                  Eigen::Vector3d(0.032, 0.0, 0.164),
                                                  Eigen::Vector3d(0.031, 0.0, 0.150),
                                                  Eigen::Vector3d(0.033, 0.0, 0.138),
                                                  Eigen::Vector3d(0.039, 0.0, 0.127)};
  Append(Rod(trigger, Eigen::Vector3d::UnitY(), 0.0065, 16), Pose::Identity(), &mesh);
  return mesh;
}

}  // namespace vantage
