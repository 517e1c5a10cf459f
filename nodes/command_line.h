#pragma once

#include <CLI/CLI.hpp>
#include <optional>

namespace vantage {

/// Reads the command line of a program that is named as its app.
/// @return the exit code when the program shall end now: 0 after --help or --version, 2 after one
/// sentence on stderr that says what is wrong.
std::optional<int> ParseCommandLine(CLI::App& app, int argc, char** argv);

}  // namespace vantage
