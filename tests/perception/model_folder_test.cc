#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "perception/model/file_bytes.h"
#include "perception/model/mesh_primitives.h"
#include "perception/model/model_builder.h"
#include "perception/model/object_model.h"
#include "perception/model/ply_file.h"
#include "perception/model/symmetry_text.h"
#include "tests/perception/model_test_support.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr size_t kLargest = 1U << 24U;  // bytes

ObjectModel MakeModel(const std::string& id, const SymmetryGroup& symmetry) {
  Result<ObjectModel> model = BuildObjectModel(
      id, BeveledBox({0.05, 0.07, 0.1}, 0.004), symmetry, "a \"test\"\\\n of quotes", {});
  VANTAGE_CHECK(model.ok(), id);
  return std::move(model).value();
}

void ExpectHas(const std::string& message, const std::string& part) {
  EXPECT_NE(message.find(part), std::string::npos) << message;
}

void Replace(const fs::path& file, const std::string& from, const std::string& to) {
  std::string text = *ReadFileBytes(file, kLargest);
  const size_t at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  ASSERT_TRUE(WriteFileBytes(file, text).ok());
}

TEST(ObjectModel, ComesBackAsItWasSaved) {
  const ScratchFolder scratch;
  SymmetryGroup tetrahedral;
  tetrahedral.elements.clear();
  for (const Eigen::Vector4d& wxyz : {Eigen::Vector4d(1, 0, 0, 0),
                                      Eigen::Vector4d(0, 1, 0, 0),
                                      Eigen::Vector4d(0, 0, 1, 0),
                                      Eigen::Vector4d(0, 0, 0, 1),
                                      Eigen::Vector4d(1, 1, 1, 1),
                                      Eigen::Vector4d(1, -1, -1, -1)}) {
    tetrahedral.elements.push_back(
        Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).normalized());
  }
  const Eigen::Vector3d axis = Eigen::Vector3d(0.1, -0.7, 0.3).normalized();
  Rng rng(1);
  for (const SymmetryGroup& symmetry : {SymmetryGroup::None(),
                                        SymmetryGroup::Cyclic(7, axis),
                                        SymmetryGroup::Dihedral(3, axis, axis.unitOrthogonal()),
                                        SymmetryGroup::Continuous(axis, false),
                                        SymmetryGroup::Continuous(axis, true),
                                        tetrahedral}) {
    SCOPED_TRACE(SymmetryText(symmetry));
    const ObjectModel model = MakeModel("box", symmetry);
    const fs::path folder = scratch.path() / "box";
    ASSERT_TRUE(SaveObjectModel(model, folder).ok());
    const Result<ObjectModel> loaded = LoadObjectModel(folder);
    ASSERT_TRUE(loaded.ok()) << loaded.error().message;
    EXPECT_EQ(loaded->id, "box");
    EXPECT_EQ(loaded->source, "a \"test\"\\  of quotes");
    EXPECT_EQ(loaded->diameter, model.diameter);
    EXPECT_EQ(loaded->center, model.center);
    EXPECT_EQ(loaded->mesh_hash, model.mesh_hash);
    EXPECT_EQ(loaded->mesh.vertices, model.mesh.vertices);
    EXPECT_EQ(loaded->mesh.triangles, model.mesh.triangles);
    ASSERT_EQ(loaded->samples.size(), model.samples.size());
    for (size_t i = 0; i < model.samples.size(); ++i) {
      EXPECT_EQ(loaded->samples[i].position, model.samples[i].position);
      EXPECT_EQ(loaded->samples[i].normal, model.samples[i].normal);
    }
    EXPECT_EQ(loaded->symmetry.kind, symmetry.kind);
    EXPECT_EQ(loaded->symmetry.flips, symmetry.flips);
    EXPECT_EQ(loaded->symmetry.elements.size(), symmetry.elements.size());
    for (int i = 0; i < 20; ++i) {
      const Eigen::Quaterniond a = rng.Rotation();
      const Eigen::Quaterniond b = rng.Rotation();
      EXPECT_NEAR(SymmetricAngle(loaded->symmetry, a, b), SymmetricAngle(symmetry, a, b), 1e-9);
    }
  }
}

