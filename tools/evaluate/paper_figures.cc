#include "tools/evaluate/paper_figures.h"

#include <algorithm>
#include <limits>

namespace vantage {
namespace {

constexpr double kUnsaid = std::numeric_limits<double>::quiet_NaN();

// Table 1.
constexpr std::array<PaperGrid, 3> kGrids = {PaperGrid{8, 8480, 10.28, 1.40, 48.0},
                                             {16, 68416, 5.12, 0.65, 68.0},
                                             {32, 548496, 2.57, 0.32, 270.0}};

// Table 2.
constexpr std::array<PaperObject, 18> kObjects = {
    PaperObject{"cat", 23.336, {65.286, 1.342, 6.028, 7.901, 1.683, 1.848}},
    {"chef", 92.439, {77.721, 0.885, 3.764, 2.806, 0.710, 0.396}},
    {"chicken", 1.015, {21.721, 0.360, 1.939, 1.939, 0.055, 0.055}},
    {"clown", 2.047, {46.423, 0.114, 3.553, 3.553, 0.014, 0.008}},
    {"dog", 95.431, {82.736, 0.197, 3.764, 3.764, 0.036, 0.059}},
    {"dogspray", 157.128, {96.160, 0.168, 163.913, 163.913, 0.023, 0.027}},
    {"dwarf", 1.445, {53.975, 0.154, 3.764, 2.663, 0.015, 0.010}},
    {"filter", 88.570, {81.026, 0.617, 178.746, 178.746, 0.423, 175.674}},
    {"fish", 2.291, {52.354, 0.237, 1.551, 1.547, 0.036, 0.028}},
    {"santa", 2.260, {54.285, 0.391, 3.764, 3.764, 0.053, 0.056}},
    {"para", 0.668, {49.869, 0.053, 4.346, 4.346, 0.013, 0.020}},
    {"pitcher", 0.917, {0.873, 0.073, 1.255, 1.206, 0.012, 0.009}},
    {"pony", 1.740, {1.714, 0.081, 1.457, 1.504, 0.018, 0.019}},
    {"rhino", 1.732, {42.367, 0.747, 1.441, 1.441, 0.333, 0.332}},
    {"sauce", 176.815, {107.018, 0.330, 178.745, 178.745, 0.050, 0.048}},
    {"shampoo", 176.758, {110.820, 0.512, 175.885, 175.885, 176.849, 174.909}},
    {"spray", 2.339, {67.929, 0.326, 1.565, 1.591, 0.050, 0.045}},
    {"turtle", 3.299, {44.955, 0.905, 3.073, 1.510, 0.751, 0.784}}};

// Section 7.3.2.
constexpr std::array<PaperBox, 5> kBoxes = {PaperBox{kKnnId, 0.3, 0.3, 0.17, 0.6},
                                            {kVotingId, 3.0, 4.0, kUnsaid, kUnsaid},
                                            {kVwVotingId, 3.0, 4.0, kUnsaid, kUnsaid},
                                            {kCwId, 0.05, 0.05, 0.01, 0.03},
                                            {kCwVwId, 0.05, 0.05, 0.01, 0.03}};

char Lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

}  // namespace

std::span<const PaperGrid> PaperGrids() { return kGrids; }

const PaperGrid* FindPaperGrid(int k) {
  const auto found = std::find_if(
      kGrids.begin(), kGrids.end(), [k](const PaperGrid& grid) { return grid.k == k; });
  return found == kGrids.end() ? nullptr : &*found;
}

int PaperColumn(std::string_view method_id) {
  const auto found = std::find(kPaperColumns.begin(), kPaperColumns.end(), method_id);
  return found == kPaperColumns.end() ? -1 : static_cast<int>(found - kPaperColumns.begin());
}

std::span<const PaperObject> PaperObjects() { return kObjects; }

const PaperObject* FindPaperObject(std::string_view model_id) {
  const auto found = std::find_if(kObjects.begin(), kObjects.end(), [&](const PaperObject& object) {
    return std::equal(model_id.begin(),
                      model_id.end(),
                      object.name.begin(),
                      object.name.end(),
                      [](char a, char b) { return Lower(a) == b; });
  });
  return found == kObjects.end() ? nullptr : &*found;
}

const PaperBox* FindPaperBox(std::string_view method_id) {
  const auto found = std::find_if(kBoxes.begin(), kBoxes.end(), [&](const PaperBox& box) {
    return box.method_id == method_id;
  });
  return found == kBoxes.end() ? nullptr : &*found;
}

}  // namespace vantage
