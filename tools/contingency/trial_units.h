#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"

namespace vantage {

/// What of a table is to be measured: cells of viewing directions and rows, each one unit of work.
struct TrialUnits {
  std::vector<int32_t> directions;  ///< ascending, each once
  std::vector<int32_t> rows;        ///< ordinals; ascending, each once

  [[nodiscard]] size_t size() const { return directions.size() + rows.size(); }
  bool operator==(const TrialUnits&) const = default;
};

/// One of several equal parts of the work.
struct Shard {
  int index = 1;  ///< from 1
  int count = 1;
};

/// "2/8". Errors: anything but an index from 1 to the count, which is at most 100,000.
Result<Shard> ParseShard(const std::string& text);

/// Every count-th unit: neighbors, which take about equally long, go to different shards.
TrialUnits UnitsOf(const Shard& shard, const TrialUnits& all);

/// Rows by ordinal, "0,17,100-140", or "random:20" of them drawn by the seed; empty: none.
/// Errors: anything else; an ordinal that is not below num_cells; more random rows than there are.
Result<std::vector<int32_t>> ParseRows(const std::string& text, int num_cells, uint64_t seed);

/// "3-7, 9": ascending numbers for people, at most `most` parts of them.
std::string RangesText(const std::vector<int32_t>& numbers, size_t most);

}  // namespace vantage
