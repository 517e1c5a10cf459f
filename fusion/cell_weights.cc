#include "fusion/cell_weights.h"

#include <algorithm>

namespace vantage {

CellWeights::CellWeights(const So3Grid& grid)
    : grid_(&grid), page_of_(static_cast<size_t>((grid.num_cells() - 1) / kPageSize + 1), -1) {}

CellWeights::CellWeights(const CellWeights& other)
    : grid_(other.grid_), page_of_(other.page_of_), bounds_(other.bounds_) {
  for (const auto& chunk : other.chunks_) chunks_.push_back(std::make_unique<Chunk>(*chunk));
}

CellWeights& CellWeights::operator=(const CellWeights& other) {
  if (this != &other) *this = CellWeights(other);
  return *this;
}

int32_t CellWeights::AppendPage(int32_t place) {
  const auto page = static_cast<int32_t>(bounds_.size());
  if (page / kChunkSize == static_cast<int32_t>(chunks_.size())) {
    // Not all of it is used in most histograms: a page is cleared when it is.
    chunks_.push_back(std::make_unique_for_overwrite<Chunk>());
  }
  PageAt(page).fill(0.0F);
  // A vector that doubles would ask for three times the storage at its last step.
  if (bounds_.size() == bounds_.capacity() && bounds_.size() > 4096) {
    bounds_.reserve(std::min(page_of_.size(), bounds_.size() + bounds_.size() / 8));
  }
  bounds_.push_back({place * kPageSize, 0.0F});
  return page;
}

void CellWeights::Scale(float factor) {
  for (size_t page = 0; page < bounds_.size(); ++page) {
    for (float& weight : PageAt(static_cast<int32_t>(page))) weight *= factor;
    bounds_[page].weight *= factor;
  }
}

float CellWeights::Largest() const {
  float largest = 0.0F;
  for (size_t page = 0; page < bounds_.size(); ++page) {
    if (bounds_[page].weight <= largest) continue;
    const Page& weights = PageAt(static_cast<int32_t>(page));
    largest = std::max(largest, *std::max_element(weights.begin(), weights.end()));
  }
  return largest;
}

std::vector<CellWeights::Placed> CellWeights::AtLeast(float threshold) const {
  std::vector<Placed> found;
  for (size_t page = 0; page < bounds_.size(); ++page) {
    if (bounds_[page].weight < threshold) continue;
    const Page& weights = PageAt(static_cast<int32_t>(page));
    for (int32_t i = 0; i < kPageSize; ++i) {
      const float weight = weights[static_cast<size_t>(i)];
      if (weight >= threshold) found.push_back({bounds_[page].first + i, weight});
    }
  }
  std::sort(found.begin(), found.end(), [](const Placed& a, const Placed& b) {
    return a.ordinal < b.ordinal;
  });
  return found;
}

std::vector<CellWeights::Entry> CellWeights::Entries() const {
  std::vector<Entry> entries;
  std::vector<So3Grid::Cell> cells;
  for (size_t page = 0; page < bounds_.size(); ++page) {
    const int32_t first = bounds_[page].first;
    grid_->CellsAt(first, std::min(kPageSize, grid_->num_cells() - first), &cells);
    const Page& weights = PageAt(static_cast<int32_t>(page));
    for (size_t i = 0; i < cells.size(); ++i) {
      if (weights[i] != 0.0F) entries.push_back({cells[i], weights[i]});
    }
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.cell < b.cell;
  });
  return entries;
}

size_t CellWeights::bytes() const {
  return sizeof(*this) + page_of_.capacity() * sizeof(page_of_[0]) +
         chunks_.capacity() * sizeof(chunks_[0]) + chunks_.size() * sizeof(Chunk) +
         bounds_.capacity() * sizeof(bounds_[0]);
}

}  // namespace vantage
