#include "fusion/cell_weights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "common/rng.h"

namespace vantage {
namespace {

// The same weights in a map from the cell's place, added in the same precision.
class MapOfWeights {
 public:
  void Add(int32_t ordinal, float amount) { weights_[ordinal] += amount; }
  void Scale(float factor) {
    for (auto& [ordinal, weight] : weights_) weight *= factor;
  }

  void ExpectSame(const CellWeights& weights) const {
    const So3Grid& grid = weights.grid();
    float largest = 0.0F;
    std::map<So3Grid::Cell, float> by_cell;
    std::vector<So3Grid::Cell> all;
    grid.CellsAt(0, grid.num_cells(), &all);
    for (int32_t i = 0; i < grid.num_cells(); ++i) {
      const auto found = weights_.find(i);
      const float weight = found == weights_.end() ? 0.0F : found->second;
      ASSERT_EQ(weights.At(i), weight) << i;
      if (weight != 0.0F) by_cell[all[static_cast<size_t>(i)]] = weight;
      largest = std::max(largest, weight);
    }
    EXPECT_EQ(weights.Largest(), largest);
    const std::vector<CellWeights::Entry> entries = weights.Entries();
    ASSERT_EQ(entries.size(), by_cell.size());
    EXPECT_TRUE(std::equal(
        entries.begin(), entries.end(), by_cell.begin(), [](const auto& entry, const auto& pair) {
          return entry.cell == pair.first && entry.weight == pair.second;
        }));
    if (largest <= 0.0F) {
      EXPECT_TRUE(weights.AtLeast(1e-30F).empty());
      return;
    }
    for (const float share : {0.01F, 0.5F, 0.9F, 1.0F}) ExpectSameAbove(share * largest, weights);
  }

 private:
  void ExpectSameAbove(float threshold, const CellWeights& weights) const {
    std::vector<CellWeights::Placed> expected;
    for (const auto& [ordinal, weight] : weights_) {
      if (weight >= threshold) expected.push_back({ordinal, weight});
    }
    const std::vector<CellWeights::Placed> found = weights.AtLeast(threshold);
    ASSERT_EQ(found.size(), expected.size()) << threshold;
    for (size_t i = 0; i < found.size(); ++i) {
      ASSERT_EQ(found[i].ordinal, expected[i].ordinal);
      ASSERT_EQ(found[i].weight, expected[i].weight);
    }
  }

  std::map<int32_t, float> weights_;
};

// Amounts of both signs, so that the bound of a page is at times above all that it holds.
TEST(CellWeights, EqualAMap) {
  Rng rng(1);
  for (const int k : {2, 5, 8}) {
    const So3Grid grid(k);
    CellWeights weights(grid);
    MapOfWeights expected;
    expected.ExpectSame(weights);
    for (int round = 0; round < 60; ++round) {
      const auto num_cells = static_cast<uint32_t>(grid.num_cells());
      const uint32_t first = rng.Below(num_cells);
      for (int i = 0; i < 40; ++i) {
        // In runs, as kernels touch them, and anywhere.
        const uint32_t place = i % 2 == 0 ? first + rng.Below(20) : rng.Below(num_cells);
        const auto ordinal = static_cast<int32_t>(place % num_cells);
        const auto amount = static_cast<float>(rng.Uniform(-0.5, 1.0));
        weights.Add(ordinal, amount);
        expected.Add(ordinal, amount);
        if (rng.Below(10) != 0) continue;
        const float all = weights.At(ordinal);
        weights.Add(ordinal, -all);
        expected.Add(ordinal, -all);
      }
      if (round % 7 == 3) {
        const auto factor = static_cast<float>(rng.Uniform(0.01, 3.0));
        weights.Scale(factor);
        expected.Scale(factor);
      }
      ASSERT_NO_FATAL_FAILURE(expected.ExpectSame(weights)) << "k " << k << " round " << round;
    }
  }
}

TEST(CellWeights, TheLargestOneTakenAwayIsFoundAnew) {
  const So3Grid grid(8);
  CellWeights weights(grid);
  weights.Add(5, 10.0F);
  weights.Add(6, 2.0F);
  weights.Add(4000, 3.0F);
  weights.Add(5, -9.5F);
  EXPECT_EQ(weights.Largest(), 3.0F);
  weights.Add(4000, -3.0F);
  EXPECT_EQ(weights.Largest(), 2.0F);
  EXPECT_EQ(weights.AtLeast(1.0F).size(), 1U);
  weights.Add(6, -4.0F);
  weights.Add(5, -1.0F);
  EXPECT_EQ(weights.Largest(), 0.0F);  // Nothing above 0 is left.
  EXPECT_EQ(weights.Entries().size(), 2U);
}

TEST(CellWeights, ACopyIsItsOwn) {
  const So3Grid grid(8);
  CellWeights weights(grid);
  weights.Add(77, 1.0F);
  CellWeights copy = weights;
  copy.Add(77, 1.0F);
  copy.Add(5000, 1.0F);
  EXPECT_EQ(weights.At(77), 1.0F);
  EXPECT_EQ(weights.At(5000), 0.0F);
  EXPECT_EQ(copy.At(77), 2.0F);
  copy = weights;
  EXPECT_EQ(copy.Entries(), weights.Entries());
  copy.Add(78, 3.0F);
  EXPECT_EQ(weights.Largest(), 1.0F);
  const CellWeights moved = std::move(copy);
  EXPECT_EQ(moved.At(78), 3.0F);
  EXPECT_EQ(moved.At(77), 1.0F);
}

TEST(CellWeights, FineGridsFitIntoLittle) {
  struct Budget {
    int k;
    size_t bytes;
  };
  for (const auto& [k, bytes] : {Budget{64, 20'000'000}, Budget{128, 160'000'000}}) {
    const So3Grid grid(k);
    CellWeights weights(grid);
    const size_t empty = weights.bytes();
    EXPECT_LT(empty, bytes / 80) << k;
    for (int32_t i = 0; i < grid.num_cells(); ++i) weights.Add(i, 1.0F);
    EXPECT_GE(weights.bytes(), sizeof(float) * static_cast<size_t>(grid.num_cells()));
    EXPECT_LE(grid.bytes() + weights.bytes(), bytes) << k;
  }
}

}  // namespace
}  // namespace vantage