TEST(ObjectModel, SavingReplacesAModelWholeAndNothingElse) {
  const ScratchFolder scratch;
  const ObjectModel model = MakeModel("box", SymmetryGroup::None());
  const fs::path folder = scratch.path() / "box";
  ASSERT_TRUE(SaveObjectModel(model, folder).ok());
  ASSERT_TRUE(WriteFileBytes(folder / "ppf.bin", "an old table").ok());
  ASSERT_TRUE(SaveObjectModel(model, scratch.path() / "box/").ok());
  EXPECT_FALSE(fs::exists(folder / "ppf.bin"));
  EXPECT_EQ(scratch.CountEntries(), 1);

  const fs::path other = scratch.path() / "other" / "box";
  fs::create_directories(other);
  ASSERT_TRUE(WriteFileBytes(other / "letter.txt", "dear").ok());
  const Result<void> refused = SaveObjectModel(model, other);
  ASSERT_FALSE(refused.ok());
  ExpectHas(refused.error().message, "no model folder");
  EXPECT_TRUE(fs::exists(other / "letter.txt"));
  EXPECT_EQ(std::distance(fs::directory_iterator(other.parent_path()), fs::directory_iterator()),
            1);
}

TEST(ObjectModel, SavingRefusesBadNamesAndPlaces) {
  const ScratchFolder scratch;
  ObjectModel model = MakeModel("box", SymmetryGroup::None());
  EXPECT_FALSE(SaveObjectModel(model, scratch.path() / "bin").ok());
  EXPECT_FALSE(SaveObjectModel(model, "/dev/null/box").ok());
  for (const std::string& id : {std::string(),
                                std::string("a b"),
                                std::string("../x"),
                                std::string("-x"),
                                std::string(65, 'x')}) {
    model.id = id;
    EXPECT_FALSE(SaveObjectModel(model, scratch.path() / id).ok()) << id;
  }
  EXPECT_EQ(scratch.CountEntries(), 0);
}

