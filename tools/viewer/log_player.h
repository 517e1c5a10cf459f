#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/event_log.h"
#include "common/result.h"
#include "tools/viewer/viewer_state.h"

namespace vantage {

/// A log as a film: the state at any time of it. Time never goes back in it: an event that is
/// stamped earlier than one before it counts as of that one's time. Memory is bounded, however long
/// the log.
class LogPlayer {
 public:
  /// Reads the first event. Errors: as EventLogReader::Open(), or no event in it.
  static Result<std::unique_ptr<LogPlayer>> Open(const std::filesystem::path& log,
                                                 const SceneCloud::Parameters& cloud);

  /// Plays the whole log once, to know its length and its marks, and to be quick anywhere in it
  /// after. The state is that of the end.
  /// @param progress called with the share that is done, [0, 1]
  /// Errors: no message in it that the viewer shows.
  Result<void> Survey(const std::function<void(double share)>& progress);

  /// Goes to where all events up to `utime` have been applied.
  void GoTo(int64_t utime);
  [[nodiscard]] const ViewerState& state() const { return state_; }

  [[nodiscard]] int64_t start_utime() const { return start_utime_; }
  [[nodiscard]] int64_t end_utime() const { return end_utime_; }
  /// Times of DETECTIONS_*, OBJECTS and NEXT_VIEW, ascending.
  [[nodiscard]] const std::vector<int64_t>& marks() const { return marks_; }
  /// Times at which a viewpoint was added, ascending.
  [[nodiscard]] const std::vector<int64_t>& views() const { return views_; }
  /// In words; empty: none met so far.
  [[nodiscard]] std::string Damage() const;

 private:
  static constexpr size_t kMaxKeyframes = 48;
  static constexpr size_t kMaxMarks = 200'000;

  struct Keyframe {
    int64_t utime;
    int64_t num_events;   // Applied before it.
    int64_t next_offset;  // Bytes, of the event after it; of the file's end after the last.
    ViewerState state;
  };

  LogPlayer(std::filesystem::path log, const SceneCloud::Parameters& cloud)
      : log_(std::move(log)), cloud_(cloud) {}

  Result<void> Restart();
  bool MoveTo(const Keyframe& keyframe);
  void ReadNext();
  void ApplyNext();
  void Mark(const std::string& channel);
  void KeepKeyframe();

  std::filesystem::path log_;
  SceneCloud::Parameters cloud_;
  std::unique_ptr<EventLogReader> reader_;
  std::optional<LogEventView> next_;  // Of the reader.
  int64_t next_utime_ = 0;            // Of the next event, never less than of those before.
  int64_t num_events_ = 0;            // Applied.
  ViewerState state_;
  int64_t start_utime_ = 0;
  int64_t end_utime_ = 0;
  int num_viewpoints_ = 0;
  std::vector<Keyframe> keyframes_;
  int64_t keyframe_interval_ = 500;  // Events.
  std::vector<int64_t> marks_;
  std::vector<int64_t> views_;
  std::string damage_;
};

}  // namespace vantage
