#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "common/result.h"
#include "fusion/tracker_state.h"
#include "planner/view_sequence.h"

namespace vantage {

/// What vantage-fusion needs to go on after it was ended.
struct FusionState {
  std::string setup;  ///< FusionConfig::setup of the run that it is from
  int64_t utime = 0;  ///< us, of the last image used
  ViewSequenceState views;
  TrackerState tracker;
};

/// Writes the file whole or not at all: beside it, flushed to the disk, then renamed.
/// Errors: the system refuses.
Result<void> SaveFusionState(const FusionState& state, const std::filesystem::path& file);

/// Nothing when there is no such file. Errors: it can't be read, is no state of this program, is
/// damaged, or is of another set-up than `setup`.
Result<std::optional<FusionState>> LoadFusionState(const std::filesystem::path& file,
                                                   const std::string& setup);

/// Makes the file's folder. Errors: it can't be made or written; what is there is no regular file.
Result<void> PrepareStateFile(const std::filesystem::path& file);

/// Gives the file the name FILE.bad, replacing an earlier one.
Result<void> MoveAside(const std::filesystem::path& file);

}  // namespace vantage
