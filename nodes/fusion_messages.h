#pragma once

#include <cstdint>
#include <span>

#include "fusion/object_tracker.h"
#include "perception/refinement/multi_view_refiner.h"
#include "planner/next_best_view.h"
#include "vantage/next_view_t.hpp"
#include "vantage/object_estimates_v3_t.hpp"
#include "vantage/orientation_histogram_t.hpp"

namespace vantage {

/// Objects as a message; utime, seq, num_viewpoints and finished are the caller's to fill in.
object_estimates_v3_t ObjectsToMessage(std::span<const ObjectEstimate> objects);

/// Fills in what the refinement says of an object.
void AddRefinement(const MultiViewRefined& refined, object_estimate_v3_t* message);

/// The histogram of one object, its heaviest cells if there are more than kMostCells, ascending;
/// utime and seq are the caller's to fill in.
orientation_histogram_t HistogramToMessage(const ObjectEstimate& object);

/// Cells in a histogram's message: 32 kB, well below what a UDP datagram holds.
inline constexpr size_t kMostCells = 4000;

/// A decision as a message; utime and seq are the caller's to fill in.
next_view_t NextViewToMessage(const NextView& view);

}  // namespace vantage
