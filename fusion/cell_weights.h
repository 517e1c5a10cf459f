#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "fusion/so3_grid.h"

namespace vantage {

/// One number a cell of the grid, 0 where none was written. Storage comes in pages of neighboring
/// cells, so that few touched cells take little and all of them 4 bytes each: 17.6 MB at k = 64.
/// Every page knows a bound of its largest weight: who looks for the heaviest cells skips the rest.
class CellWeights {
 public:
  struct Entry {
    So3Grid::Cell cell;
    float weight;

    bool operator==(const Entry&) const = default;
  };
  /// The same by its place (So3Grid::Ordinal).
  struct Placed {
    int32_t ordinal;
    float weight;
  };

  /// @param grid outlives the weights.
  explicit CellWeights(const So3Grid& grid);
  CellWeights(const CellWeights& other);
  CellWeights& operator=(const CellWeights& other);
  CellWeights(CellWeights&&) noexcept = default;
  CellWeights& operator=(CellWeights&&) noexcept = default;
  ~CellWeights() = default;

  /// The weight of the cell at a place (So3Grid::Ordinal).
  [[nodiscard]] float At(int32_t ordinal) const {
    const int32_t page = page_of_[static_cast<size_t>(ordinal / kPageSize)];
    return page < 0 ? 0.0F : PageAt(page)[Within(ordinal)];
  }
  /// Adds to a cell's weight; an amount below 0 leaves the bounds as they are.
  void Add(int32_t ordinal, float amount) {
    int32_t& page = page_of_[static_cast<size_t>(ordinal / kPageSize)];
    if (page < 0) page = AppendPage(ordinal / kPageSize);
    float& weight = PageAt(page)[Within(ordinal)];
    weight += amount;
    float& bound = bounds_[static_cast<size_t>(page)].weight;
    bound = bound < weight ? weight : bound;
  }
  /// Multiplies all weights by a factor > 0.
  void Scale(float factor);

  /// The largest weight; 0 when there is none. Costs the pages.
  [[nodiscard]] float Largest() const;
  /// Cells of `threshold` or more, threshold > 0, by place. Costs the pages and the cells found.
  [[nodiscard]] std::vector<Placed> AtLeast(float threshold) const;
  /// Cells with a weight other than 0, ascending.
  [[nodiscard]] std::vector<Entry> Entries() const;

  [[nodiscard]] const So3Grid& grid() const { return *grid_; }
  /// Size of the storage, bytes.
  [[nodiscard]] size_t bytes() const;

 private:
  static constexpr int32_t kPageSize = 128;
  static constexpr int32_t kChunkSize = 32;
  using Page = std::array<float, kPageSize>;
  using Chunk = std::array<Page, kChunkSize>;  // 16 kB: what heaps keep for the next one.
  struct Bound {
    int32_t first;  // Ordinal of the page's first cell.
    float weight;   // At least the page's largest weight.
  };

  [[nodiscard]] Page& PageAt(int32_t page) const {
    return (
        *chunks_[static_cast<size_t>(page / kChunkSize)])[static_cast<size_t>(page % kChunkSize)];
  }
  static size_t Within(int32_t ordinal) { return static_cast<size_t>(ordinal % kPageSize); }
  int32_t AppendPage(int32_t place);

  const So3Grid* grid_;
  std::vector<int32_t> page_of_;                // By ordinal / kPageSize; -1: no page.
  std::vector<std::unique_ptr<Chunk>> chunks_;  // Of pages in the order of their first writing.
  std::vector<Bound> bounds_;                   // By page.
};

}  // namespace vantage
