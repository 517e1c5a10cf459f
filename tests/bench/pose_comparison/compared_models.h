#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/result.h"
#include "perception/model/object_model.h"

namespace vantage {

/// Objects of which poses are estimated: some that this project makes itself and, where `meshes`
/// has them, well-known scans, whose symmetry is measured.
std::vector<std::string> ComparedModelNames();

/// Errors: no such name, a scan that is not in `meshes` (kNotFound), a mesh that can't be used.
Result<ObjectModel> MakeComparedModel(const std::string& name, const std::filesystem::path& meshes);

}  // namespace vantage
