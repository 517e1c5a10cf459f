#include "perception/model/model_generator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "common/format.h"
#include "common/so3.h"
#include "perception/model/generated_shapes.h"
#include "perception/model/mesh_primitives.h"

namespace vantage {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kSegments = 48;  // of round bodies; a multiple of 2, 3, 4 and 6

using Profile = std::vector<Eigen::Vector2d>;

// Flange with two ears, upright body, dome, a pipe along y; one ear carries a boss.
TriangleMesh Filter() {
  TriangleMesh mesh;
  const auto flange = [](double scale, double z) {
    return PolarRing(
        [scale](double angle) {
          const double ear = std::pow(std::abs(std::cos(angle)), 6.0);
          return scale * (0.036 + 0.029 * ear);
        },
        z,
        96);
  };
  const std::array<Ring, 3> flange_rings = {
      flange(1.0, 0.0), flange(1.0, 0.012), flange(0.96, 0.014)};
  Append(Loft(flange_rings), Pose::Identity(), &mesh);
  const Profile body = {{0.0, 0.008},
                        {0.031, 0.008},
                        {0.031, 0.066},
                        {0.029, 0.074},
                        {0.024, 0.081},
                        {0.016, 0.085},
                        {0.013, 0.086},
                        {0.013, 0.103},
                        {0.011, 0.105},
                        {0.0, 0.105}};
  Append(Revolve(body, kSegments), Pose::Identity(), &mesh);
  // A pipe along y through the body, symmetric about z.
  Append(Cylinder(0.013, -0.046, 0.046, 0.002, 32),
         At(0.0, 0.0, 0.045) * Turned(0.5 * kPi, Eigen::Vector3d::UnitX()),
         &mesh);
  // What tells the two sides apart.
  Append(Cylinder(0.0085, 0.0, 0.022, 0.0015, 24), At(0.051, 0.0, 0.010), &mesh);
  return mesh;
}

TriangleMesh Shampoo() {
  TriangleMesh mesh;
  std::vector<Ring> rings;
  // Half axes by height.
  const std::array<std::array<double, 3>, 9> sections = {{{0.034, 0.019, 0.000},
                                                          {0.037, 0.022, 0.003},
                                                          {0.038, 0.023, 0.020},
                                                          {0.039, 0.023, 0.050},
                                                          {0.038, 0.022, 0.075},
                                                          {0.034, 0.020, 0.092},
                                                          {0.026, 0.017, 0.104},
                                                          {0.017, 0.014, 0.110},
                                                          {0.012, 0.012, 0.112}}};
  for (const auto& [a, b, z] : sections) rings.push_back(SuperellipseRing(a, b, 2.5, z, kSegments));
  Append(Loft(rings), Pose::Identity(), &mesh);
  Append(Cylinder(0.014, 0.110, 0.136, 0.002, kSegments), Pose::Identity(), &mesh);
  return mesh;
}

// Four arms with drums at their ends; one drum carries a boss.
TriangleMesh Hub() {
  TriangleMesh mesh;
  const Profile middle = {{0.0, 0.0},
                          {0.027, 0.0},
                          {0.027, 0.034},
                          {0.025, 0.037},
                          {0.015, 0.038},
                          {0.015, 0.052},
                          {0.013, 0.054},
                          {0.0, 0.054}};
  Append(Revolve(middle, kSegments), Pose::Identity(), &mesh);
  for (int i = 0; i < 4; ++i) {
    const Pose arm = Turned(0.5 * kPi * i, Eigen::Vector3d::UnitZ());
    Append(BeveledBox({0.044, 0.018, 0.018}, 0.002), arm * At(0.036, 0.0, 0.0), &mesh);
    Append(Cylinder(0.013, 0.0, 0.026, 0.002, 32), arm * At(0.057, 0.0, 0.0), &mesh);
  }
  Append(Cylinder(0.008, 0.0, 0.020, 0.0015, 24), At(0.057, 0.0, 0.022), &mesh);
  return mesh;
}

TriangleMesh Trefoil() {
  TriangleMesh mesh;
  const auto ring = [](double scale, double z) {
    return PolarRing(
        [scale](double angle) { return scale * (0.038 + 0.015 * std::cos(3.0 * angle)); }, z, 96);
  };
  const std::array<Ring, 5> rings = {
      ring(0.97, 0.0), ring(1.0, 0.002), ring(1.0, 0.030), ring(0.96, 0.033), ring(0.80, 0.036)};
  Append(Loft(rings), Pose::Identity(), &mesh);
  const Profile knob = {{0.0, 0.030}, {0.018, 0.030}, {0.015, 0.050}, {0.012, 0.053}, {0.0, 0.054}};
  Append(Revolve(knob, kSegments), Pose::Identity(), &mesh);
  return mesh;
}

TriangleMesh Carton() { return BeveledBox({0.060, 0.086, 0.120}, 0.0025); }

TriangleMesh Bottle() {
  const Profile profile = {{0.0, 0.0},
                           {0.028, 0.0},
                           {0.031, 0.003},
                           {0.031, 0.040},
                           {0.031, 0.078},
                           {0.029, 0.088},
                           {0.023, 0.099},
                           {0.015, 0.107},
                           {0.0125, 0.112},
                           {0.0125, 0.122},
                           {0.0155, 0.123},
                           {0.0155, 0.138},
                           {0.014, 0.140},
                           {0.0, 0.140}};
  return Revolve(profile, 72);
}

TriangleMesh Mug() {
  TriangleMesh mesh;
  const Profile profile = {{0.0, 0.0},
                           {0.033, 0.0},
                           {0.037, 0.003},
                           {0.039, 0.012},
                           {0.040, 0.050},
                           {0.040, 0.092},
                           {0.0385, 0.094},
                           {0.0365, 0.092},
                           {0.0365, 0.050},
                           {0.0355, 0.012},
                           {0.031, 0.006},
                           {0.0, 0.005}};
  Append(Revolve(profile, 60), Pose::Identity(), &mesh);
  // The handle's ends are inside the wall, not inside the cup.
  std::vector<Eigen::Vector3d> path;
  constexpr int kSteps = 24;
  for (int i = 0; i <= kSteps; ++i) {
    const double angle = kPi * (static_cast<double>(i) / kSteps - 0.5);
    path.emplace_back(0.0385 + 0.028 * std::cos(angle), 0.0, 0.050 + 0.027 * std::sin(angle));
  }
  Append(Rod(path, Eigen::Vector3d::UnitY(), 0.0055, 16), Pose::Identity(), &mesh);
  return mesh;
}

// Base plate, upright plate, one rib, bosses of three sizes.
TriangleMesh Bracket() {
  TriangleMesh mesh;
  Append(BeveledBox({0.110, 0.064, 0.013}, 0.0015), Pose::Identity(), &mesh);
  Append(BeveledBox({0.013, 0.064, 0.082}, 0.0015), At(-0.0485, 0.0, 0.0), &mesh);
  Append(Wedge(0.056, 0.056, 0.011), At(-0.044, 0.020, 0.011), &mesh);
  Append(Cylinder(0.014, 0.0, 0.016, 0.0015, 32), At(0.034, -0.012, 0.010), &mesh);
  Append(Cylinder(0.009, 0.0, 0.028, 0.0015, 32), At(0.038, 0.021, 0.010), &mesh);
  Append(Cylinder(0.012, 0.0, 0.018, 0.0015, 32),
         At(-0.045, -0.014, 0.056) * Turned(0.5 * kPi, Eigen::Vector3d::UnitY()),
         &mesh);
  return mesh;
}

TriangleMesh Gear() {
  TriangleMesh mesh;
  // Six teeth with sloping flanks.
  const auto ring = [](double outer, double z) {
    return PolarRing(
        [outer](double angle) {
          const double wave = 0.5 + 2.2 * std::cos(6.0 * angle);
          return 0.036 + (outer - 0.036) * std::clamp(wave, 0.0, 1.0);
        },
        z,
        144);
  };
  const std::array<Ring, 4> rings = {
      ring(0.050, 0.0), ring(0.052, 0.002), ring(0.052, 0.020), ring(0.050, 0.022)};
  Append(Loft(rings), Pose::Identity(), &mesh);
  const Profile shaft = {{0.0, 0.010},
                         {0.024, 0.010},
                         {0.024, 0.034},
                         {0.022, 0.036},
                         {0.012, 0.037},
                         {0.012, 0.060},
                         {0.010, 0.062},
                         {0.0, 0.062}};
  Append(Revolve(shaft, kSegments), Pose::Identity(), &mesh);
  return mesh;
}

// Looks over its left shoulder.
TriangleMesh Duck() {
  TriangleMesh mesh;
  std::vector<Ring> body;
  constexpr int kSections = 14;
  for (int i = 0; i <= kSections; ++i) {
    const double z = 0.056 * i / kSections;
    const double height = 2.0 * i / kSections - 1.0;
    const double width = std::pow(1.02 - height * height * std::abs(height), 0.5);
    const double back = 0.010 * height;
    Ring ring = SuperellipseRing(0.048 * width, 0.033 * width, 2.0, z, kSegments);
    for (Eigen::Vector3d& point : ring) point.x() += back - 0.006 * (1.0 - height) * 0.5;
    body.push_back(std::move(ring));
  }
  Append(Loft(body), Pose::Identity(), &mesh);
  const Pose head = At(0.024, 0.008, 0.070) * Turned(0.7, Eigen::Vector3d::UnitZ());
  Append(Ellipsoid({0.026, 0.023, 0.024}, 32), head, &mesh);
  Append(Ellipsoid({0.017, 0.011, 0.006}, 24), head * At(0.026, 0.0, -0.004), &mesh);
  Append(Ellipsoid({0.024, 0.014, 0.010}, 24),
         At(-0.046, 0.0, 0.050) * Turned(0.6, Eigen::Vector3d::UnitY()),
         &mesh);
  Append(Ellipsoid({0.026, 0.008, 0.015}, 24), At(-0.006, 0.030, 0.034), &mesh);
  Append(Ellipsoid({0.026, 0.008, 0.015}, 24), At(-0.006, -0.030, 0.034), &mesh);
  return mesh;
}

struct Recipe {
  const char* name;
  const char* what;
  TriangleMesh (*make)();
  SymmetryGroup (*symmetry)();
};

template <int kOrder>
SymmetryGroup AboutZ() {
  return SymmetryGroup::Cyclic(kOrder, Eigen::Vector3d::UnitZ());
}

const std::array<Recipe, 18> kRecipes = {{
    {"filter", "filter housing, 2-fold but for one boss", Filter, SymmetryGroup::None},
    {"shampoo", "flat bottle, 2-fold", Shampoo, AboutZ<2>},
    {"hub", "four-armed part, 4-fold but for one boss", Hub, SymmetryGroup::None},
    {"trefoil", "three-lobed knob, 3-fold", Trefoil, AboutZ<3>},
    {"carton",
     "box, half turns about three axes",
     Carton,
     [] { return SymmetryGroup::Dihedral(2, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX()); }},
    {"bottle",
     "round bottle, continuous",
     Bottle,
     [] { return SymmetryGroup::Continuous(Eigen::Vector3d::UnitZ(), false); }},
    {"mug", "mug, continuous but for its handle", Mug, SymmetryGroup::None},
    {"bracket", "bracket with rib and bosses, no symmetry", Bracket, SymmetryGroup::None},
    {"gear", "six-toothed wheel on a shaft, 6-fold", Gear, AboutZ<6>},
    {"duck", "duck that looks aside, free-form", Duck, SymmetryGroup::None},
    {"cat", "sitting cat, free-form", Cat, SymmetryGroup::None},
    {"dwarf", "garden gnome that waves, free-form", Dwarf, SymmetryGroup::None},
    {"fish", "goldfish, free-form, left and right alike", Fish, SymmetryGroup::None},
    {"pitcher", "jug, continuous but for lip and handle", Pitcher, SymmetryGroup::None},
    {"pony", "standing pony, free-form", Pony, SymmetryGroup::None},
    {"sauce", "flat bottle, 2-fold but for its thumb rest", Sauce, SymmetryGroup::None},
    {"spray", "spray bottle, 2-fold but for its trigger", Spray, SymmetryGroup::None},
    {"turtle", "turtle, free-form, left and right alike", Turtle, SymmetryGroup::None},
}};

const std::array<Recipe, 10> kAmbiguousRecipes = {{
    {"flange", "scalloped flange, 6-fold but for a lug", Flange, SymmetryGroup::None},
    {"cross", "four arms around a cup, 4-fold but for a tab in it", Cross, SymmetryGroup::None},
    {"valve", "hand wheel, 3-fold but for a stub", Valve, SymmetryGroup::None},
    {"brick",
     "box with wells, half turns about three axes but for a stud",
     Brick,
     SymmetryGroup::None},
    {"plug", "flat socket, 2-fold but for a rib in it", Plug, SymmetryGroup::None},
    {"knob", "knob, continuous but for a pointer below", Knob, SymmetryGroup::None},
    {"cap", "dome, continuous but for a spout", Cap, SymmetryGroup::None},
    {"star", "dish, 5-fold but for a block in it", Star, SymmetryGroup::None},
    {"nut", "hexagonal prism, the same upside down, but for a tab", Nut, SymmetryGroup::None},
    {"reel", "reel, continuous, the same upside down, but for a pin", Reel, SymmetryGroup::None},
}};

std::span<const Recipe> Recipes(ObjectSet set) {
  if (set == ObjectSet::kBundled) return kRecipes;
  return kAmbiguousRecipes;
}

constexpr ObjectSet kSets[] = {ObjectSet::kBundled, ObjectSet::kAmbiguous};

GeneratedObject Make(const Recipe& recipe) {
  GeneratedObject object{recipe.name, recipe.what, recipe.make(), recipe.symmetry()};
  // On a grid of about a micrometre, so that the last bits of a platform's sin and cos are lost.
  constexpr float kGrid = 0x1.0p-20F;
  for (Eigen::Vector3f& vertex : object.mesh.vertices) {
    for (float& value : vertex) value = kGrid * std::round(value / kGrid) + 0.0F;
  }
  return object;
}

}  // namespace

std::vector<std::string> GeneratedObjectNames(ObjectSet set) {
  std::vector<std::string> names;
  for (const Recipe& recipe : Recipes(set)) names.emplace_back(recipe.name);
  return names;
}

Result<GeneratedObject> GenerateObject(const std::string& name) {
  std::string names;
  for (const ObjectSet set : kSets) {
    for (const Recipe& recipe : Recipes(set)) {
      if (name == recipe.name) return Make(recipe);
      if (!names.empty()) names += ", ";
      names += recipe.name;
    }
  }
  return Error{
      ErrorCode::kNotFound,
      Format("no object \"%s\" to generate, expected one of %s", name.c_str(), names.c_str())};
}

}  // namespace vantage
