#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/result.h"

namespace vantage {

/// What a table was measured with. Tables with equal keys can be merged.
struct ContingencyKey {
  std::string model_id;
  std::string mesh_hash;             ///< ObjectModel's, hexadecimal
  std::string estimator;             ///< "ppf" or "shot"
  std::string estimator_parameters;  ///< all of them, as text
  std::string sensor;                ///< the simulated sensor and how it looks, as text
  std::string stopping;              ///< how many trials each entry gets, as text
  uint64_t seed = 1;
  int num_directions = 0;  ///< of the DirectionGrid; 0: no trials by direction
  int rows_k = 0;          ///< of the So3Grid of the rows; 0: no rows

  bool operator==(const ContingencyKey&) const = default;
  /// Which field differs first and both values ("estimator is "ppf", expected "shot""), of texts of
  /// several lines the first line that differs. Empty for equal keys.
  [[nodiscard]] std::string DifferenceFrom(const ContingencyKey& expected) const;
};

/// A difference rotation q' = q_GT* q_D (paper eq. 12) and how often it was seen. Kept as a
/// rotation vector in steps of kStep: finer than any grid, so valid at every k.
struct DifferenceCount {
  static constexpr double kStepDeg = 0.25;  ///< deg

  std::array<int16_t, 3> steps{};
  int32_t count = 0;

  [[nodiscard]] Eigen::Quaterniond Difference() const;
  /// Steps of a rotation, of norm 1; the same for q and -q. Difference() of them lies within 0.22
  /// deg. Of the two ways to write a rotation by nearly pi one is taken, so that half turns about
  /// an axis are not kept apart by its sign.
  static std::array<int16_t, 3> StepsOf(const Eigen::Quaterniond& difference);
  bool operator==(const DifferenceCount&) const = default;
};

/// Trials from one cell of viewing directions (the left-invariant way to measure a row).
struct DirectionTrials {
  int32_t trials = 0;                        ///< 0: never measured
  int32_t missed = 0;                        ///< of them, in which nothing was detected
  std::vector<DifferenceCount> differences;  ///< ascending by steps; counts sum to trials - missed

  bool operator==(const DirectionTrials&) const = default;
};

/// A row of the contingency table as the paper measures it (6.2): trials of one ground truth
/// orientation of the camera's frame, at one roll.
struct RowTrials {
  struct Count {
    int32_t ordinal = 0;  ///< of the detected cell, So3Grid::Ordinal
    int32_t count = 0;
    bool operator==(const Count&) const = default;
  };
  int32_t trials = 0;
  int32_t missed = 0;
  std::vector<Count> detected;  ///< ascending

  bool operator==(const RowTrials&) const = default;
};

/// How often each orientation was detected when another one was the real one (paper 6.1, 6.2).
struct ContingencyTable {
  ContingencyKey key;
  std::vector<DirectionTrials> directions;  ///< num_directions, or empty
  std::map<int32_t, RowTrials> rows;        ///< by the truth's ordinal; any subset

  [[nodiscard]] int64_t NumTrials() const;
  /// False while a direction has no trials.
  [[nodiscard]] bool IsComplete() const;
  bool operator==(const ContingencyTable&) const = default;
};

/// The union of parts of one table. Errors: keys differ (which field, both values), an entry is in
/// two parts with different counts.
Result<ContingencyTable> MergeTables(const std::vector<ContingencyTable>& parts);

}  // namespace vantage
