#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "nodes/config_reader.h"

namespace vantage {

/// One table [[up.process]]: what can't be told from the other tables about a process, or a process
/// of the user's own.
struct UpProcess {
  std::string name;                    ///< as the process is named on the bus
  bool start = true;                   ///< false: it runs elsewhere, or not at all
  std::vector<std::string> command;    ///< in place of ours; program first; empty: ours
  std::vector<std::string> arguments;  ///< after the command's own
  int nice = 0;                        ///< -20 (goes first) to 19
};

/// How vantage-up runs a set-up: table [up].
struct UpConfig {
  std::filesystem::path record;      ///< folder of recordings; empty: nothing is recorded
  std::filesystem::path log_folder;  ///< empty: below the user's state folder
  int log_size_mb = 10;              ///< a process's log is begun anew beyond it
  int log_files = 5;                 ///< older ones that are kept
  int start_s = 3;                   ///< one that ends sooner did not start
  int start_retries = 3;             ///< times that it is tried again
  int stop_s = 10;                   ///< to end in when asked; then it is killed
  std::vector<UpProcess> processes;
};

/// Errors are kept by `config`.
UpConfig ReadUpConfig(ConfigReader& config);

}  // namespace vantage
