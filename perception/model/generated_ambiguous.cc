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
constexpr int kSegments = 60;  // of round bodies; a multiple of 2, 3, 4, 5 and 6

using Profile = std::vector<Eigen::Vector2d>;

// A plate of `lobes` lobes, its edges beveled: radius + depth cos(lobes angle), m.
TriangleMesh LobedPlate(double radius, double depth, int lobes, double z0, double z1) {
  const auto ring = [=](double inset, double z) {
    return PolarRing(
        [=](double angle) { return radius + depth * std::cos(lobes * angle) - inset; }, z, 120);
  };
  constexpr double kBevel = 0.002;
  const std::array<Ring, 4> rings = {
      ring(kBevel, z0), ring(0.0, z0 + kBevel), ring(0.0, z1 - kBevel), ring(kBevel, z1)};
  return Loft(rings);
}

}  // namespace

// A scalloped plate with a hub on it; a lug stands between two of its six lobes.
TriangleMesh Flange() {
  TriangleMesh mesh = LobedPlate(0.060, 0.006, 6, 0.0, 0.016);
  Append(Cylinder(0.026, 0.012, 0.056, 0.002, kSegments), Pose::Identity(), &mesh);
  Append(BeveledBox({0.016, 0.012, 0.020}, 0.0015), At(0.044, 0.0, 0.012), &mesh);
  return mesh;
}

// Four arms and a pin in their middle; one arm has a tab on its side.
TriangleMesh Cross() {
  TriangleMesh mesh = BeveledBox({0.150, 0.030, 0.034}, 0.002);
  Append(BeveledBox({0.030, 0.150, 0.034}, 0.002), Pose::Identity(), &mesh);
  Append(Cylinder(0.012, 0.030, 0.060, 0.0015, 36), Pose::Identity(), &mesh);
  Append(BeveledBox({0.014, 0.016, 0.016}, 0.0015), At(0.058, 0.021, 0.0), &mesh);
  return mesh;
}

// A hand wheel of three lobes on its stem; a stub hangs below one of them.
TriangleMesh Valve() {
  const Profile stem = {{0.0, 0.0},
                        {0.030, 0.0},
                        {0.032, 0.002},
                        {0.032, 0.012},
                        {0.016, 0.018},
                        {0.016, 0.060},
                        {0.0, 0.060}};
  TriangleMesh mesh = Revolve(stem, kSegments);
  Append(LobedPlate(0.050, 0.014, 3, 0.050, 0.070), Pose::Identity(), &mesh);
  Append(Cylinder(0.008, 0.034, 0.054, 0.0015, 24), At(0.046, 0.0, 0.0), &mesh);
  return mesh;
}

// A box with a stud near a corner of one of its large faces.
TriangleMesh Brick() {
  TriangleMesh mesh = BeveledBox({0.140, 0.076, 0.050}, 0.002);
  Append(Cylinder(0.009, 0.046, 0.064, 0.0015, 24), At(0.050, 0.022, 0.0), &mesh);
  return mesh;
}

// A flat plug with a grip; a key's rib is low on one of its narrow sides.
TriangleMesh Plug() {
  std::vector<Ring> rings;
  const std::array<std::array<double, 3>, 8> sections = {{{0.036, 0.022, 0.000},
                                                          {0.038, 0.024, 0.002},
                                                          {0.038, 0.024, 0.060},
                                                          {0.036, 0.022, 0.064},
                                                          {0.024, 0.013, 0.068},
                                                          {0.024, 0.013, 0.096},
                                                          {0.022, 0.012, 0.100},
                                                          {0.016, 0.009, 0.102}}};
  for (const auto& [a, b, z] : sections) rings.push_back(SuperellipseRing(a, b, 2.6, z, kSegments));
  TriangleMesh mesh = Loft(rings);
  Append(BeveledBox({0.018, 0.012, 0.026}, 0.0015), At(0.041, 0.0, 0.006), &mesh);
  return mesh;
}

