#include "perception/segmentation/plane_patch.h"

#include <algorithm>

#include "common/check.h"

namespace vantage {
namespace {

constexpr int32_t kNone = -1;

}  // namespace

uint32_t PlanePatch::Root(uint32_t cell) {
  while (parent_[cell] != cell) {
    parent_[cell] = parent_[parent_[cell]];
    cell = parent_[cell];
  }
  return cell;
}

void PlanePatch::Join(uint32_t a, uint32_t b) {
  a = Root(a);
  b = Root(b);
  parent_[std::max(a, b)] = std::min(a, b);
}

void PlanePatch::Link(std::span<const PlaneSight> sights, int width) {
  const int height = static_cast<int>(sights.size()) / width;
  parent_.resize(sights.size());
  for (uint32_t i = 0; i < parent_.size(); ++i) parent_[i] = i;
  last_row_.assign(static_cast<size_t>(width), kNone);
  const auto is_on = [&](int u, int v) {
    return u >= 0 && u < width && v >= 0 &&
           sights[static_cast<size_t>(v * width + u)] == PlaneSight::kOn;
  };
  // Joins a cell with the last of its line, which a line of sight through the plane makes forget.
  const auto link = [&](int at, int step, uint32_t cell, int32_t* last) {
    if (sights[cell] == PlaneSight::kBeyond) *last = kNone;
    if (sights[cell] != PlaneSight::kOn) return;
    if (*last != kNone && at - *last <= kLongestGap + 1) {
      Join(cell, cell - static_cast<uint32_t>((at - *last) * step));
    }
    *last = at;
  };
  for (int v = 0; v < height; ++v) {
    int32_t last = kNone;
    for (int u = 0; u < width; ++u) {
      const auto cell = static_cast<uint32_t>(v * width + u);
      link(u, 1, cell, &last);
      link(v, width, cell, &last_row_[static_cast<size_t>(u)]);
      if (sights[cell] != PlaneSight::kOn) continue;
      const auto above = cell - static_cast<uint32_t>(width);
      if (is_on(u - 1, v - 1)) Join(cell, above - 1);
      if (is_on(u + 1, v - 1)) Join(cell, above + 1);
    }
  }
}

// Of the cells on the plane, which the members are until then.
void PlanePatch::KeepLargest() {
  sizes_.assign(parent_.size(), 0);
  uint32_t largest = 0;
  for (uint32_t i = 0; i < parent_.size(); ++i) {
    parent_[i] = parent_[parent_[i]];  // A parent comes before its child: it has its root already.
    if (members_[i] != 0) ++sizes_[parent_[i]];
  }
  for (uint32_t i = 0; i < sizes_.size(); ++i) largest = sizes_[i] > sizes_[largest] ? i : largest;
  for (uint32_t i = 0; i < members_.size(); ++i) {
    members_[i] = members_[i] & static_cast<uint8_t>(parent_[i] == largest);
  }
  size_ = sizes_[largest];
}

size_t PlanePatch::CountHoles(std::span<const PlaneSight> sights,
                              size_t lines,
                              size_t line_step,
                              size_t cells,
                              size_t cell_step) const {
  size_t holes = 0;
  for (size_t line = 0; line < lines; ++line) {
    size_t since_member = 0;
    bool is_between = false;
    for (size_t i = 0; i < cells; ++i) {
      const size_t cell = line * line_step + i * cell_step;
      if (members_[cell] != 0) {
        holes += is_between ? since_member : 0;
        is_between = true;
        since_member = 0;
      } else if (sights[cell] == PlaneSight::kBeyond) {
        ++since_member;
      }
    }
  }
  return holes;
}

void PlanePatch::Find(std::span<const PlaneSight> sights, int width) {
  VANTAGE_CHECK(width > 0 && !sights.empty() && sights.size() % static_cast<size_t>(width) == 0,
                "the cells do not fill rows");
  members_.resize(sights.size());
  for (size_t i = 0; i < sights.size(); ++i) members_[i] = sights[i] == PlaneSight::kOn ? 1 : 0;
  Link(sights, width);
  KeepLargest();
  const auto columns = static_cast<size_t>(width);
  const size_t rows = sights.size() / columns;
  num_holes_ = std::max(CountHoles(sights, rows, columns, columns, 1),
                        CountHoles(sights, columns, 1, rows, columns));
}

}  // namespace vantage
