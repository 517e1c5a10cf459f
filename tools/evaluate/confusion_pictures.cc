#include "tools/evaluate/confusion_pictures.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/check.h"
#include "common/so3.h"
#include "fusion/confusion/direction_grid.h"
#include "fusion/confusion/viewing_direction.h"
#include "tools/support/color.h"
#include "tools/support/rgb_canvas.h"
#include "tools/support/sphere_renderer.h"

namespace vantage {
namespace {

constexpr Rgb kPaper = {255, 255, 255};

// Difference rotations of a direction with their shares of the trials.
using Differences = std::vector<std::pair<Eigen::Quaterniond, double>>;

std::vector<Differences> SharesByDirection(const ContingencyTable& table) {
  std::vector<Differences> all;
  for (const DirectionTrials& trials : table.directions) {
    Differences differences;
    for (const DifferenceCount& one : trials.differences) {
      differences.emplace_back(one.Difference(),
                               static_cast<double>(one.count) / std::max(1, trials.trials));
    }
    all.push_back(std::move(differences));
  }
  return all;
}

// The table in blocks: the largest share of each.
class Blocks {
 public:
  Blocks(int num_cells, int block)
      : block_(block),
        size_((num_cells + block - 1) / block),
        shares_(static_cast<size_t>(size_) * static_cast<size_t>(size_), 0.0F) {}

  void Put(int32_t truth, int32_t detected, double share) {
    float& at = shares_[static_cast<size_t>(truth / block_) * static_cast<size_t>(size_) +
                        static_cast<size_t>(detected / block_)];
    at = std::max(at, static_cast<float>(share));
  }
  [[nodiscard]] RgbImage Draw(bool is_marking_any) const {
    RgbImage image = FilledImage(size_, size_, kPaper);
    for (int row = 0; row < size_; ++row) {
      for (int column = 0; column < size_; ++column) {
        const double share =
            static_cast<double>(shares_[static_cast<size_t>(row) * static_cast<size_t>(size_) +
                                        static_cast<size_t>(column)]);
        if (share <= 0.0) continue;
        // The square root, so that rare confusions are seen beside the diagonal.
        SetPixel(image, column, row, DensityColor(is_marking_any ? 1.0 : std::sqrt(share)));
      }
    }
    return image;
  }

 private:
  int block_;
  int size_;
  std::vector<float> shares_;
};

}  // namespace

RgbImage DrawConfusionMatrix(const ContingencyTable& table,
                             const So3Grid& grid,
                             const ConfusionMatrixView& view) {
  VANTAGE_CHECK(view.block > 0, "block of a table");
  Blocks blocks(grid.num_cells(), view.block);
  const std::vector<Differences> by_direction = SharesByDirection(table);
  const bool has_directions = table.key.num_directions > 0;
  const DirectionGrid directions(has_directions ? table.key.num_directions
                                                : DirectionGrid::kFewest);
  const std::vector<So3Grid::Cell> cells = grid.ValidCells();
  std::vector<double> row(cells.size(), 0.0);
  for (const So3Grid::Cell cell : cells) {
    const int32_t ordinal = grid.Ordinal(cell);
    if (!has_directions || table.rows.contains(ordinal)) continue;
    const Eigen::Quaterniond q_truth = grid.Representative(cell);
    const int direction = directions.CellOf(ViewingDirection(q_truth));
    std::vector<int32_t> touched;
    for (const auto& [difference, share] : by_direction[static_cast<size_t>(direction)]) {
      const int32_t detected = grid.Ordinal(grid.CellOf(q_truth * difference));
      if (row[static_cast<size_t>(detected)] == 0.0) touched.push_back(detected);
      row[static_cast<size_t>(detected)] += share;
    }
    for (const int32_t detected : touched) {
      blocks.Put(ordinal, detected, row[static_cast<size_t>(detected)]);
      row[static_cast<size_t>(detected)] = 0.0;
    }
  }
  if (table.key.rows_k == grid.k()) {
    for (const auto& [ordinal, trials] : table.rows) {
      for (const RowTrials::Count& one : trials.detected) {
        blocks.Put(
            ordinal, one.ordinal, static_cast<double>(one.count) / std::max(1, trials.trials));
      }
    }
  }
  return blocks.Draw(view.is_marking_any);
}

RgbImage DrawSymmetryWeights(const ContingencyTable& table, double least_angle) {
  std::vector<SphereSample> samples;
  for (const Differences& differences : SharesByDirection(table)) {
    for (const auto& [difference, share] : differences) {
      if (GeodesicAngle(difference, Eigen::Quaterniond::Identity()) < least_angle) continue;
      samples.push_back(
          {DirectionOfOrientation(difference).cast<float>(), static_cast<float>(share)});
    }
  }
  return RenderSphereDensity(samples, {});
}

RgbImage DrawHistogram(const CellWeights& weights, const Eigen::Quaterniond& q_truth) {
  const So3Grid& grid = weights.grid();
  std::vector<SphereSample> samples;
  for (const CellWeights::Entry& entry : weights.Entries()) {
    const Eigen::Quaterniond q = q_truth.conjugate() * grid.Representative(entry.cell);
    const double mass = static_cast<double>(entry.weight) * grid.Area(entry.cell);
    samples.push_back({DirectionOfOrientation(q).cast<float>(), static_cast<float>(mass)});
  }
  return RenderSphereDensity(samples, {});
}

}  // namespace vantage
