#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace vantage {

/// How the final orientation q_f comes from the histogram: the four ways of paper 5.2, and the
/// exact mode of the density that the histogram stands for.
enum class FinalOrientation {
  kVoting,          ///< representative of the cell with most detections
  kVwVoting,        ///< the same, each detection counting w_v (eq. 4)
  kCwClustering,    ///< mean of the heaviest cluster (eq. 7) of confidence weights (eq. 3)
  kCwVwClustering,  ///< the same with verification weights too (eq. 5)
  kDensityMode,     ///< from there, the mode of the raw weighted detections' density
};

inline constexpr std::array<FinalOrientation, 5> kFinalOrientations = {
    FinalOrientation::kVoting,
    FinalOrientation::kVwVoting,
    FinalOrientation::kCwClustering,
    FinalOrientation::kCwVwClustering,
    FinalOrientation::kDensityMode};

/// "voting", "vw_voting", "cw_clustering", "cw_vw_clustering", "density_mode".
std::string Name(FinalOrientation final_orientation);
/// The inverse; nothing for another name.
std::optional<FinalOrientation> FinalOrientationFromName(std::string_view name);

}  // namespace vantage
