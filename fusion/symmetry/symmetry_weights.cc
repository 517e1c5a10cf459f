#include "fusion/symmetry/symmetry_weights.h"

#include <cmath>
#include <map>

#include "fusion/symmetry/turned_surface.h"

namespace vantage {

Result<std::vector<SymmetryWeight>> TableSymmetryWeights(const ContingencyTable& table,
                                                         const So3Grid& grid) {
  std::map<So3Grid::Cell, double> weights;
  double sum = 0.0;
  for (const DirectionTrials& direction : table.directions) {
    const int32_t detected = direction.trials - direction.missed;
    if (detected <= 0) continue;
    sum += 1.0;
    for (const DifferenceCount& difference : direction.differences) {
      weights[grid.CellOf(difference.Difference())] +=
          static_cast<double>(difference.count) / detected;
    }
  }
  const bool has_rows = table.key.rows_k >= So3Grid::kSmallest &&
                        table.key.rows_k <= So3Grid::kLargest && !table.rows.empty();
  if (has_rows) {
    const So3Grid rows(table.key.rows_k);
    std::vector<So3Grid::Cell> cells;  // By ordinal.
    rows.CellsAt(0, rows.num_cells(), &cells);
    const auto orientation = [&](int32_t ordinal) {
      return rows.Representative(cells[static_cast<size_t>(ordinal)]);
    };
    const auto fits = [&](int32_t ordinal) { return ordinal >= 0 && ordinal < rows.num_cells(); };
    for (const auto& [truth, row] : table.rows) {
      const int32_t detected = row.trials - row.missed;
      if (detected <= 0 || !fits(truth)) continue;
      sum += 1.0;
      for (const RowTrials::Count& count : row.detected) {
        if (!fits(count.ordinal)) continue;
        const Eigen::Quaterniond difference =
            orientation(truth).conjugate() * orientation(count.ordinal);
        weights[grid.CellOf(difference)] += static_cast<double>(count.count) / detected;
      }
    }
  }
  if (sum <= 0.0) {
    return Error{ErrorCode::kInvalidArgument,
                 "the table of " + table.key.model_id + " has no detection, expected some"};
  }
  std::vector<SymmetryWeight> result;
  result.reserve(weights.size());
  for (const auto& [cell, weight] : weights) result.push_back({cell, weight / sum});
  return result;
}

std::vector<SymmetryWeight> MeshSymmetryWeights(const TriangleMesh& mesh,
                                                const So3Grid& grid,
                                                double sigma,
                                                uint64_t seed) {
  constexpr int kSamples = 600;
  const TurnedSurface object(mesh, kSamples, seed);
  const double sigma_mse = std::pow(sigma * object.diameter(), 2);
  std::vector<SymmetryWeight> weights;
  for (const So3Grid::Cell cell : grid.ValidCells()) {
    const double mse =
        object.CoarseMse({grid.Representative(cell).toRotationMatrix(), Eigen::Vector3d::Zero()});
    weights.push_back({cell, std::exp(-0.5 * std::pow(mse / sigma_mse, 2))});
  }
  return weights;
}

}  // namespace vantage
