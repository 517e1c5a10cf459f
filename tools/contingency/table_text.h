#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fusion/confusion/contingency_table.h"

namespace vantage {

/// What came of the trials from one direction.
struct DirectionSummary {
  int32_t direction = 0;
  int32_t trials = 0;
  int32_t missed = 0;
  int32_t turned = 0;  ///< detected, but kTurned or farther from the truth

  /// Share of trials that did not give the truth; 0 without trials.
  [[nodiscard]] double Ambiguity() const;
};

/// rad, no error of a right detection is as large. Symmetry is not looked at: a symmetric object is
/// turned in most trials.
inline constexpr double kTurned = 0.2618;  // 15 deg

/// Of the directions that have trials, the most ambiguous first, ties by index.
std::vector<DirectionSummary> SummarizeDirections(const ContingencyTable& table);

/// Directions without trials, ascending.
std::vector<int32_t> MissingDirections(const ContingencyTable& table);

/// For people: key, trials, what is complete, the most ambiguous directions.
/// @param bytes of the file.
std::string TableText(const ContingencyTable& table, uintmax_t bytes);

/// One line a measured direction, ascending: direction, its middle, trials, missed, turned.
std::string TableCsv(const ContingencyTable& table);

}  // namespace vantage