TEST(ObjectModel, LoadingNamesWhatIsWrong) {
  const ScratchFolder scratch;
  const fs::path folder = scratch.path() / "box";
  const auto refusal = [&folder](const std::string& file,
                                 const std::string& from,
                                 const std::string& to) {
    VANTAGE_CHECK(
        SaveObjectModel(MakeModel("box", SymmetryGroup::Cyclic(2, {0, 0, 1})), folder).ok(), "");
    Replace(folder / file, from, to);
    const Result<ObjectModel> model = LoadObjectModel(folder);
    return model.ok() ? std::string() : model.error().message;
  };
  ExpectHas(LoadObjectModel(scratch.path() / "none").error().message, "no model folder");
  ExpectHas(refusal("model.toml", "id = \"box\"", "id = \"can\""), "expected the folder's name");
  ExpectHas(refusal("model.toml", "id = \"box\"", "id = 5"), "key id = 5, expected a string");
  ExpectHas(refusal("model.toml", "id = \"box\"", "id ="), "model.toml:2:");
  ExpectHas(refusal("model.toml", "id = \"box\"", ""), "key id is absent");
  ExpectHas(refusal("model.toml", "unit = \"m\"", "unit = \"mm\""), "key unit");
  ExpectHas(refusal("model.toml", "unit = \"m\"", "unit = \"m\"\nx = 1"), "no such key");
  ExpectHas(refusal("model.toml", "diameter_m = 0", "diameter_m = 7"), "diameter_m = 7");
  ExpectHas(refusal("model.toml", "diameter_m = ", "diameter_m = -"), "a positive number");
  ExpectHas(refusal("model.toml", "diameter_m = 0", "diameter_m = nan #"), "a positive number");
  ExpectHas(refusal("model.toml", "center_m = [", "center_m = [9.0, "), "3 numbers");
  ExpectHas(refusal("model.toml", "center_m = [0", "center_m = [9"), "center_m lies outside");
  ExpectHas(refusal("model.toml", "mesh_hash = \"", "mesh_hash = \"g"), "hexadecimal");
  ExpectHas(refusal("model.toml", "num_samples = ", "num_samples = 1"), "num_samples");
  ExpectHas(refusal("model.toml", "order = 2", "order = 100000000"), "from 1 to 1000");
  ExpectHas(refusal("model.toml", "axis = [0.0, 0.0, 1.0]", "axis = [0.0, 0.0, 0.0]"), "axis");
  ExpectHas(refusal("model.toml", "kind = \"cyclic\"", "kind = \"cubic\""), "key kind");
  ExpectHas(refusal("model.toml", "[symmetry]", "[symmetries]"), "symmetries");
  // The last bit of some coordinate.
  const std::string mesh = *ReadFileBytes(folder / "mesh.ply", kLargest);
  ExpectHas(refusal("mesh.ply", mesh.substr(400, 4), "\x01\x02\x03\x3c"), "mesh_hash is");
  for (const char* file : {"model.toml", "mesh.ply", "samples.ply"}) {
    ASSERT_TRUE(SaveObjectModel(MakeModel("box", SymmetryGroup::None()), folder).ok());
    fs::remove(folder / file);
    ExpectHas(LoadObjectModel(folder).error().message, std::string("has no ") + file);
    fs::create_directory(folder / file);
    EXPECT_FALSE(LoadObjectModel(folder).ok());
    fs::remove_all(folder);
  }
}

// Counts, indices and lengths that lie.
TEST(PlyFile, HostileFilesAreRefused) {
  const ScratchFolder scratch;
  const fs::path file = scratch.path() / "mesh.ply";
  const TriangleMesh box = BeveledBox({0.05, 0.07, 0.1}, 0.004);
  const auto refusal = [&](const std::string& from, const std::string& to) {
    VANTAGE_CHECK(WriteMeshPly(box, file).ok(), "");
    Replace(file, from, to);
    const Result<TriangleMesh> mesh = ReadMeshPly(file);
    return mesh.ok() ? std::string() : mesh.error().message;
  };
  EXPECT_EQ(refusal("ply\n", "ply\n"), "");
  for (const char* count : {"0",
                            "4",
                            "35",
                            "4000000000",
                            "18446744073709551615",
                            "1537228672809129302",
                            "99999999999999999999999",
                            "-1",
                            ""}) {
    EXPECT_NE(refusal("vertex 34\n", std::string("vertex ") + count + "\n"), "") << count;
    EXPECT_NE(refusal("face 64\n", std::string("face ") + count + "\n"), "") << count;
  }
  EXPECT_NE(refusal("binary_little_endian", "ascii"), "");
  EXPECT_NE(refusal("float x", "double x"), "");

  ASSERT_TRUE(WriteMeshPly(box, file).ok());
  const std::string sound = *ReadFileBytes(file, kLargest);
  const size_t body = sound.find("end_header\n") + 11;
  const size_t faces = body + box.vertices.size() * 12;
  const auto with = [&](size_t at, const std::string& bytes) {
    std::string changed = sound;
    changed.replace(at, bytes.size(), bytes);
    VANTAGE_CHECK(WriteFileBytes(file, changed).ok(), "");
    const Result<TriangleMesh> mesh = ReadMeshPly(file);
    return mesh.ok() ? std::string() : mesh.error().message;
  };
  ExpectHas(with(body + 12, std::string("\x00\x00\xc0\x7f", 4)), "vertex 1 is not finite");
  ExpectHas(with(faces, "\x04"), "face 0 has 4 corners");
  ExpectHas(with(faces + 13 + 1, std::string("\x22\x00\x00\x00", 4)), "face 1 names vertex 34");
  ExpectHas(with(faces + 1, "\xff\xff\xff\xff"), "names vertex 4294967295");
}

