#include <cmath>
#include <numbers>
#include <vector>

#include "perception/model/generated_shapes.h"
#include "perception/model/implicit_solid.h"
#include "perception/model/mesh_primitives.h"

namespace vantage {
namespace {

constexpr double kCell = 0.005;  // m, of the grid that figures are meshed on

// A place on the left side, or its mirror image on the right one.
Eigen::Vector3d Sided(double side, double x, double y, double z) { return {x, side * y, z}; }

}  // namespace

// Sits upright, looks over its left shoulder, its tail around its right side.
TriangleMesh Cat() {
  ImplicitSolid solid;
  solid.AddLimb({{{-0.020, 0.0, 0.036}, 0.036},
                 {{-0.006, 0.0, 0.062}, 0.032},
                 {{0.010, 0.0, 0.088}, 0.025},
                 {{0.014, 0.0, 0.108}, 0.019}},
                0.0);
  for (const double side : {1.0, -1.0}) {
    // Haunch, hind paw, front leg with its paw.
    solid.AddEllipsoid(At(-0.006, side * 0.030, 0.030), {0.030, 0.015, 0.030}, 0.006);
    solid.AddLimb(
        {{Sided(side, 0.008, 0.036, 0.008), 0.011}, {Sided(side, 0.028, 0.036, 0.007), 0.0105}},
        0.006);
    solid.AddLimb({{Sided(side, 0.018, 0.016, 0.080), 0.013},
                   {Sided(side, 0.030, 0.015, 0.014), 0.0105},
                   {Sided(side, 0.042, 0.015, 0.007), 0.010}},
                  0.008);
  }
  const Pose head = At(0.022, 0.004, 0.130) * Turned(0.7, Eigen::Vector3d::UnitZ());
  solid.AddEllipsoid(head, {0.025, 0.030, 0.024}, 0.008);
  solid.AddEllipsoid(head * At(0.021, 0.0, -0.008), {0.013, 0.015, 0.010}, 0.006);
  for (const double side : {1.0, -1.0}) {
    solid.AddLimb({{head * Sided(side, -0.002, 0.017, 0.014), 0.011},
                   {head * Sided(side, -0.006, 0.024, 0.035), 0.005}},
                  0.003);
  }
  solid.AddLimb({{{-0.046, 0.002, 0.012}, 0.010},
                 {{-0.052, -0.020, 0.010}, 0.010},
                 {{-0.040, -0.040, 0.009}, 0.010},
                 {{-0.014, -0.050, 0.009}, 0.010},
                 {{0.012, -0.053, 0.009}, 0.010},
                 {{0.036, -0.052, 0.009}, 0.009}},
                0.006);
  return solid.Polygonize(kCell);
}

// A garden gnome with a beard and a bent hat; waves with its right hand.
TriangleMesh Dwarf() {
  ImplicitSolid solid;
  solid.AddLimb(
      {{{0.0, 0.0, 0.034}, 0.031}, {{0.002, 0.0, 0.060}, 0.036}, {{0.0, 0.0, 0.096}, 0.026}}, 0.0);
  for (const double side : {1.0, -1.0}) {
    solid.AddEllipsoid(At(0.016, side * 0.021, 0.009), {0.028, 0.016, 0.015}, 0.004);
  }
  // The left hand on the belly, the right one raised.
  solid.AddLimb({{{0.0, 0.026, 0.100}, 0.014},
                 {{0.002, 0.046, 0.074}, 0.012},
                 {{0.032, 0.028, 0.062}, 0.011}},
                0.004);
  solid.AddLimb({{{0.0, -0.026, 0.100}, 0.014},
                 {{0.004, -0.054, 0.096}, 0.012},
                 {{0.010, -0.064, 0.130}, 0.012}},
                0.004);
  solid.AddLimb({{{0.004, 0.0, 0.122}, 0.027}}, 0.006);
  solid.AddLimb(
      {{{0.020, 0.0, 0.110}, 0.020}, {{0.034, 0.0, 0.086}, 0.014}, {{0.040, 0.0, 0.068}, 0.006}},
      0.004);
  // The hat and its brim.
  solid.AddLimb({{{0.000, 0.0, 0.143}, 0.027},
                 {{-0.005, 0.0, 0.176}, 0.014},
                 {{-0.016, 0.008, 0.200}, 0.006}},
                0.003);
  std::vector<Ball> brim;
  for (int i = 0; i <= 16; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 16;
    brim.push_back({{0.029 * std::cos(angle), 0.029 * std::sin(angle), 0.141}, 0.0085});
  }
  solid.AddLimb(brim, 0.004);
  TriangleMesh mesh = solid.Polygonize(kCell);
  Append(Ellipsoid({0.010, 0.010, 0.009}, 24), At(0.034, 0.0, 0.122), &mesh);  // nose
  return mesh;
}

// A goldfish that stands on its flattened belly.
TriangleMesh Fish() {
  ImplicitSolid solid;
  solid.AddEllipsoid(At(0.016, 0.0, 0.040), {0.060, 0.030, 0.044}, 0.0);
  solid.AddLimb({{{-0.022, 0.0, 0.044}, 0.024}, {{-0.066, 0.0, 0.050}, 0.011}}, 0.020);
  // Tail fin of two lobes, back fin, fin under the tail, side fins.
  const auto up = [](double angle) { return Turned(-angle, Eigen::Vector3d::UnitY()); };
  solid.AddEllipsoid(At(-0.086, 0.0, 0.072) * up(-0.8), {0.034, 0.0065, 0.014}, 0.006);
  solid.AddEllipsoid(At(-0.086, 0.0, 0.034) * up(0.7), {0.032, 0.0065, 0.014}, 0.006);
  solid.AddEllipsoid(At(0.002, 0.0, 0.082) * up(0.25), {0.036, 0.0065, 0.020}, 0.006);
  solid.AddEllipsoid(At(-0.036, 0.0, 0.018) * up(0.7), {0.020, 0.006, 0.010}, 0.005);
  for (const double side : {1.0, -1.0}) {
    const Pose fin = At(0.014, side * 0.036, 0.034) *
                     Turned(-side * 0.6, Eigen::Vector3d::UnitZ()) *
                     Turned(0.5, Eigen::Vector3d::UnitY());
    solid.AddEllipsoid(fin, {0.022, 0.006, 0.012}, 0.004);
  }
  // Lips.
  solid.AddLimb({{{0.068, 0.0, 0.040}, 0.012}, {{0.077, 0.0, 0.043}, 0.008}}, 0.008);
  TriangleMesh mesh = solid.Polygonize(kCell);
  for (const double side : {1.0, -1.0}) {
    Append(Ellipsoid({0.009, 0.007, 0.009}, 24), At(0.052, side * 0.021, 0.054), &mesh);  // eye
  }
  return mesh;
}

// Stands on four legs and looks a little to its left.
TriangleMesh Pony() {
  ImplicitSolid solid;
  solid.AddLimb({{{-0.0377, 0.0, 0.0754}, 0.0246},
                 {{0.0, 0.0, 0.0705}, 0.023},
                 {{0.0344, 0.0, 0.0738}, 0.0246}},
                0.0);
  for (const double side : {1.0, -1.0}) {
    solid.AddLimb({{Sided(side, -0.0426, 0.0131, 0.0672), 0.0172},
                   {Sided(side, -0.0492, 0.0172, 0.0377), 0.0094},
                   {Sided(side, -0.0459, 0.0172, 0.0049), 0.0103}},
                  0.0066);
    solid.AddLimb({{Sided(side, 0.041, 0.0131, 0.064), 0.0148},
                   {Sided(side, 0.0435, 0.0164, 0.0361), 0.0086},
                   {Sided(side, 0.0435, 0.0164, 0.0049), 0.0103}},
                  0.0066);
  }
  solid.AddLimb({{{0.0426, 0.0, 0.082}, 0.0205}, {{0.0689, 0.0016, 0.1197}, 0.0148}}, 0.0098);
  solid.AddLimb({{{0.0705, 0.0025, 0.1255}, 0.0156},
                 {{0.0951, 0.0164, 0.1082}, 0.0115},
                 {{0.1017, 0.0205, 0.1041}, 0.0107}},
                0.0066);
  for (const double side : {1.0, -1.0}) {
    solid.AddLimb({{{0.0648 - side * 0.0041, side * 0.009, 0.1361}, 0.0057},
                   {{0.064 - side * 0.0049, side * 0.0115, 0.1501}, 0.0029}},
                  0.0025);
  }
  // Mane and tail.
  solid.AddLimb({{{0.0262, 0.0, 0.1}, 0.0066},
                 {{0.0377, 0.0, 0.1148}, 0.0082},
                 {{0.0541, 0.0008, 0.1353}, 0.0082},
                 {{0.0722, 0.0033, 0.1427}, 0.0066}},
                0.0033);
  solid.AddLimb({{{-0.059, 0.0, 0.0853}, 0.0074},
                 {{-0.0754, 0.0, 0.0771}, 0.009},
                 {{-0.082, 0.0, 0.0492}, 0.0107},
                 {{-0.0804, 0.0, 0.0262}, 0.0049}},
                0.0033);
  return solid.Polygonize(kCell);
}

// Lies on the flat side of its shell; the same left and right.
TriangleMesh Turtle() {
  ImplicitSolid solid;
  solid.AddEllipsoid(At(-0.004, 0.0, 0.018), {0.058, 0.048, 0.038}, 0.0);
  solid.AddEllipsoid(At(-0.004, 0.0, 0.016), {0.066, 0.055, 0.013}, 0.006);
  // Scutes: one on top, six around.
  solid.AddEllipsoid(At(-0.004, 0.0, 0.050), {0.018, 0.016, 0.010}, 0.004);
  for (const double side : {1.0, -1.0}) {
    for (const double x : {0.026, -0.004, -0.034}) {
      solid.AddEllipsoid(
          At(x, side * (x == -0.004 ? 0.032 : 0.024), 0.036), {0.014, 0.014, 0.011}, 0.005);
    }
    solid.AddLimb({{Sided(side, 0.036, 0.034, 0.014), 0.013},
                   {Sided(side, 0.056, 0.054, 0.010), 0.012},
                   {Sided(side, 0.068, 0.058, 0.007), 0.010}},
                  0.004);
    solid.AddLimb(
        {{Sided(side, -0.042, 0.034, 0.012), 0.012}, {Sided(side, -0.062, 0.048, 0.007), 0.010}},
        0.004);
  }
  solid.AddLimb({{{0.050, 0.0, 0.022}, 0.013}, {{0.074, 0.0, 0.038}, 0.013}}, 0.004);
  solid.AddEllipsoid(At(0.084, 0.0, 0.044), {0.021, 0.017, 0.015}, 0.005);
  solid.AddLimb({{{-0.060, 0.0, 0.012}, 0.009}, {{-0.086, 0.0, 0.005}, 0.004}}, 0.004);
  return solid.Polygonize(kCell);
}

}  // namespace vantage
