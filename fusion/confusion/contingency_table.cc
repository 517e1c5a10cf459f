#include "fusion/confusion/contingency_table.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/check.h"
#include "common/format.h"
#include "common/so3.h"

namespace vantage {
namespace {

constexpr double kStep = DifferenceCount::kStepDeg * kDegree;
constexpr double kStepsOfHalfTurn = 180.0 / DifferenceCount::kStepDeg;

std::array<int16_t, 3> Rounded(const Eigen::Vector3d& steps) {
  std::array<int16_t, 3> rounded{};
  for (size_t i = 0; i < 3; ++i) {
    rounded[i] = static_cast<int16_t>(std::lround(steps[static_cast<Eigen::Index>(i)]));
  }
  return rounded;
}

// As Canonical() has it: the first of z, y, x that is not 0 is positive.
bool IsPositive(const std::array<int16_t, 3>& steps) {
  for (const size_t i : {2U, 1U, 0U}) {
    if (steps[i] != 0) return steps[i] > 0;
  }
  return true;
}

// Of texts of several lines the first line that differs.
std::string TextDifference(const char* field, const std::string& found, const std::string& wanted) {
  if (found == wanted) return {};
  size_t at = 0;
  while (at < std::min(found.size(), wanted.size()) && found[at] == wanted[at]) ++at;
  const size_t start = at == 0 ? 0 : found.rfind('\n', at - 1) + 1;  // npos + 1 = 0.
  const auto line = [&](const std::string& text) {
    return text.substr(start, text.find('\n', at) - start);
  };
  return Format("%s is \"%s\", expected \"%s\"", field, line(found).c_str(), line(wanted).c_str());
}

// What two parts know of one direction or row.
template <class Trials>
Result<void> MergeInto(const Trials& part, const std::string& what, Trials* whole) {
  if (part.trials == 0 || part == *whole) return {};
  if (whole->trials != 0) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s is in two parts and not the same: %d trials of which %d missed, and %d "
                        "of which %d",
                        what.c_str(),
                        whole->trials,
                        whole->missed,
                        part.trials,
                        part.missed)};
  }
  *whole = part;
  return {};
}

Result<void> MergeInto(const ContingencyTable& part, ContingencyTable* whole) {
  const std::string difference = part.key.DifferenceFrom(whole->key);
  if (!difference.empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("parts of different tables: %s as in the first part", difference.c_str())};
  }
  if (!part.directions.empty()) {
    const auto num_directions = static_cast<size_t>(part.key.num_directions);
    if (part.directions.size() != num_directions) {
      return Error{
          ErrorCode::kInvalidArgument,
          Format(
              "a part has %zu directions, expected %zu", part.directions.size(), num_directions)};
    }
    whole->directions.resize(num_directions);
  }
  for (size_t i = 0; i < part.directions.size(); ++i) {
    const Result<void> merged =
        MergeInto(part.directions[i], Format("direction %zu", i), &whole->directions[i]);
    if (!merged) return merged.error();
  }
  for (const auto& [ordinal, row] : part.rows) {
    const Result<void> merged = MergeInto(row, Format("row %d", ordinal), &whole->rows[ordinal]);
    if (!merged) return merged.error();
  }
  return {};
}

}  // namespace

std::string ContingencyKey::DifferenceFrom(const ContingencyKey& expected) const {
  const std::pair<const char*, std::string ContingencyKey::*> texts[] = {
      {"model", &ContingencyKey::model_id},
      {"mesh", &ContingencyKey::mesh_hash},
      {"estimator", &ContingencyKey::estimator},
      {"estimator parameter", &ContingencyKey::estimator_parameters},
      {"sensor", &ContingencyKey::sensor},
      {"stopping", &ContingencyKey::stopping}};
  for (const auto& [field, member] : texts) {
    std::string difference = TextDifference(field, this->*member, expected.*member);
    if (!difference.empty()) return difference;
  }
  if (seed != expected.seed) {
    return TextDifference("seed", std::to_string(seed), std::to_string(expected.seed));
  }
  if (num_directions != expected.num_directions) {
    return Format(
        "number of directions is %d, expected %d", num_directions, expected.num_directions);
  }
  if (rows_k != expected.rows_k) {
    return Format("k of the rows is %d, expected %d", rows_k, expected.rows_k);
  }
  return {};
}

Eigen::Quaterniond DifferenceCount::Difference() const {
  return ExpSo3(kStep * Eigen::Vector3d(steps[0], steps[1], steps[2]));
}

std::array<int16_t, 3> DifferenceCount::StepsOf(const Eigen::Quaterniond& difference) {
  VANTAGE_CHECK(difference.coeffs().allFinite(), "a difference rotation is finite");
  const Eigen::Vector3d vector = LogSo3(difference) / kStep;
  const std::array<int16_t, 3> steps = Rounded(vector);
  const double length = vector.norm();
  if (length < kStepsOfHalfTurn - 1.0 || IsPositive(steps)) return steps;
  return Rounded(vector * (1.0 - 2.0 * kStepsOfHalfTurn / length));  // The other way round.
}

int64_t ContingencyTable::NumTrials() const {
  int64_t trials = 0;
  for (const DirectionTrials& direction : directions) trials += direction.trials;
  for (const auto& [ordinal, row] : rows) trials += row.trials;
  return trials;
}

bool ContingencyTable::IsComplete() const {
  if (directions.size() != static_cast<size_t>(key.num_directions)) return false;
  for (const DirectionTrials& direction : directions) {
    if (direction.trials == 0) return false;
  }
  return true;
}

Result<ContingencyTable> MergeTables(const std::vector<ContingencyTable>& parts) {
  if (parts.empty()) {
    return Error{ErrorCode::kInvalidArgument, "0 parts of a table to merge, expected at least 1"};
  }
  ContingencyTable whole;
  whole.key = parts.front().key;
  for (const ContingencyTable& part : parts) {
    if (Result<void> merged = MergeInto(part, &whole); !merged) return merged.error();
  }
  return whole;
}

}  // namespace vantage
