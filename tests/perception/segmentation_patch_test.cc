// The largest connected patch of a plane, against a flood fill.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "common/rng.h"
#include "perception/segmentation/plane_patch.h"

namespace vantage {
namespace {

// '#' on the plane, ' ' beyond it, '.' hidden.
std::vector<PlaneSight> Sights(const std::string& cells) {
  std::vector<PlaneSight> sights;
  for (const char cell : cells) {
    sights.push_back(cell == '#'   ? PlaneSight::kOn
                     : cell == '.' ? PlaneSight::kHidden
                                   : PlaneSight::kBeyond);
  }
  return sights;
}

std::set<size_t> Members(const PlanePatch& patch) {
  std::set<size_t> members;
  for (size_t i = 0; i < patch.members().size(); ++i) {
    if (patch.members()[i] != 0) members.insert(i);
  }
  return members;
}

PlanePatch Find(const std::string& cells, int width) {
  PlanePatch patch;
  patch.Find(Sights(cells), width);
  EXPECT_EQ(Members(patch).size(), patch.size());
  return patch;
}

// All that one cell is linked to, cell by cell.
std::set<size_t> Flood(const std::vector<PlaneSight>& sights, int width, size_t start) {
  const int height = static_cast<int>(sights.size()) / width;
  std::set<size_t> reached = {start};
  std::vector<size_t> open = {start};
  while (!open.empty()) {
    const int u = static_cast<int>(open.back()) % width;
    const int v = static_cast<int>(open.back()) / width;
    open.pop_back();
    for (int du = -1; du <= 1; ++du) {
      for (int dv = -1; dv <= 1; ++dv) {
        if (du == 0 && dv == 0) continue;
        const int farthest = du != 0 && dv != 0 ? 1 : PlanePatch::kLongestGap + 1;
        for (int n = 1; n <= farthest; ++n) {
          const int to_u = u + n * du;
          const int to_v = v + n * dv;
          if (to_u < 0 || to_v < 0 || to_u >= width || to_v >= height) break;
          const auto to = static_cast<size_t>(to_v * width + to_u);
          if (sights[to] == PlaneSight::kHidden) continue;
          if (sights[to] == PlaneSight::kOn && reached.insert(to).second) open.push_back(to);
          break;
        }
      }
    }
  }
  return reached;
}

TEST(PlanePatch, EqualsFloodFill) {
  Rng rng(1);
  PlanePatch patch;  // Keeps its buffers from image to image.
  size_t scattered = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const int width = 1 + static_cast<int>(rng.Below(30));
    const auto size = static_cast<size_t>(width) * (1 + rng.Below(20));
    const double on = rng.Uniform(0.02, 0.6);
    const double hidden = rng.Uniform(0.0, 1.0 - on);
    std::vector<PlaneSight> sights(size);
    for (PlaneSight& sight : sights) {
      const double drawn = rng.Uniform();
      sight = drawn < on            ? PlaneSight::kOn
              : drawn < on + hidden ? PlaneSight::kHidden
                                    : PlaneSight::kBeyond;
    }
    std::set<size_t> largest;
    for (size_t i = 0; i < size; ++i) {
      if (sights[i] != PlaneSight::kOn) continue;
      const std::set<size_t> reached = Flood(sights, width, i);
      if (reached.size() > largest.size()) largest = reached;
    }
    patch.Find(sights, width);
    EXPECT_EQ(Members(patch), largest) << trial;
    EXPECT_EQ(patch.size(), largest.size());
    scattered += largest.size() < static_cast<size_t>(
                                      std::count(sights.begin(), sights.end(), PlaneSight::kOn))
                     ? 1U
                     : 0U;
  }
  EXPECT_GT(scattered, 100U);
}

TEST(PlanePatch, HiddenGapsAreBridgedToALimit) {
  const std::string gap(PlanePatch::kLongestGap, '.');
  const int width = PlanePatch::kLongestGap + 2;
  EXPECT_EQ(Find("#" + gap + "#", width).size(), 2U);
  EXPECT_EQ(Find("#" + gap + "#", 1).size(), 2U);
  EXPECT_EQ(Find("#." + gap + "#", width + 1).size(), 1U);
  EXPECT_EQ(Find("#." + gap + "#", 1).size(), 1U);
  EXPECT_EQ(Find("#. .#", 5).size(), 1U);
}

TEST(PlanePatch, HolesAreCountedAlongRowsAndColumns) {
  EXPECT_EQ(Find("#####"
                 "#   #"
                 "#. .#"
                 "#####",
                 5)
                .num_holes(),
            4U);
  // Open to the right: in columns alone.
  EXPECT_EQ(Find("####"
                 "#   "
                 "####",
                 4)
                .num_holes(),
            3U);
  // Beside the patch there are none.
  EXPECT_EQ(Find("    "
                 " ## "
                 " #  ",
                 4)
                .num_holes(),
            0U);
}

TEST(PlanePatch, MayBeEmpty) {
  const PlanePatch patch = Find(". ..", 2);
  EXPECT_EQ(patch.size(), 0U);
  EXPECT_EQ(patch.num_holes(), 0U);
}

}  // namespace
}  // namespace vantage