TEST(PlyFile, EveryTruncationAndManyFlipsAreSurvived) {
  const ScratchFolder scratch;
  const fs::path file = scratch.path() / "x.ply";
  const ObjectModel model = MakeModel("box", SymmetryGroup::None());
  Rng rng(2);
  for (const bool mesh : {true, false}) {
    ASSERT_TRUE(
        (mesh ? WriteMeshPly(model.mesh, file) : WriteSamplesPly(model.samples, file)).ok());
    const std::string sound = *ReadFileBytes(file, kLargest);
    const auto readable = [&](const std::string& bytes) {
      VANTAGE_CHECK(WriteFileBytes(file, bytes).ok(), "");
      return mesh ? ReadMeshPly(file).ok() : ReadSamplesPly(file).ok();
    };
    for (size_t length = 0; length < sound.size(); length += length < 400 ? 7 : 211) {
      EXPECT_FALSE(readable(sound.substr(0, length))) << length;
    }
    EXPECT_FALSE(readable(sound + "x"));
    EXPECT_TRUE(readable(sound));
    for (int i = 0; i < 150; ++i) {
      std::string flipped = sound;
      char& byte = flipped[rng.Below(static_cast<uint32_t>(sound.size()))];
      byte = static_cast<char>(byte ^ (1 << rng.Below(8)));
      static_cast<void>(readable(flipped));
    }
  }
}

TEST(SymmetryText, ParsesWhatTheCommandLineTakes) {
  const Eigen::Quaterniond identity = Eigen::Quaterniond::Identity();
  const auto turn = [](double angle, const Eigen::Vector3d& axis) { return ExpSo3(angle * axis); };
  constexpr double kPi = std::numbers::pi;
  const SymmetryGroup cyclic = *ParseSymmetry("cyclic:3:z");
  EXPECT_LE(SymmetricAngle(cyclic, identity, turn(2.0 * kPi / 3.0, {0, 0, 1})), 1e-12);
  EXPECT_GT(SymmetricAngle(cyclic, identity, turn(kPi, {1, 0, 0})), 1.0);
  const SymmetryGroup dihedral = *ParseSymmetry("dihedral:2:z:x");
  EXPECT_LE(SymmetricAngle(dihedral, identity, turn(kPi, {1, 0, 0})), 1e-12);
  EXPECT_LE(SymmetricAngle(dihedral, identity, turn(kPi, {0, 1, 0})), 1e-12);
  const SymmetryGroup tilted = *ParseSymmetry("continuous:0,0.6,0.8");
  EXPECT_LE(SymmetricAngle(tilted, identity, turn(1.234, {0, 0.6, 0.8})), 1e-12);
  EXPECT_FALSE(tilted.flips);
  EXPECT_TRUE(ParseSymmetry("continuous-flip:x")->flips);
  EXPECT_EQ(ParseSymmetry("none")->elements.size(), 1U);
  for (const char* bad : {"",
                          "None",
                          "cyclic",
                          "cyclic:2",
                          "cyclic:x:2",
                          "cyclic:0:z",
                          "cyclic:1001:z",
                          "cyclic:2:w",
                          "cyclic:2:0,0,0",
                          "cyclic:2:0,0",
                          "cyclic:2:nan,0,1",
                          "dihedral:2:z",
                          "dihedral:2:z:z",
                          "continuous:z:x",
                          "continuous:inf,0,0",
                          "cyclic:2:z:",
                          "cyclic:2.5:z"}) {
    const Result<SymmetryGroup> group = ParseSymmetry(bad);
    EXPECT_FALSE(group.ok()) << bad;
  }
}

}  // namespace
}  // namespace vantage
