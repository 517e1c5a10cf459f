#pragma once

#include <cstdint>
#include <string>

#include "common/result.h"
#include "perception/model/object_model.h"
#include "perception/model/surface_samples.h"

namespace vantage {

struct ModelBuildParameters {
  SurfaceSampleParameters samples;
  uint64_t seed = 1;

  Result<void> Validate() const { return samples.Validate(); }
};

/// Makes a model of a mesh that has passed CheckAndMendMesh: centre, diameter, samples and hash.
/// Errors: parameters, or nothing of the surface can be seen from outside.
Result<ObjectModel> BuildObjectModel(const std::string& id,
                                     TriangleMesh mesh,
                                     const SymmetryGroup& symmetry,
                                     const std::string& source,
                                     const ModelBuildParameters& parameters);

}  // namespace vantage
