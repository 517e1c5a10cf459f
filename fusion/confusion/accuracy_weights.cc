#include "fusion/confusion/accuracy_weights.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>
#include <utility>

#include "common/check.h"
#include "common/format.h"
#include "common/so3.h"
#include "fusion/confusion/predicted_row.h"
#include "fusion/confusion/viewing_direction.h"

namespace vantage {
namespace {

// No point of a cell is farther from its representative, rad: 2 / k but at the smallest k.
double ReachOfCell(const So3Grid& grid) { return 2.3 / grid.k(); }

// No point of a cell of directions is farther from its center, rad: at most 2.8 / sqrt(N), from 5
// cells on.
double ReachOfDirection(const DirectionGrid& grid) {
  if (grid.num_cells() < 5) return std::numbers::pi;
  return std::min(std::numbers::pi, 3.0 / std::sqrt(grid.num_cells()));
}

Result<void> CheckPseudoCount(double pseudo_count) {
  if (pseudo_count > 0.0 && std::isfinite(pseudo_count)) return {};
  return Error{ErrorCode::kInvalidArgument,
               Format("pseudo-count c_p = %g, expected above 0", pseudo_count)};
}

Error BadTable(const ContingencyTable& table, const std::string& what) {
  return {
      ErrorCode::kInvalidArgument,
      Format("the contingency table of \"%s\" has %s", table.key.model_id.c_str(), what.c_str())};
}

}  // namespace

AccuracyWeights::AccuracyWeights(const So3Grid& grid, int num_directions, double pseudo_count)
    : grid_(&grid), directions_(num_directions), pseudo_count_(pseudo_count) {}

Result<AccuracyWeights> AccuracyWeights::FromRows(const ContingencyTable& table,
                                                  const So3Grid& grid,
                                                  double pseudo_count) {
  if (auto valid = CheckPseudoCount(pseudo_count); !valid) return valid.error();
  if (table.key.rows_k != grid.k() || table.rows.empty()) {
    return BadTable(table,
                    Format("%zu rows of k = %d, expected some of k = %d",
                           table.rows.size(),
                           table.key.rows_k,
                           grid.k()));
  }
  const int32_t num_cells = grid.num_cells();
  std::vector<Counted> full;
  for (const auto& [truth, row] : table.rows) {
    for (const RowTrials::Count& detected : row.detected) {
      if (truth < 0 || truth >= num_cells || detected.ordinal < 0 ||
          detected.ordinal >= num_cells || detected.count <= 0 || detected.count > row.trials) {
        return BadTable(table,
                        Format("%d detections of the cell %d in the row %d of %d trials, expected "
                               "cells below %d and 1 to all trials",
                               detected.count,
                               detected.ordinal,
                               truth,
                               row.trials,
                               num_cells));
      }
    }
    AppendRow(truth, row, &full);
  }
  AccuracyWeights weights(grid, DirectionGrid::kFewest, pseudo_count);
  weights.TakeFull(full);
  return weights;
}

Result<AccuracyWeights> AccuracyWeights::FromDirections(const ContingencyTable& table,
                                                        const So3Grid& grid,
                                                        double pseudo_count) {
  if (auto valid = CheckPseudoCount(pseudo_count); !valid) return valid.error();
  const size_t num_directions = table.directions.size();
  if (num_directions < static_cast<size_t>(DirectionGrid::kFewest) ||
      num_directions > static_cast<size_t>(DirectionGrid::kMost)) {
    return BadTable(table,
                    Format("%zu viewing directions, expected %d to %d",
                           num_directions,
                           DirectionGrid::kFewest,
                           DirectionGrid::kMost));
  }
  bool any = false;
  for (size_t i = 0; i < num_directions; ++i) {
    const DirectionTrials& direction = table.directions[i];
    int64_t detected = 0;
    for (const DifferenceCount& difference : direction.differences) {
      detected += difference.count;
      if (difference.count > 0 && detected <= direction.trials) continue;
      return BadTable(table,
                      Format("a difference of count %d in direction %zu of %d trials, expected at "
                             "least 1 and in all at most the trials",
                             difference.count,
                             i,
                             direction.trials));
    }
    any = any || detected > 0;
  }
  if (!any) return BadTable(table, "no detections by direction");
  AccuracyWeights weights(grid, static_cast<int>(num_directions), pseudo_count);
  if (grid.k() <= kLargestFull) {
    weights.FillFull(table);
  } else {
    weights.place_.assign(static_cast<size_t>(grid.num_cells()), -1);
    weights.FillEntries(table);
    weights.FillBins();
  }
  return weights;
}

void AccuracyWeights::AppendRow(int32_t truth, const RowTrials& row, std::vector<Counted>* full) {
  for (const RowTrials::Count& detected : row.detected) {
    const double count = kTrials * detected.count / row.trials;
    full->push_back({detected.ordinal, truth, static_cast<float>(count)});
  }
}

// Every cell's row as it would be if its trials had been made (left invariance).
void AccuracyWeights::FillFull(const ContingencyTable& table) {
  std::vector<So3Grid::Cell> cells;
  grid_->CellsAt(0, grid_->num_cells(), &cells);
  std::vector<Counted> full;
  for (size_t truth = 0; truth < cells.size(); ++truth) {
    const Eigen::Quaterniond q = grid_->Representative(cells[truth]);
    const auto direction = static_cast<size_t>(directions_.CellOf(ViewingDirection(q)));
    AppendRow(
        static_cast<int32_t>(truth), PredictedRow(table.directions[direction], *grid_, q), &full);
  }
  TakeFull(full);
}

// Sorts the table by columns. Of truths what a column needs is kept, once of each.
void AccuracyWeights::TakeFull(const std::vector<Counted>& full) {
  is_full_ = true;
  first_.assign(static_cast<size_t>(grid_->num_cells()) + 1, 0);
  for (const Counted& one : full) ++first_[static_cast<size_t>(one.detected) + 1];
  for (size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  std::vector<size_t> next(first_.begin(), first_.end() - 1);
  counts_.resize(full.size());
  std::vector<So3Grid::Cell> cell;
  int32_t last_truth = -1;
  for (const Counted& one : full) {
    if (one.truth != last_truth) {
      grid_->CellsAt(one.truth, 1, &cell);
      truths_.push_back({grid_->Representative(cell.front()), cell.front()});
      last_truth = one.truth;
    }
    counts_[next[static_cast<size_t>(one.detected)]++] = {static_cast<int32_t>(truths_.size()) - 1,
                                                          one.count};
  }
}

void AccuracyWeights::FillEntries(const ContingencyTable& table) {
  for (int i = 0; i < directions_.num_cells(); ++i) {
    const Eigen::Vector3d center = directions_.Center(i);
    centers_.push_back(center);
    const DirectionTrials& direction = table.directions[static_cast<size_t>(i)];
    for (const DifferenceCount& difference : direction.differences) {
      const Eigen::Quaterniond q = difference.Difference();
      const double count = kTrials * difference.count / direction.trials;
      // What is detected is seen from q'^* v.
      entries_.push_back(
          {q, directions_.CellOf(q.conjugate() * center), i, 0, static_cast<float>(count)});
    }
  }
  std::stable_sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) {
    return a.seen_from < b.seen_from;
  });
  first_.assign(static_cast<size_t>(directions_.num_cells()) + 1, 0);
  for (const Entry& entry : entries_) ++first_[static_cast<size_t>(entry.seen_from) + 1];
  for (size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
}

// Bins of differences are cubes of rotation vectors, about a quarter of the grid's spacing wide.
void AccuracyWeights::FillBins() {
  const double width = 0.4 / grid_->k();
  std::unordered_map<uint64_t, int32_t> bin_of_cube;
  std::vector<Eigen::Vector4d> sums;
  for (Entry& entry : entries_) {
    const Eigen::Vector3d r = LogSo3(entry.difference) / width;
    uint64_t cube = 0;
    for (const double along : r) {
      cube = (cube << 21) ^ (static_cast<uint64_t>(std::lround(along)) & 0x1FFFFFU);
    }
    const auto [found, is_new] =
        bin_of_cube.try_emplace(cube, static_cast<int32_t>(bin_of_cube.size()));
    if (is_new) sums.push_back(Eigen::Vector4d::Zero());
    entry.bin = found->second;
    Eigen::Vector4d& sum = sums[static_cast<size_t>(entry.bin)];
    const double sign = sum.dot(entry.difference.coeffs()) < 0.0 ? -1.0 : 1.0;
    sum += sign * entry.difference.coeffs();
  }
  bins_.resize(sums.size());
  for (size_t i = 0; i < bins_.size(); ++i) {
    bins_[i].mean = Eigen::Quaterniond(sums[i].normalized());
  }
  for (const Entry& entry : entries_) {
    Bin& bin = bins_[static_cast<size_t>(entry.bin)];
    bin.spread = std::max(bin.spread, GeodesicAngle(bin.mean, entry.difference));
  }
}

std::span<const AccuracyWeights::Cell> AccuracyWeights::Column(
    const Eigen::Quaterniond& q_world_camera, const Eigen::Quaterniond& q_world_object) {
  if (!is_full_) {
    for (const Cell& cell : column_) place_[static_cast<size_t>(cell.ordinal)] = -1;
  }
  column_.clear();
  const So3Grid::Cell detected = grid_->CellOf(q_world_camera.conjugate() * q_world_object);
  if (is_full_) {
    CountFull(q_world_camera, grid_->Ordinal(detected));
  } else {
    CountDirections(q_world_camera, detected);
  }
  return column_;
}

// A cell of the histogram is one truth, so it comes up once.
void AccuracyWeights::CountFull(const Eigen::Quaterniond& q_world_camera, int32_t detected) {
  const Eigen::Quaterniond q_camera_world = q_world_camera.conjugate();
  const auto column = static_cast<size_t>(detected);
  for (size_t i = first_[column]; i < first_[column + 1]; ++i) {
    const TruthCell& truth = truths_[static_cast<size_t>(counts_[i].truth)];
    grid_->CellsWithin(q_world_camera * truth.q, ReachOfCell(*grid_), &cells_);
    for (const So3Grid::NearCell& cell : cells_) {
      const Eigen::Quaterniond q = q_camera_world * grid_->Representative(cell.cell);
      if (grid_->CellOf(q) != truth.cell) continue;
      column_.push_back({cell.ordinal, static_cast<double>(counts_[i].count), cell.area});
    }
  }
}

// Appends to near_ the histogram's cells about a truth.
void AccuracyWeights::FindNear(const Eigen::Quaterniond& q_world_camera,
                               const Eigen::Quaterniond& q_camera_truth,
                               double reach) {
  grid_->CellsWithin(q_world_camera * q_camera_truth, reach, &cells_);
  const Eigen::Quaterniond q_camera_world = q_world_camera.conjugate();
  for (const So3Grid::NearCell& cell : cells_) {
    const Eigen::Quaterniond q = q_camera_world * grid_->Representative(cell.cell);
    near_.push_back({q, cell.ordinal, directions_.CellOf(ViewingDirection(q)), cell.area});
  }
}

// What is detected, p, is seen from v(p), its truth p q'^* from q' v(p): of all differences only
// those are looked at that were seen from about there.
void AccuracyWeights::CountDirections(const Eigen::Quaterniond& q_world_camera,
                                      So3Grid::Cell detected) {
  near_.clear();
  ++num_columns_;
  const double reach = ReachOfCell(*grid_);
  const double reach_of_direction = ReachOfDirection(directions_);
  const Eigen::Quaterniond p = grid_->Representative(detected);
  const Eigen::Vector3d v = ViewingDirection(p);
  const double least_along = std::cos(std::min(std::numbers::pi, reach + reach_of_direction));
  for (const int key : directions_.CellsWithin(v, reach + 2.0 * reach_of_direction)) {
    const auto seen_from = static_cast<size_t>(key);
    for (size_t e = first_[seen_from]; e < first_[seen_from + 1]; ++e) {
      const Entry& entry = entries_[e];
      const Eigen::Vector3d& center = centers_[static_cast<size_t>(entry.truth)];
      if ((entry.difference * v).dot(center) < least_along) continue;
      Bin& bin = bins_[static_cast<size_t>(entry.bin)];
      if (bin.of_column != num_columns_) {
        bin.of_column = num_columns_;
        bin.begin = near_.size();
        FindNear(q_world_camera, p * bin.mean.conjugate(), reach + bin.spread);
        bin.end = near_.size();
      }
      for (size_t i = bin.begin; i < bin.end; ++i) {
        const Near& near = near_[i];
        if (near.truth != entry.truth) continue;
        if (grid_->CellOf(near.q_camera_object * entry.difference) != detected) continue;
        Count(near, static_cast<double>(entry.count));
      }
    }
  }
}

void AccuracyWeights::Count(const Near& near, double count) {
  int32_t& place = place_[static_cast<size_t>(near.ordinal)];
  if (place < 0) {
    place = static_cast<int32_t>(column_.size());
    column_.push_back({near.ordinal, 0.0, near.area});
  }
  column_[static_cast<size_t>(place)].count += count;
}

void AccuracyWeights::AddTo(const Eigen::Quaterniond& q_world_camera,
                            const Eigen::Quaterniond& q_world_object,
                            double verification_weight,
                            OrientationHistogram* histogram) {
  VANTAGE_CHECK(histogram->grid().k() == grid_->k(), "accuracy weights of the histogram's grid");
  double sum = pseudo_count_;
  for (const Cell& cell : Column(q_world_camera, q_world_object)) sum += cell.count * cell.area;
  addends_.clear();
  for (const Cell& cell : column_) {
    addends_.push_back({cell.ordinal, verification_weight * cell.count / sum, cell.area});
  }
  histogram->AddDensity(addends_, verification_weight * pseudo_count_ / sum);
}

}  // namespace vantage
