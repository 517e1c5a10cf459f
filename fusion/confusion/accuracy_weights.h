#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "common/result.h"
#include "fusion/confusion/contingency_table.h"
#include "fusion/confusion/direction_grid.h"
#include "fusion/orientation_histogram.h"
#include "fusion/so3_grid.h"

namespace vantage {

/// The accuracy weights w_a of paper 6.1: the column of the contingency table of what was detected,
/// as the measurement model of the histogram (eq. 8-10). The table is of the camera's frame, the
/// histogram of the world's: a cell of the histogram with the representative q_r is the truth
/// q_camera_world q_r. Only the cells that the column has counts for are visited. Counts are per
/// kTrials trials of a truth, however many there were. Not for several threads at once.
///
/// The table is held by columns where it fits: where it was measured by rows, and up to
/// kLargestFull also where it was measured by direction. Finer grids look the differences up (left
/// invariance).
class AccuracyWeights {
 public:
  static constexpr double kTrials = 250.0;     ///< of a row, paper 6.2
  static constexpr double kPseudoCount = 6.0;  ///< c_p, paper 6.2
  /// Largest k at which a table by direction is held by columns: some MB.
  static constexpr int kLargestFull = 8;

  /// CT(i, d) is the count of the detected cell d in the row of the truth's cell i; 0 in rows that
  /// were not measured. @param grid outlives the weights. @param pseudo_count c_p > 0.
  /// Errors: no rows, rows of another grid, cells or counts that can't be; c_p.
  static Result<AccuracyWeights> FromRows(const ContingencyTable& table,
                                          const So3Grid& grid,
                                          double pseudo_count = kPseudoCount);
  /// At any k, by left invariance: CT(i, d) is the count of those differences q' that were seen
  /// from the viewing direction of the truth q_i for which q_i q' lies in the cell d. Up to
  /// kLargestFull q_i is the representative of the truth's cell, so that the table is the paper's
  /// (PredictedRow of each cell; takes 0.2 s at k = 8), beyond it the truth itself.
  /// Errors: no trials by direction, counts that can't be; c_p.
  static Result<AccuracyWeights> FromDirections(const ContingencyTable& table,
                                                const So3Grid& grid,
                                                double pseudo_count = kPseudoCount);

  struct Cell {
    int32_t ordinal;  ///< So3Grid::Ordinal, of the truth in the world's frame
    double count;     ///< CT(i, d) > 0
    double area;
  };
  /// The cells with counts in the column of a detection, each once; until the next call.
  std::span<const Cell> Column(const Eigen::Quaterniond& q_world_camera,
                               const Eigen::Quaterniond& q_world_object);

  /// One step of equation 10: adds w_a = CT + c_p (eq. 9), normalized over SO(3), times w_v. c_p is
  /// in every cell, the less of the detection's mass is at truths the emptier its column is.
  /// @param histogram of the same grid.
  void AddTo(const Eigen::Quaterniond& q_world_camera,
             const Eigen::Quaterniond& q_world_object,
             double verification_weight,
             OrientationHistogram* histogram);

 private:
  // An entry of the full table; both cells by their ordinals.
  struct Counted {
    int32_t detected;
    int32_t truth;
    float count;
  };
  struct OfColumn {
    int32_t truth;  // Place in truths_.
    float count;
  };
  struct TruthCell {
    Eigen::Quaterniond q;  // Representative.
    So3Grid::Cell cell;
  };
  // A difference of directions and where it can be found.
  struct Entry {
    Eigen::Quaterniond difference;  // q'.
    int32_t seen_from;              // Direction that what was detected is seen from.
    int32_t truth;                  // Direction of the truth.
    int32_t bin;                    // Of differences that are near each other.
    float count;
  };
  // A cell that may be a truth.
  struct Near {
    Eigen::Quaterniond q_camera_object;
    int32_t ordinal;
    int32_t truth;
    double area;
  };
  struct Bin {
    Eigen::Quaterniond mean;
    double spread = 0.0;        // rad, of its differences about the mean.
    int64_t of_column = -1;     // num_columns_ when near was filled.
    size_t begin = 0, end = 0;  // Of its part of near_.
  };

  AccuracyWeights(const So3Grid& grid, int num_directions, double pseudo_count);
  static void AppendRow(int32_t truth, const RowTrials& row, std::vector<Counted>* full);
  void FillFull(const ContingencyTable& table);
  void TakeFull(const std::vector<Counted>& full);
  void FillEntries(const ContingencyTable& table);
  void FillBins();
  void FindNear(const Eigen::Quaterniond& q_world_camera,
                const Eigen::Quaterniond& q_camera_truth,
                double reach);
  void CountFull(const Eigen::Quaterniond& q_world_camera, int32_t detected);
  void CountDirections(const Eigen::Quaterniond& q_world_camera, So3Grid::Cell detected);
  void Count(const Near& near, double count);

  const So3Grid* grid_;
  DirectionGrid directions_;
  double pseudo_count_;
  bool is_full_ = false;
  std::vector<size_t> first_;  // By detected cell in counts_, or by direction in entries_; and end.
  std::vector<OfColumn> counts_;          // Of a full table.
  std::vector<TruthCell> truths_;         // Of a full table.
  std::vector<Entry> entries_;            // By direction that they are seen from.
  std::vector<Bin> bins_;                 // Of entries_.
  std::vector<Eigen::Vector3d> centers_;  // Of directions.
  int64_t num_columns_ = 0;
  std::vector<int32_t> place_;  // By ordinal: in column_; -1: not there.
  std::vector<Cell> column_;    // Reused, as those below.
  std::vector<Near> near_;
  std::vector<So3Grid::NearCell> cells_;
  std::vector<OrientationHistogram::Addend> addends_;
};

}  // namespace vantage
