#include "perception/model/object_model.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <system_error>

#include "common/format.h"
#include "perception/model/file_bytes.h"
#include "perception/model/model_toml.h"
#include "perception/model/ply_file.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr size_t kLargestToml = 1U << 20U;  // bytes
constexpr const char* kTomlName = "model.toml";
constexpr const char* kMeshName = "mesh.ply";
constexpr const char* kSamplesName = "samples.ply";

constexpr uint64_t kFnvOffset = 0xcbf29ce484222325ULL;
constexpr uint64_t kFnvPrime = 0x100000001b3ULL;

uint64_t HashBytes(const void* data, size_t size, uint64_t hash) {
  const auto* bytes = static_cast<const unsigned char*>(data);
  for (size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * kFnvPrime;
  return hash;
}

// The folder's own name, also of "models/filter/" and ".".
std::string NameOf(const fs::path& folder) {
  std::error_code error;
  fs::path absolute = fs::weakly_canonical(folder, error);
  if (error) absolute = folder.lexically_normal();
  if (absolute.filename().empty()) absolute = absolute.parent_path();
  return absolute.filename().string();
}

// Diameter and centre are not computed again at every start; that they can belong to the mesh is.
Result<void> CheckAgainstMesh(const ModelDescription& description,
                              const TriangleMesh& mesh,
                              const fs::path& file) {
  if (mesh.triangles.empty()) {
    return Error{ErrorCode::kCorrupt, Format("%s beside it has no triangles", file.c_str())};
  }
  const uint64_t hash = HashMesh(mesh);
  if (hash != description.mesh_hash) {
    return Error{ErrorCode::kCorrupt,
                 Format("%s: mesh_hash is %016jx, but %s has %016jx; build the model again with: "
                        "vantage-model build",
                        file.c_str(),
                        uintmax_t{description.mesh_hash},
                        kMeshName,
                        uintmax_t{hash})};
  }
  const Eigen::AlignedBox3d box = mesh.Bounds().cast<double>();
  const double shortest = 0.95 * box.sizes().maxCoeff();
  const double longest = 1.05 * box.sizes().norm();
  if (description.diameter < shortest || description.diameter > longest) {
    return Error{ErrorCode::kCorrupt,
                 Format("%s: diameter_m = %g, expected %g to %g for its mesh",
                        file.c_str(),
                        description.diameter,
                        shortest,
                        longest)};
  }
  if (box.exteriorDistance(description.center) > 1e-6) {
    return Error{ErrorCode::kCorrupt, Format("%s: center_m lies outside its mesh", file.c_str())};
  }
  return {};
}

Result<void> WriteFiles(const ObjectModel& model, const fs::path& folder) {
  ModelDescription description;
  description.id = model.id;
  description.diameter = model.diameter;
  description.center = model.center;
  description.symmetry = model.symmetry;
  description.mesh_hash = model.mesh_hash;
  description.source = model.source;
  description.num_samples = model.samples.size();
  if (Result<void> written = WriteMeshPly(model.mesh, folder / kMeshName); !written) {
    return written;
  }
  if (Result<void> written = WriteSamplesPly(model.samples, folder / kSamplesName); !written) {
    return written;
  }
  return WriteFileBytes(folder / kTomlName, WriteModelToml(description));
}

// Puts the finished `temporary` in the place of `folder`, whatever state other processes see is
// whole.
Result<void> PutInPlace(const fs::path& temporary, const fs::path& folder) {
  if (::renameat2(AT_FDCWD, temporary.c_str(), AT_FDCWD, folder.c_str(), RENAME_NOREPLACE) == 0) {
    return {};
  }
  if (errno == EEXIST &&
      ::renameat2(AT_FDCWD, temporary.c_str(), AT_FDCWD, folder.c_str(), RENAME_EXCHANGE) == 0) {
    return {};  // The old folder is now the temporary one.
  }
  return Error{
      ErrorCode::kIo,
      Format("model folder %s can't be put in place: %s", folder.c_str(), std::strerror(errno))};
}

}  // namespace

uint64_t HashMesh(const TriangleMesh& mesh) {
  uint64_t hash = kFnvOffset;
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    hash = HashBytes(vertex.data(), 3 * sizeof(float), hash);
  }
  for (const auto& triangle : mesh.triangles) {
    hash = HashBytes(triangle.data(), 3 * sizeof(uint32_t), hash);
  }
  return hash;
}

