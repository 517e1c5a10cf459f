#pragma once

#include <filesystem>
#include <string>

#include "common/result.h"

namespace vantage {

/// Where vantage-up keeps what belongs to one set-up while it runs. The folder is the user's alone,
/// so the supervisor's socket in it is too.
struct RunFolder {
  std::filesystem::path folder;
  std::filesystem::path logs;  ///< elsewhere: outlives the run
  std::string id;              ///< of the set-up: the config's name and a hash of where it lies

  [[nodiscard]] std::filesystem::path config() const { return folder / "supervisord.conf"; }
  [[nodiscard]] std::filesystem::path socket() const { return folder / "supervisor.sock"; }
  [[nodiscard]] std::filesystem::path pid_file() const { return folder / "supervisord.pid"; }
  /// A link to `logs`: the supervisor's file can't hold every path.
  [[nodiscard]] std::filesystem::path log_link() const { return folder / "log"; }
};

/// @param config absolute; @param chosen --folder; empty: XDG_RUNTIME_DIR/vantage/ID, or
/// /tmp/vantage-UID/ID where there is no such folder
/// @param logs [up] log_folder; empty: XDG_STATE_HOME or ~/.local/state, vantage/ID
/// Errors: a path that the supervisor's file or a socket's address can't hold.
Result<RunFolder> ChooseRunFolder(const std::filesystem::path& config,
                                  const std::filesystem::path& chosen,
                                  const std::filesystem::path& logs);

/// Makes the folder, for its owner alone, and keeps other processes from starting in it for as long
/// as this one lives. Errors: it can't be made or written, is somebody else's, or another is at
/// work.
Result<void> TakeRunFolder(const RunFolder& run);

/// Makes the folder of the logs and the link to it. Errors: the system refuses; it can't be
/// written.
Result<void> MakeLogFolder(const RunFolder& run);

/// Whether a supervisor serves the folder's socket.
bool IsUp(const RunFolder& run);

}  // namespace vantage
