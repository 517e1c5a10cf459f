#include "fusion/cell_weights.h"

#include <algorithm>

namespace vantage {

CellWeights::CellWeights(const So3Grid& grid)
    : grid_(&grid), page_of_(static_cast<size_t>((grid.num_cells() - 1) / kPageSize + 1), -1) {}

int32_t CellWeights::AppendPage(int32_t place) {
  // A vector that doubles would ask for three times the storage at its last step.
  if (pages_.size() == pages_.capacity()) {
    const size_t wanted = std::min(page_of_.size(), pages_.size() + pages_.size() / 8 + 64);
    pages_.reserve(wanted);
    bounds_.reserve(wanted);
  }
  pages_.emplace_back();
  bounds_.push_back({place * kPageSize, 0.0F});
  return static_cast<int32_t>(pages_.size() - 1);
}

void CellWeights::Scale(float factor) {
  for (Page& page : pages_) {
    for (float& weight : page) weight *= factor;
  }
  for (Bound& bound : bounds_) bound.weight *= factor;
}

void CellWeights::Clear() {
  for (const Bound& bound : bounds_) page_of_[static_cast<size_t>(bound.first / kPageSize)] = -1;
  pages_.clear();
  bounds_.clear();
}

float CellWeights::Largest() const {
  float largest = 0.0F;
  for (size_t page = 0; page < pages_.size(); ++page) {
    if (bounds_[page].weight <= largest) continue;
    largest = std::max(largest, *std::max_element(pages_[page].begin(), pages_[page].end()));
  }
  return largest;
}

std::vector<CellWeights::Placed> CellWeights::AtLeast(float threshold) const {
  std::vector<Placed> found;
  for (size_t page = 0; page < pages_.size(); ++page) {
    if (bounds_[page].weight < threshold) continue;
    for (int32_t i = 0; i < kPageSize; ++i) {
      const float weight = pages_[page][static_cast<size_t>(i)];
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
  for (size_t page = 0; page < pages_.size(); ++page) {
    const int32_t first = bounds_[page].first;
    grid_->CellsAt(first, std::min(kPageSize, grid_->num_cells() - first), &cells);
    for (size_t i = 0; i < cells.size(); ++i) {
      if (pages_[page][i] != 0.0F) entries.push_back({cells[i], pages_[page][i]});
    }
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.cell < b.cell;
  });
  return entries;
}

size_t CellWeights::bytes() const {
  return sizeof(*this) + page_of_.capacity() * sizeof(page_of_[0]) +
         pages_.capacity() * sizeof(pages_[0]) + bounds_.capacity() * sizeof(bounds_[0]);
}

}  // namespace vantage