Result<void> CheckModelId(const std::string& id) {
  constexpr size_t kLongest = 64;
  const bool letters =
      id.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-") ==
      std::string::npos;
  if (id.empty() || id.size() > kLongest || !letters || id.front() == '-') {
    return Error{ErrorCode::kInvalidArgument,
                 Format("model id \"%s\", expected 1 to %zu of A-Z a-z 0-9 _ - not starting with -",
                        id.substr(0, 2 * kLongest).c_str(),
                        kLongest)};
  }
  return {};
}

Result<ObjectModel> LoadObjectModel(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    return Error{ErrorCode::kNotFound,
                 Format("no model folder %s, expected one made with: vantage-model generate or "
                        "vantage-model build",
                        folder.c_str())};
  }
  const fs::path toml_file = folder / kTomlName;
  for (const char* name : {kTomlName, kMeshName, kSamplesName}) {
    if (fs::exists(folder / name, error)) continue;
    return Error{ErrorCode::kNotFound,
                 Format("model folder %s has no %s; make the model again with: vantage-model build "
                        "(or generate)",
                        folder.c_str(),
                        name)};
  }
  const Result<std::string> text = ReadFileBytes(toml_file, kLargestToml);
  if (!text) return text.error();
  Result<ModelDescription> description = ReadModelToml(*text, toml_file);
  if (!description) return description.error();
  if (Result<void> fits = CheckModelId(description->id); !fits) {
    return Error{fits.error().code, toml_file.string() + ": " + fits.error().message};
  }
  if (const std::string name = NameOf(folder); description->id != name) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s: id = \"%s\", expected the folder's name \"%s\"; rename one of them",
                        toml_file.c_str(),
                        description->id.c_str(),
                        name.c_str())};
  }
  Result<TriangleMesh> mesh = ReadMeshPly(folder / kMeshName);
  if (!mesh) return mesh.error();
  if (Result<void> fits = CheckAgainstMesh(*description, *mesh, toml_file); !fits) {
    return fits.error();
  }
  Result<std::vector<SurfacePoint>> samples = ReadSamplesPly(folder / kSamplesName);
  if (!samples) return samples.error();
  if (samples->size() != description->num_samples) {
    return Error{ErrorCode::kCorrupt,
                 Format("%s: num_samples = %zu, but %s has %zu",
                        toml_file.c_str(),
                        description->num_samples,
                        kSamplesName,
                        samples->size())};
  }
  ObjectModel model;
  model.id = description->id;
  model.mesh = std::move(mesh).value();
  model.samples = std::move(samples).value();
  model.center = description->center;
  model.diameter = description->diameter;
  model.symmetry = description->symmetry;
  model.mesh_hash = description->mesh_hash;
  model.source = description->source;
  return model;
}

Result<void> SaveObjectModel(const ObjectModel& model,
                             const fs::path& folder,
                             const ModelFileWriter& add_files) {
  if (Result<void> fits = CheckModelId(model.id); !fits) return fits;
  fs::path target = folder.lexically_normal();
  if (target.filename().empty()) target = target.parent_path();
  if (target.filename() != model.id) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("model folder %s, expected the model's id \"%s\" as its name",
                        folder.c_str(),
                        model.id.c_str())};
  }
  std::error_code error;
  if (fs::exists(target, error) && !fs::exists(target / kTomlName, error)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s exists and is no model folder, expected a free name or a model folder",
                        target.c_str())};
  }
  const fs::path parent = target.has_parent_path() ? target.parent_path() : fs::path(".");
  fs::create_directories(parent, error);
  std::string temporary = (parent / ("." + model.id + ".XXXXXX")).string();
  if (error || ::mkdtemp(temporary.data()) == nullptr) {
    return Error{ErrorCode::kIo,
                 Format("model folder %s can't be written: %s",
                        target.c_str(),
                        error ? error.message().c_str() : std::strerror(errno))};
  }
  Result<void> saved = WriteFiles(model, temporary);
  if (saved && add_files) saved = add_files(temporary);
  if (saved) {
    // mkdtemp makes folders that only their owner may enter.
    fs::permissions(temporary,
                    fs::perms::owner_all | fs::perms::group_read | fs::perms::group_exec |
                        fs::perms::others_read | fs::perms::others_exec,
                    error);
    saved = PutInPlace(temporary, target);
  }
  fs::remove_all(temporary, error);
  return saved;
}

}  // namespace vantage
