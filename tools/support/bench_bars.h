#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "common/result.h"

namespace vantage {

/// What a benchmark is held against.
struct BenchBar {
  std::optional<double> limit;  ///< in the benchmark's own unit
  bool is_least = false;        ///< The limit is a lower bound.
  std::string peer;             ///< another benchmark of the same run; may be empty
  bool is_peers = false;        ///< What the peer takes is the limit.
  bool is_optional = false;     ///< It needs data that may be absent, and then does not run.

  [[nodiscard]] bool IsMetBy(double value) const {
    return !limit || (is_least ? value >= *limit : value <= *limit);
  }
};

/// Of one part, by the benchmark's name. Lines: part,benchmark,bar,peer; a bar is an upper bound,
/// or a lower one after ">=", or "peer", or empty; a name after "?" is optional. Errors name file
/// and line.
Result<std::map<std::string, BenchBar>> ReadBenchBars(const std::filesystem::path& file,
                                                      const std::string& part);

}  // namespace vantage
