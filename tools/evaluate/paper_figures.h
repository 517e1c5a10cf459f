#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace vantage {

// Numbers that the paper reports (Marton et al., Autonomous Robots 2017), for the report to set
// beside ours. Angles in degrees. Only numbers in tables and text are here, none read off a plot.

/// Ids of the methods that the paper names. A method of ours with such an id is shown beside it.
inline constexpr const char* kMeanId = "mean";
inline constexpr const char* kKnnId = "knn";
inline constexpr const char* kVotingId = "voting";
inline constexpr const char* kVwVotingId = "vw_voting";
inline constexpr const char* kCwId = "cw_clustering";
inline constexpr const char* kCwVwId = "cw_vw_clustering";
inline constexpr const char* kParticleFilterId = "particle_filter";
inline constexpr const char* kBinghamProductId = "bmm_mr";  ///< multiplication and reduction
inline constexpr const char* kBinghamParticlesId = "bmm_smc";

/// A line of Table 1.
struct PaperGrid {
  int k = 0;
  int64_t num_cells = 0;
  double mean_deg = 0.0;
  double deviation_deg = 0.0;
  double megabytes = 0.0;  ///< approximate
};
std::span<const PaperGrid> PaperGrids();
/// Null: the paper has no such k.
const PaperGrid* FindPaperGrid(int k);

/// Methods of Table 2, in its order.
inline constexpr std::array<const char*, 6> kPaperColumns = {
    kMeanId, kKnnId, kVotingId, kVwVotingId, kCwId, kCwVwId};
/// Place in kPaperColumns, or -1.
int PaperColumn(std::string_view method_id);

/// A line of Table 2. A half turn counts as an error even where the object has that symmetry.
struct PaperObject {
  std::string_view name;
  double median_detection_deg = 0.0;
  std::array<double, kPaperColumns.size()> final_deg{};  ///< by kPaperColumns
};
std::span<const PaperObject> PaperObjects();
/// Upper and lower case are the same. Null: the paper has no object of this name.
const PaperObject* FindPaperObject(std::string_view model_id);

/// What section 7.3.2 says of a box of Fig. 14; NaN where it says nothing. A median between two
/// numbers is given by both.
struct PaperBox {
  std::string_view method_id;
  double median_low_deg = 0.0;
  double median_high_deg = 0.0;
  double lower_quartile_deg = 0.0;
  double upper_quartile_deg = 0.0;
};
/// Null: the text says nothing of this method.
const PaperBox* FindPaperBox(std::string_view method_id);

/// What section 7.1 says of a point of Fig. 8.
struct PaperSweepPoint {
  double w_min = 0.0;
  double w_max = 0.0;
  double mean_error_deg = 0.0;
};
inline constexpr PaperSweepPoint kPaperSweepWorst{0.1, 0.2, 12.0};  ///< approximate
inline constexpr PaperSweepPoint kPaperSweepBest{0.7, 0.9, 0.1};    ///< an upper bound

}  // namespace vantage
