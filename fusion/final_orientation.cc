#include "fusion/final_orientation.h"

namespace vantage {

std::string Name(FinalOrientation final_orientation) {
  switch (final_orientation) {
    case FinalOrientation::kVoting:
      return "voting";
    case FinalOrientation::kVwVoting:
      return "vw_voting";
    case FinalOrientation::kCwClustering:
      return "cw_clustering";
    case FinalOrientation::kCwVwClustering:
      return "cw_vw_clustering";
    case FinalOrientation::kDensityMode:
      break;
  }
  return "density_mode";
}

std::optional<FinalOrientation> FinalOrientationFromName(std::string_view name) {
  for (const FinalOrientation candidate : kFinalOrientations) {
    if (Name(candidate) == name) return candidate;
  }
  return std::nullopt;
}

}  // namespace vantage
