#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "bus/event_log_reader.h"
#include "common/result.h"

namespace vantage {

/// Turns the events of a log, one after the other, into files of another kind. Nothing is left
/// behind without Finish().
class LogExporter {
 public:
  virtual ~LogExporter() = default;

  /// @param wanted whether the event is to be exported; others may say where a camera was.
  /// Errors: the system refuses. Malformed messages are counted, and told by Finish().
  virtual Result<void> Add(const LogEventView& event, bool wanted) = 0;
  /// Completes the output. @return what was written and what was left out, in lines for people.
  /// Errors: there was nothing to export, the system refuses.
  virtual Result<std::string> Finish() = 0;
};

/// A folder for each camera, as `vantage-log import` reads them: depth as 16-bit PNG in mm, color
/// beside it, poses and intrinsics as texts, views.csv. Errors: as ExportFolder::Create().
Result<std::unique_ptr<LogExporter>> MakeImageExporter(const std::filesystem::path& folder);

/// The points of each depth image that has a pose, in world coordinates, m, as binary PLY; colored
/// where color is registered. With `merge` all of a camera in one file. Errors: as
/// ExportFolder::Create().
Result<std::unique_ptr<LogExporter>> MakePlyExporter(const std::filesystem::path& folder,
                                                     bool merge);

/// A table for each channel, one line a message, and one for each of its lists. Errors: as
/// ExportFolder::Create().
Result<std::unique_ptr<LogExporter>> MakeCsvExporter(const std::filesystem::path& folder);

/// An MCAP file that Foxglove shows. Errors: it exists, or the system refuses.
Result<std::unique_ptr<LogExporter>> MakeMcapExporter(const std::filesystem::path& file);

}  // namespace vantage
