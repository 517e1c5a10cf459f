#include "fusion/confusion/two_sample_test.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

#include "common/check.h"
#include "common/format.h"

namespace vantage {
namespace {

Error TooMany(const char* what, int trials) {
  return {
      ErrorCode::kInvalidArgument,
      Format("a %s has %d trials, expected at most %d to compare", what, trials, kMostOutcomes)};
}

float Chord(const TrialOutcome& a, const TrialOutcome& b) {
  if (!a || !b) return a.has_value() == b.has_value() ? 0.0F : 1.0F;
  return static_cast<float>((a->conjugate() * *b).vec().norm());
}

// Distances within a pooled sample, of which a part is the first sample.
class Distances {
 public:
  explicit Distances(const std::vector<TrialOutcome>& pooled)
      : size_(pooled.size()), values_(size_ * size_) {
    for (size_t i = 0; i < size_; ++i) {
      double sum = 0.0;
      for (size_t j = 0; j < size_; ++j) {
        const float distance = j < i ? values_[j * size_ + i] : Chord(pooled[i], pooled[j]);
        values_[i * size_ + j] = distance;
        sum += distance;
      }
      of_one_.push_back(sum);
      total_ += sum;
    }
  }

  // With the sums S over pairs within and between, S_aa + 2 S_ab + S_bb is the total, and
  // S_aa + S_ab the members' distances to all: what is to be summed for each permutation is S_aa.
  [[nodiscard]] double Energy(const std::vector<size_t>& members_of_a) const {
    double within_a = 0.0;
    double of_a = 0.0;
    for (size_t i = 0; i < members_of_a.size(); ++i) {
      const float* row = &values_[members_of_a[i] * size_];
      double sum = 0.0;
      for (size_t j = 0; j < i; ++j) sum += row[members_of_a[j]];
      within_a += 2.0 * sum;
      of_a += of_one_[members_of_a[i]];
    }
    const double between = of_a - within_a;
    const double within_b = total_ - within_a - 2.0 * between;
    const auto n = static_cast<double>(members_of_a.size());
    const double m = static_cast<double>(size_) - n;
    return 2.0 * between / (n * m) - within_a / (n * n) - within_b / (m * m);
  }

 private:
  size_t size_;
  std::vector<float> values_;
  std::vector<double> of_one_;  // Sum of one's distances to all.
  double total_ = 0.0;
};

}  // namespace

Result<std::vector<TrialOutcome>> OutcomesOf(const DirectionTrials& direction) {
  if (direction.trials > kMostOutcomes) return TooMany("direction", direction.trials);
  std::vector<TrialOutcome> outcomes(static_cast<size_t>(direction.missed));
  for (const DifferenceCount& difference : direction.differences) {
    outcomes.insert(outcomes.end(), static_cast<size_t>(difference.count), difference.Difference());
  }
  return outcomes;
}

Result<std::vector<TrialOutcome>> OutcomesOf(const RowTrials& row, const So3Grid& grid) {
  if (row.trials > kMostOutcomes) return TooMany("row", row.trials);
  std::vector<TrialOutcome> outcomes(static_cast<size_t>(row.missed));
  std::vector<So3Grid::Cell> cell;
  for (const RowTrials::Count& detected : row.detected) {
    grid.CellsAt(detected.ordinal, 1, &cell);
    outcomes.insert(
        outcomes.end(), static_cast<size_t>(detected.count), grid.Representative(cell.front()));
  }
  return outcomes;
}

Result<TwoSampleTest> EnergyTest(const std::vector<TrialOutcome>& a,
                                 const std::vector<TrialOutcome>& b,
                                 int permutations,
                                 Rng& rng) {
  VANTAGE_CHECK(permutations > 0, "a permutation test needs permutations");
  for (const std::vector<TrialOutcome>* sample : {&a, &b}) {
    if (sample->empty() || sample->size() > size_t{kMostOutcomes}) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("a sample to compare has %zu outcomes, expected 1 to %d",
                          sample->size(),
                          kMostOutcomes)};
    }
  }
  // The smaller one is summed over.
  const std::vector<TrialOutcome>& smaller = a.size() <= b.size() ? a : b;
  const std::vector<TrialOutcome>& larger = a.size() <= b.size() ? b : a;
  std::vector<TrialOutcome> pooled = smaller;
  pooled.insert(pooled.end(), larger.begin(), larger.end());
  const Distances distances(pooled);

  std::vector<size_t> order(pooled.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::vector<size_t> members(smaller.size());
  std::copy_n(order.begin(), members.size(), members.begin());
  const double statistic = distances.Energy(members);
  // Sums of another order differ by rounding: equal is what differs by no more.
  const double not_below = statistic - 1e-9;
  int as_large = 0;
  for (int i = 0; i < permutations; ++i) {
    for (size_t j = 0; j < members.size(); ++j) {  // The first steps of Fisher and Yates's shuffle.
      std::swap(order[j], order[j + rng.Below(static_cast<uint32_t>(order.size() - j))]);
    }
    std::copy_n(order.begin(), members.size(), members.begin());
    as_large += distances.Energy(members) >= not_below ? 1 : 0;
  }
  return TwoSampleTest{std::max(0.0, statistic), (1.0 + as_large) / (1.0 + permutations)};
}

}  // namespace vantage
