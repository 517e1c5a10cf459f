#pragma once

#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "common/result.h"

namespace vantage {

/// A measurement as Google Benchmark's JSON has it, for vantage-bench-table.
inline nlohmann::json BenchRow(const std::string& name, double value, const std::string& unit) {
  return {
      {"run_name", name}, {"aggregate_name", "median"}, {"cpu_time", value}, {"time_unit", unit}};
}

/// Errors: the file can't be written.
inline Result<void> WriteBenchRows(const nlohmann::json& rows, const std::string& file) {
  const nlohmann::json document = {{"context", {{"num_cpus", sysconf(_SC_NPROCESSORS_ONLN)}}},
                                   {"benchmarks", rows}};
  std::ofstream stream(file);
  stream << document.dump(1) << '\n';
  stream.flush();
  if (!stream) return Error{ErrorCode::kIo, file + " can't be written"};
  return {};
}

}  // namespace vantage
