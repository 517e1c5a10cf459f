#pragma once

#include <CLI/CLI.hpp>

#include "tools/replay/replay_options.h"

namespace vantage {

/// Adds the command line options that say what one rerun does. Both outlive the parsing.
void AddReplayArguments(CLI::App* app, ReplayOptions* options);

}  // namespace vantage