// A cap on a stem; the pointer is on the underside.
TriangleMesh Knob() {
  const Profile profile = {{0.0, 0.0},
                           {0.022, 0.0},
                           {0.024, 0.002},
                           {0.024, 0.048},
                           {0.056, 0.052},
                           {0.060, 0.056},
                           {0.060, 0.070},
                           {0.054, 0.078},
                           {0.036, 0.084},
                           {0.0, 0.086}};
  TriangleMesh mesh = Revolve(profile, 72);
  Append(BeveledBox({0.022, 0.010, 0.018}, 0.0015), At(0.044, 0.0, 0.036), &mesh);
  return mesh;
}

// A dome with a spout low on its side.
TriangleMesh Cap() {
  const Profile profile = {{0.0, 0.0},
                           {0.050, 0.0},
                           {0.052, 0.002},
                           {0.052, 0.040},
                           {0.048, 0.056},
                           {0.038, 0.068},
                           {0.022, 0.076},
                           {0.0, 0.079}};
  TriangleMesh mesh = Revolve(profile, 72);
  Append(Cylinder(0.008, 0.040, 0.066, 0.0015, 24),
         At(0.0, 0.0, 0.014) * Turned(0.5 * kPi, Eigen::Vector3d::UnitY()),
         &mesh);
  return mesh;
}

// Five points around a pin; a step is cut into the upper side of one of them.
TriangleMesh Star() {
  const auto star = [](double inset, bool is_cut, double z) {
    return PolarRing(
        [=](double angle) {
          // Straight sides from the points at 0, 72 ... degrees to the corners between them.
          const double turned = std::remainder(angle, 0.4 * kPi);
          const double share = std::abs(turned) / (0.2 * kPi);
          const double radius = 1.0 / ((1.0 - share) / 0.068 + share / 0.034);
          const bool is_first = std::abs(std::remainder(angle, 2.0 * kPi)) < 0.2 * kPi;
          return (is_cut && is_first ? std::min(radius, 0.044) : radius) - inset;
        },
        z,
        120);
  };
  const std::array<Ring, 6> rings = {star(0.002, false, 0.000),
                                     star(0.000, false, 0.002),
                                     star(0.000, false, 0.014),
                                     star(0.000, true, 0.0145),
                                     star(0.000, true, 0.028),
                                     star(0.002, true, 0.030)};
  TriangleMesh mesh = Loft(rings);
  Append(Cylinder(0.014, 0.026, 0.056, 0.002, kSegments), Pose::Identity(), &mesh);
  return mesh;
}

// A hexagonal prism with a tab on one of its sides.
TriangleMesh Nut() {
  const auto hexagon = [](double inset, double z) {
    return PolarRing(
        [=](double angle) {
          const double turned = std::remainder(angle - kPi / 6.0, kPi / 3.0);
          return (0.048 - inset) / std::cos(turned);
        },
        z,
        60);
  };
  const std::array<Ring, 4> rings = {
      hexagon(0.003, 0.0), hexagon(0.0, 0.003), hexagon(0.0, 0.057), hexagon(0.003, 0.060)};
  TriangleMesh mesh = Loft(rings);
  const Pose side = Turned(kPi / 6.0, Eigen::Vector3d::UnitZ());
  Append(BeveledBox({0.020, 0.014, 0.014}, 0.0015), side * At(0.052, 0.0, 0.040), &mesh);
  return mesh;
}

// Two equal rims on a core; a pin stands on one rim.
TriangleMesh Reel() {
  const Profile profile = {{0.0, 0.0},
                           {0.048, 0.0},
                           {0.050, 0.002},
                           {0.050, 0.012},
                           {0.048, 0.014},
                           {0.026, 0.016},
                           {0.026, 0.084},
                           {0.048, 0.086},
                           {0.050, 0.088},
                           {0.050, 0.098},
                           {0.048, 0.100},
                           {0.0, 0.100}};
  TriangleMesh mesh = Revolve(profile, 72);
  Append(Cylinder(0.008, 0.096, 0.116, 0.0015, 24), At(0.036, 0.0, 0.0), &mesh);
  return mesh;
}

}  // namespace vantage
