#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "tools/viewer/log_player.h"
#include "tools/viewer/viewer_options.h"
#include "tools/viewer/viewer_state.h"

namespace vantage {

/// Changes what is shown by a key (X's name of it): v vector, o object, c color of the cloud, d
/// cloud, n candidates, u uncertainty. False: not one of these.
bool ChangeOptions(const std::string& key, const ViewerState& state, ViewerOptions* options);

/// Where a key leads in a log: Left and Right to the decision, detection or estimate before and
/// after, Page Up and Down by view, Home, End. Nothing: not one of these, or there is none.
std::optional<int64_t> KeyTime(const std::string& key, const LogPlayer& player, int64_t utime);

/// The keys and what they do, for --help.
std::string KeyHelp();

}  // namespace vantage
