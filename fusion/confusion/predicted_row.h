#pragma once

#include <Eigen/Geometry>

#include "fusion/confusion/contingency_table.h"
#include "fusion/so3_grid.h"

namespace vantage {

/// What trials from one cell of viewing directions say of a row: each difference rotation is seen
/// from the truth, q_D = q_GT q' (left invariance), and counted in its cell.
/// @param q_camera_object the truth, of norm 1, its viewing direction in the cell of `direction`.
RowTrials PredictedRow(const DirectionTrials& direction,
                       const So3Grid& grid,
                       const Eigen::Quaterniond& q_camera_object);

}  // namespace vantage
