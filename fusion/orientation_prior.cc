#include "fusion/orientation_prior.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "common/format.h"
#include "fusion/confidence_kernel.h"
#include "fusion/orientation_view.h"

namespace vantage {
namespace {

Error Invalid(std::string message) { return {ErrorCode::kInvalidArgument, std::move(message)}; }

Result<void> Validate(const LikelyPose& pose) {
  const auto orientation = OrientationView{pose.q_world_object, 0.0}.Validate();
  if (!orientation) return Invalid("likely pose: " + orientation.error().message);
  if (!(pose.spread > 0.0 && pose.spread <= std::numbers::pi)) {
    return Invalid(
        Format("likely pose: spread = %g rad, expected above 0 and at most pi", pose.spread));
  }
  if (!(pose.weight >= 0.0 && std::isfinite(pose.weight))) {
    return Invalid(
        Format("likely pose: weight = %g, expected finite and not negative", pose.weight));
  }
  return {};
}

Result<void> CheckTotal(double total) {
  if (total > 0.0 && std::isfinite(total)) return {};
  return Invalid(Format("prior: its weights sum to %g, expected above 0 and finite", total));
}

}  // namespace

Result<OrientationPrior> OrientationPrior::Normalized(CellWeights cells,
                                                      double mass,
                                                      double elsewhere) {
  const double total = mass + elsewhere;
  if (auto valid = CheckTotal(total); !valid) return valid.error();
  cells.Scale(static_cast<float>(1.0 / total));
  OrientationPrior prior;
  prior.cells_ = std::make_shared<const CellWeights>(std::move(cells));
  prior.elsewhere_ = elsewhere / total;
  return prior;
}

Result<OrientationPrior> OrientationPrior::AroundPoses(const So3Grid& grid,
                                                       std::span<const LikelyPose> poses,
                                                       double uniform_share) {
  if (!(uniform_share >= 0.0 && uniform_share <= 1.0)) {
    return Invalid(Format("prior: uniform share = %g, expected 0..1", uniform_share));
  }
  double sum = 0.0;
  for (const LikelyPose& pose : poses) {
    if (const auto valid = Validate(pose); !valid) return valid.error();
    sum += pose.weight;
  }
  CellWeights cells(grid);
  if (sum > 0.0 && std::isfinite(sum)) {
    ConfidenceKernel kernel(grid);
    for (const LikelyPose& pose : poses) {
      const double mass = (1.0 - uniform_share) * pose.weight / sum;
      for (const auto& cell : kernel.About(pose.q_world_object, pose.spread)) {
        cells.Add(cell.ordinal, static_cast<float>(mass * cell.density));
      }
    }
    return Normalized(std::move(cells), 1.0 - uniform_share, uniform_share);
  }
  return Normalized(std::move(cells), sum, uniform_share);
}

Result<OrientationPrior> OrientationPrior::OnCells(const So3Grid& grid,
                                                   std::span<const CellWeights::Entry> listed,
                                                   double weight_elsewhere) {
  if (!(weight_elsewhere >= 0.0 && std::isfinite(weight_elsewhere))) {
    return Invalid(
        Format("prior: weight elsewhere = %g, expected finite and not negative", weight_elsewhere));
  }
  std::vector<So3Grid::Cell> once;
  double mass = 0.0;
  double area = 0.0;
  for (const CellWeights::Entry& entry : listed) {
    if (!grid.IsValid(entry.cell)) {
      return Invalid(Format("prior: cell %d is none of the grid of k = %d", entry.cell, grid.k()));
    }
    if (!(entry.weight >= 0.0F && std::isfinite(entry.weight))) {
      return Invalid(Format("prior: weight %g of cell %d, expected finite and not negative",
                            static_cast<double>(entry.weight),
                            entry.cell));
    }
    once.push_back(entry.cell);
    mass += static_cast<double>(entry.weight) * grid.Area(entry.cell);
    area += grid.Area(entry.cell);
  }
  std::sort(once.begin(), once.end());
  if (const auto twice = std::adjacent_find(once.begin(), once.end()); twice != once.end()) {
    return Invalid(Format("prior: cell %d is listed twice, expected once", *twice));
  }
  const bool has_others = listed.size() < static_cast<size_t>(grid.num_cells());
  const double total = mass + (has_others ? weight_elsewhere * std::max(0.0, 1.0 - area) : 0.0);
  if (auto valid = CheckTotal(total); !valid) return valid.error();

  OrientationPrior prior;
  // In single precision like the cells, so that those of weight 0 have a density of exactly 0.
  const auto elsewhere = static_cast<float>(weight_elsewhere / total);
  CellWeights cells(grid);
  for (const CellWeights::Entry& entry : listed) {
    const auto density = static_cast<float>(static_cast<double>(entry.weight) / total);
    cells.Add(grid.Ordinal(entry.cell), density - elsewhere);
  }
  prior.cells_ = std::make_shared<const CellWeights>(std::move(cells));
  prior.elsewhere_ = static_cast<double>(elsewhere);
  return prior;
}

}  // namespace vantage
