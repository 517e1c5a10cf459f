#include "perception/model/model_generator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "perception/model/file_bytes.h"
#include "perception/model/mesh_check.h"
#include "perception/model/mesh_primitives.h"
#include "perception/model/model_builder.h"
#include "perception/model/object_model.h"
#include "tests/perception/model_test_support.h"

namespace vantage {
namespace {

constexpr double kPi = std::numbers::pi;

// How far some point of the outer surface lies from the surface once turned about the centre, m:
// the largest distance, or the first that is found beyond `enough`.
double MisfitUnder(const GeneratedObject& object,
                   const std::vector<SurfacePoint>& samples,
                   const Eigen::Quaterniond& rotation,
                   double enough) {
  const Eigen::Vector3d center = object.mesh.SurfaceCentroid();
  const MeshDistance distance(object.mesh);
  double largest = 0.0;
  for (const SurfacePoint& sample : samples) {
    largest = std::max(largest,
                       distance.To(rotation * (sample.position.cast<double>() - center) + center));
    if (largest > enough) break;
  }
  return largest;
}

GeneratedObject Make(const std::string& name) {
  Result<GeneratedObject> object = GenerateObject(name);
  VANTAGE_CHECK(object.ok(), name);
  return std::move(object).value();
}

// What is seen of an object from outside; kept, since several tests look at it.
const std::vector<SurfacePoint>& OuterSamples(const GeneratedObject& object) {
  static std::map<std::string, std::vector<SurfacePoint>> kept;
  std::vector<SurfacePoint>& samples = kept[object.name];
  if (samples.empty()) {
    SurfaceSampleParameters parameters;
    parameters.spacing = 0.03;
    parameters.directions = 60;
    Rng rng(11);
    samples = SampleVisibleSurface(object.mesh, object.mesh.Diameter(), parameters, rng);
  }
  return samples;
}

std::vector<std::string> AllNames() {
  std::vector<std::string> names = GeneratedObjectNames();
  for (const std::string& name : GeneratedObjectNames(ObjectSet::kAmbiguous)) {
    names.push_back(name);
  }
  return names;
}

TEST(ModelGenerator, EveryObjectIsSoundAndOfUsefulSize) {
  ASSERT_EQ(GeneratedObjectNames().size(), 18U);
  ASSERT_EQ(GeneratedObjectNames(ObjectSet::kAmbiguous).size(), 10U);
  for (const std::string& name : AllNames()) {
    SCOPED_TRACE(name);
    TriangleMesh mesh = Make(name).mesh;
    const Result<MeshMending> mending = CheckAndMendMesh(&mesh);
    ASSERT_TRUE(mending.ok()) << mending.error().message;
    EXPECT_EQ(mending->open_edges, 0U);
    EXPECT_EQ(mending->odd_edges, 0U);
    EXPECT_EQ(mending->removed_triangles, 0U);
    EXPECT_FALSE(mending->flipped);
    EXPECT_LT(mesh.triangles.size(), 12'000U);
    EXPECT_NEAR(mesh.Bounds().min().z(), 0.0F, 1e-6F);
    EXPECT_GT(mesh.Diameter(), 0.06);
    EXPECT_LT(mesh.Diameter(), 0.28);
  }
}

TEST(ModelGenerator, EveryObjectMapsOntoItselfUnderItsGroup) {
  for (const std::string& name : GeneratedObjectNames()) {
    SCOPED_TRACE(name);
    const GeneratedObject object = Make(name);
    std::vector<Eigen::Quaterniond> elements = object.symmetry.elements;
    if (object.symmetry.kind == SymmetryGroup::Kind::kContinuous) {
      EXPECT_FALSE(object.symmetry.flips);
      for (const double angle : {0.1, 1.0, 2.345, 4.0}) {
        elements.push_back(ExpSo3(angle * object.symmetry.axis));
      }
    }
    // Flat sides of round bodies: r (1 - cos(pi / segments)) is below 0.1 mm for all of them.
    const std::vector<SurfacePoint>& samples = OuterSamples(object);
    for (const Eigen::Quaterniond& element : elements) {
      EXPECT_LT(MisfitUnder(object, samples, element, 1e-4), 1e-4);
    }
  }
}

TEST(ModelGenerator, NoObjectMapsOntoItselfOutsideItsGroup) {
  Rng rng(5);
  for (const std::string& name : AllNames()) {
    SCOPED_TRACE(name);
    const GeneratedObject object = Make(name);
    std::vector<Eigen::Quaterniond> rotations;
    for (int order = 2; order <= 8; ++order) {
      for (int axis = 0; axis < 3; ++axis) {
        rotations.push_back(ExpSo3(2.0 * kPi / order * Eigen::Vector3d::Unit(axis)));
      }
    }
    for (int i = 0; i < 10; ++i) rotations.push_back(rng.Rotation());
    const std::vector<SurfacePoint>& samples = OuterSamples(object);
    for (const Eigen::Quaterniond& rotation : rotations) {
      if (SymmetricAngle(object.symmetry, rotation, Eigen::Quaterniond::Identity()) <
          15.0 * kDegree) {
        continue;
      }
      EXPECT_GT(MisfitUnder(object, samples, rotation, 0.005), 0.005)
          << "turn by " << LogSo3(rotation).transpose();
    }
  }
}

// The objects that nearly have a symmetry: one feature of 8 mm or more breaks it, and it is small.
TEST(ModelGenerator, SmallFeaturesBreakNearSymmetries) {
  const auto misfit = [](const std::string& name, double angle) {
    const GeneratedObject object = Make(name);
    // About z through the origin, where the near symmetry's axis is.
    double largest = 0.0;
    double far_samples = 0.0;
    const std::vector<SurfacePoint>& samples = OuterSamples(object);
    const MeshDistance to_mesh(object.mesh);
    for (const SurfacePoint& sample : samples) {
      const Eigen::Vector3d turned = ExpSo3({0.0, 0.0, angle}) * sample.position.cast<double>();
      const double distance = to_mesh.To(turned);
      largest = std::max(largest, distance);
      far_samples += distance > 0.002 ? 1.0 / static_cast<double>(samples.size()) : 0.0;
    }
    return std::pair(largest, far_samples);
  };
  for (const auto& [name, angle] : {std::pair("filter", kPi),
                                    std::pair("hub", 0.5 * kPi),
                                    std::pair("hub", kPi),
                                    std::pair("sauce", kPi)}) {
    const auto [largest, share] = misfit(name, angle);
    EXPECT_GT(largest, 0.008) << name;
    EXPECT_GT(share, 0.005) << name;
    EXPECT_LT(share, 0.08) << name;
  }
  // A quarter turn of the filter or of the bottle, or an eighth of the hub, is no near symmetry.
  EXPECT_GT(misfit("filter", 0.5 * kPi).second, 0.15);
  EXPECT_GT(misfit("sauce", 0.5 * kPi).second, 0.15);
  EXPECT_GT(misfit("hub", 0.25 * kPi).second, 0.15);
  // Without its handle the mug would be continuous.
  EXPECT_LT(misfit("mug", 1.0).second, 0.2);
  EXPECT_GT(misfit("mug", 1.0).first, 0.01);
}

// Without one feature these would have the symmetry: what does not come to lie on the surface when
// they are turned is a small part of it, and 10 to 20 mm off.
TEST(ModelGenerator, OneFeatureBreaksTheSymmetryOfAmbiguousObjects) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  struct NearSymmetry {
    const char* name;
    Eigen::Vector3d axis;
    double angle;   // rad
    double height;  // m, of a point on the axis
  };
  const NearSymmetry symmetries[] = {{"flange", z, kPi / 3.0, 0.0},
                                     {"cross", z, 0.5 * kPi, 0.0},
                                     {"valve", z, 2.0 * kPi / 3.0, 0.0},
                                     {"brick", z, kPi, 0.03},
                                     {"brick", x, kPi, 0.03},
                                     {"plug", z, kPi, 0.0},
                                     {"knob", z, 1.0, 0.0},
                                     {"cap", z, 2.0, 0.0},
                                     {"star", z, 0.4 * kPi, 0.0},
                                     {"nut", z, kPi / 3.0, 0.03},
                                     {"nut", x, kPi, 0.03},
                                     {"reel", z, 2.0, 0.05},
                                     {"reel", x, kPi, 0.05}};
  for (const NearSymmetry& symmetry : symmetries) {
    SCOPED_TRACE(symmetry.name);
    const GeneratedObject object = Make(symmetry.name);
    const MeshDistance to_mesh(object.mesh);
    const Eigen::Quaterniond turn = ExpSo3(symmetry.angle * symmetry.axis);
    const Eigen::Vector3d origin(0.0, 0.0, symmetry.height);
    const std::vector<SurfacePoint>& samples = OuterSamples(object);
    double largest = 0.0;
    double share = 0.0;
    for (const SurfacePoint& sample : samples) {
      const double distance = to_mesh.To(turn * (sample.position.cast<double>() - origin) + origin);
      largest = std::max(largest, distance);
      share += distance > 0.002 ? 1.0 / static_cast<double>(samples.size()) : 0.0;
    }
    EXPECT_GT(largest, 0.009);
    EXPECT_LT(largest, 0.022);
    EXPECT_GT(share, 0.003);
    EXPECT_LT(share, 0.08);
  }
}

// Which is no rotation, so it is in no symmetry group; but seen from the side such objects are
// hard.
TEST(ModelGenerator, LeftAndRightAreAlikeWhereSaidSo) {
  const auto misfit = [](const std::string& name) {
    const GeneratedObject object = Make(name);
    const MeshDistance distance(object.mesh);
    double largest = 0.0;
    for (const SurfacePoint& sample : OuterSamples(object)) {
      largest = std::max(
          largest,
          distance.To(sample.position.cast<double>().cwiseProduct(Eigen::Vector3d(1, -1, 1))));
    }
    return largest;
  };
  for (const char* name : {"fish", "turtle", "pitcher", "sauce", "spray"}) {
    EXPECT_LT(misfit(name), 0.0015) << name;
  }
  for (const char* name : {"cat", "dwarf", "pony", "duck"}) EXPECT_GT(misfit(name), 0.005) << name;
}

// The center of the volume is above what touches the table, by 3 mm or more from its edge.
TEST(ModelGenerator, EveryObjectStandsOnItsBase) {
  for (const std::string& name : AllNames()) {
    if (name == "duck") continue;  // Its round belly rocks forward.
    SCOPED_TRACE(name);
    const TriangleMesh mesh = Make(name).mesh;
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();
    for (const auto& [ia, ib, ic] : mesh.triangles) {
      const Eigen::Vector3d a = mesh.vertices[ia].cast<double>();
      const Eigen::Vector3d b = mesh.vertices[ib].cast<double>();
      const Eigen::Vector3d c = mesh.vertices[ic].cast<double>();
      moment += a.dot(b.cross(c)) / 6.0 * (a + b + c) / 4.0;
    }
    const Eigen::Vector3d center = moment / SignedVolume(mesh);
    double narrowest = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 72; ++i) {
      const Eigen::Vector3d outward(std::cos(kPi * i / 36), std::sin(kPi * i / 36), 0.0);
      double reach = -std::numeric_limits<double>::infinity();
      for (const Eigen::Vector3f& vertex : mesh.vertices) {
        if (vertex.z() > 5e-4F) continue;
        reach = std::max(reach, outward.dot(vertex.cast<double>() - center));
      }
      narrowest = std::min(narrowest, reach);
    }
    EXPECT_GT(narrowest, 0.003);
  }
}

TEST(ModelGenerator, UnknownNamesAreListed) {
  const Result<GeneratedObject> object = GenerateObject("teapot");
  ASSERT_FALSE(object.ok());
  EXPECT_NE(object.error().message.find("teapot"), std::string::npos);
  EXPECT_NE(object.error().message.find("filter, shampoo"), std::string::npos);
}

// models/ holds what the generator makes now, byte for byte.
TEST(ModelGenerator, BundledModelsAreReproduced) {
  const std::filesystem::path bundled = std::filesystem::path(VANTAGE_SOURCE_DIR) / "models";
  const ScratchFolder scratch;
  for (const std::string& name : GeneratedObjectNames()) {
    SCOPED_TRACE(name + ": remake with vantage-model generate --output models");
    const GeneratedObject object = Make(name);
    const Result<ObjectModel> model =
        BuildObjectModel(name, object.mesh, object.symmetry, "vantage-model generate " + name, {});
    ASSERT_TRUE(model.ok()) << model.error().message;
    ASSERT_TRUE(SaveObjectModel(*model, scratch.path() / name).ok());
    for (const char* file : {"model.toml", "mesh.ply", "samples.ply"}) {
      const Result<std::string> expected = ReadFileBytes(bundled / name / file, 1U << 24U);
      const Result<std::string> made = ReadFileBytes(scratch.path() / name / file, 1U << 24U);
      ASSERT_TRUE(expected.ok()) << expected.error().message;
      ASSERT_TRUE(made.ok());
      EXPECT_TRUE(*expected == *made) << file;
    }
  }
}

TEST(MeshPrimitives, HaveTheirVolume) {
  constexpr int kSegments = 96;
  EXPECT_NEAR(SignedVolume(BeveledBox({1.0, 2.0, 3.0}, 0.001)), 6.0, 0.01);
  EXPECT_NEAR(SignedVolume(Cylinder(1.0, -1.0, 1.0, 0.001, kSegments)), 2.0 * kPi, 0.02);
  EXPECT_NEAR(SignedVolume(Ellipsoid({1.0, 2.0, 0.5}, kSegments)), 4.0 / 3.0 * kPi, 0.02);
  EXPECT_NEAR(SignedVolume(Wedge(2.0, 3.0, 1.0)), 3.0, 1e-6);
  // A quarter of a torus: Pappus.
  std::vector<Eigen::Vector3d> path;
  for (int i = 0; i <= 64; ++i) {
    const double angle = 0.5 * kPi * i / 64;
    path.emplace_back(2.0 * std::cos(angle), 0.0, 2.0 * std::sin(angle));
  }
  EXPECT_NEAR(
      SignedVolume(Rod(path, Eigen::Vector3d::UnitY(), 0.3, kSegments)), kPi * 0.09 * kPi, 0.01);
}

}  // namespace
}  // namespace vantage
