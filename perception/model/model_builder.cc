#include "perception/model/model_builder.h"

#include <cmath>
#include <utility>

#include "common/format.h"

namespace vantage {

Result<ObjectModel> BuildObjectModel(const std::string& id,
                                     TriangleMesh mesh,
                                     const SymmetryGroup& symmetry,
                                     const std::string& source,
                                     const ModelBuildParameters& parameters) {
  if (Result<void> fits = CheckModelId(id); !fits) return fits.error();
  if (Result<void> fits = parameters.Validate(); !fits) return fits.error();
  constexpr size_t kFewest = 10;
  ObjectModel model;
  model.id = id;
  model.mesh = std::move(mesh);
  model.symmetry = symmetry;
  model.source = source;
  // Whole nanometres: model.toml is for people too.
  const auto rounded = [](double metres) { return std::round(1e9 * metres) / 1e9 + 0.0; };
  model.diameter = rounded(model.mesh.Diameter());
  model.center = model.mesh.SurfaceCentroid().unaryExpr(rounded);
  model.mesh_hash = HashMesh(model.mesh);
  Rng rng(parameters.seed);
  model.samples = SampleVisibleSurface(model.mesh, model.diameter, parameters.samples, rng);
  if (model.samples.size() < kFewest) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("model \"%s\" got %zu surface samples, expected at least %zu",
                        id.c_str(),
                        model.samples.size(),
                        kFewest)};
  }
  return model;
}

}  // namespace vantage
