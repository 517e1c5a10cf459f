#include "tests/bench/pose_comparison/compared_models.h"

#include <algorithm>
#include <array>

#include "fusion/symmetry/measured_symmetry.h"
#include "perception/model/mesh_check.h"
#include "perception/model/mesh_import.h"
#include "perception/model/model_builder.h"
#include "perception/model/model_generator.h"

namespace vantage {
namespace {

constexpr std::array kGenerated = {"mug", "carton", "bottle", "filter", "bracket", "gear"};

struct Scan {
  const char* name;
  const char* file;
  double scale;  // m a unit
};
constexpr std::array kScans = {
    Scan{"stanford_bunny", "stanford_bunny.ply", 1.0},
    Scan{"mian_parasaurolophus", "mian_parasaurolophus.ply", 1e-3},
    Scan{"mian_chef", "mian_chef.ply", 1e-3},
    Scan{"ycb_CrackerBox", "ycb_CrackerBox.obj", 1.0},
    Scan{"ycb_PowerDrill", "ycb_PowerDrill.obj", 1.0},
    Scan{"ycb_MustardBottle", "ycb_MustardBottle.obj", 1.0},
    Scan{"ycb_PottedMeatCan", "ycb_PottedMeatCan.obj", 1.0},
};

Result<ObjectModel> MakeScannedModel(const Scan& scan, const std::filesystem::path& meshes) {
  const std::filesystem::path file = meshes / scan.file;
  if (!std::filesystem::exists(file)) {
    return Error{ErrorCode::kNotFound, file.string() + " is not there"};
  }
  Result<TriangleMesh> mesh = ImportMesh(file, scan.scale);
  if (!mesh) return mesh.error();
  if (const Result<MeshMending> mending = CheckAndMendMesh(&*mesh); !mending) {
    return mending.error();
  }
  const Result<FoundSymmetry> symmetry = MeasureSymmetry(*mesh);
  if (!symmetry) return symmetry.error();
  return BuildObjectModel(scan.name, std::move(mesh).value(), symmetry->group, scan.file, {});
}

}  // namespace

std::vector<std::string> ComparedModelNames() {
  std::vector<std::string> names(kGenerated.begin(), kGenerated.end());
  for (const Scan& scan : kScans) names.emplace_back(scan.name);
  return names;
}

Result<ObjectModel> MakeComparedModel(const std::string& name,
                                      const std::filesystem::path& meshes) {
  const auto scan = std::find_if(
      kScans.begin(), kScans.end(), [&](const Scan& each) { return name == each.name; });
  if (scan != kScans.end()) return MakeScannedModel(*scan, meshes);
  const Result<GeneratedObject> object = GenerateObject(name);
  if (!object) return object.error();
  return BuildObjectModel(name, object->mesh, object->symmetry, "generated", {});
}

}  // namespace vantage
