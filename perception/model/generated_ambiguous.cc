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

// Four arms around a cup; a tab stands in the cup, before one arm.
TriangleMesh Cross() {
  const Profile cup = {{0.0, 0.0},
                       {0.034, 0.0},
                       {0.034, 0.052},
                       {0.032, 0.054},
                       {0.028, 0.054},
                       {0.027, 0.052},
                       {0.027, 0.034},
                       {0.0, 0.034}};
  TriangleMesh mesh = Revolve(cup, kSegments);
  for (int i = 0; i < 4; ++i) {
    const Pose arm = Turned(0.5 * kPi * i, Eigen::Vector3d::UnitZ());
    Append(BeveledBox({0.048, 0.026, 0.030}, 0.002), arm * At(0.054, 0.0, 0.0), &mesh);
  }
  Append(BeveledBox({0.012, 0.012, 0.014}, 0.001), At(0.019, 0.0, 0.032), &mesh);
  return mesh;
}

// A hand wheel of three lobes on its stem; a stub hangs below one of them.
TriangleMesh Valve() {
  const Profile stem = {{0.0, 0.0},
                        {0.042, 0.0},
                        {0.044, 0.002},
                        {0.044, 0.022},
                        {0.042, 0.024},
                        {0.014, 0.026},
                        {0.014, 0.060},
                        {0.0, 0.060}};
  TriangleMesh mesh = Revolve(stem, kSegments);
  Append(LobedPlate(0.050, 0.014, 3, 0.050, 0.070), Pose::Identity(), &mesh);
  Append(Cylinder(0.007, 0.038, 0.054, 0.0015, 24), At(0.032, 0.0, 0.0), &mesh);
  return mesh;
}

// A box with a well in either of its large faces; a stud stands in one of them.
TriangleMesh Brick() {
  const auto ring = [](double inset, double z) {
    return RoundedRectangleRing(0.140 - inset, 0.080 - inset, 0.006, z, 4);
  };
  const std::array<Ring, 6> rings = {ring(0.016, 0.020),
                                     ring(0.016, 0.000),
                                     ring(0.000, 0.000),
                                     ring(0.000, 0.060),
                                     ring(0.016, 0.060),
                                     ring(0.016, 0.040)};
  TriangleMesh mesh = Loft(rings);
  Append(Cylinder(0.009, 0.036, 0.054, 0.0015, 24), At(0.034, 0.010, 0.0), &mesh);
  return mesh;
}

// A flat socket; a key's rib stands in it, at one of its narrow sides.
TriangleMesh Plug() {
  std::vector<Ring> rings;
  const std::array<std::array<double, 3>, 7> sections = {{{0.038, 0.024, 0.000},
                                                          {0.040, 0.026, 0.002},
                                                          {0.040, 0.026, 0.078},
                                                          {0.038, 0.024, 0.080},
                                                          {0.034, 0.020, 0.080},
                                                          {0.033, 0.019, 0.078},
                                                          {0.033, 0.019, 0.056}}};
  for (const auto& [a, b, z] : sections) rings.push_back(SuperellipseRing(a, b, 2.6, z, kSegments));
  TriangleMesh mesh = Loft(rings);
  Append(BeveledBox({0.016, 0.012, 0.018}, 0.001), At(0.020, 0.0, 0.052), &mesh);
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

// A dish of five points; a block stands before one of them.
TriangleMesh Star() {
  const auto star = [](double inset, double z) {
    return PolarRing(
        [=](double angle) {
          // Straight sides from the points at 0, 72 ... degrees to the corners between them.
          const double turned = std::remainder(angle, 0.4 * kPi);
          const double share = std::abs(turned) / (0.2 * kPi);
          return 1.0 / ((1.0 - share) / 0.070 + share / 0.042) - inset;
        },
        z,
        120);
  };
  const std::array<Ring, 6> rings = {star(0.002, 0.000),
                                     star(0.000, 0.002),
                                     star(0.000, 0.038),
                                     star(0.002, 0.040),
                                     star(0.008, 0.040),
                                     star(0.008, 0.022)};
  TriangleMesh mesh = Loft(rings);
  Append(BeveledBox({0.014, 0.012, 0.016}, 0.001), At(0.024, 0.0, 0.018), &mesh);
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
