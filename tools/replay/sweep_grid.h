#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "common/result.h"
#include "nodes/config_override.h"

namespace vantage {

/// A key of the configuration and the values that it takes.
struct SweepParameter {
  std::string key;                    ///< "fusion.sigma_deg"
  std::vector<std::string> literals;  ///< as TOML
};

/// Every combination of the parameters' values is a cell; the last parameter changes fastest.
struct SweepGrid {
  std::vector<SweepParameter> parameters;

  [[nodiscard]] size_t num_cells() const;
  /// Which value each parameter has in a cell.
  [[nodiscard]] std::vector<size_t> Places(size_t cell) const;
  [[nodiscard]] std::vector<ConfigOverride> Overrides(size_t cell) const;
  /// "fusion.sigma_deg = 4, ppf.seed = 1"
  [[nodiscard]] std::string CellText(size_t cell) const;
};

inline constexpr size_t kMostSweepCells = 10'000;

/// Reads a TOML file with a table [grid]: "fusion.sigma_deg" = [2, 4, 8], with or without quotes
/// round the key. Errors: the file; another key; no grid; a value that is no list or an empty one;
/// a key that is none; more than kMostSweepCells cells.
Result<SweepGrid> ReadSweepGrid(const std::filesystem::path& file);

}  // namespace vantage
