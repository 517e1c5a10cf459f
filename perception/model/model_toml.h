#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "common/result.h"
#include "common/symmetry_group.h"

namespace vantage {

/// What model.toml says of a model.
struct ModelDescription {
  std::string id;
  double diameter = 0.0;                             ///< m
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< m
  SymmetryGroup symmetry;
  uint64_t mesh_hash = 0;
  std::string source;
  size_t num_samples = 0;
};

/// The same description gives the same text, and reading it gives every number back exactly.
std::string WriteModelToml(const ModelDescription& description);

/// @param file what stands for the file in errors.
/// Errors: no TOML (with line and column), keys that are absent, unknown, of another type or out of
/// range.
Result<ModelDescription> ReadModelToml(const std::string& text, const std::filesystem::path& file);

}  // namespace vantage
