#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bus/sequence_tracker.h"
#include "tools/monitor/arrival_statistics.h"
#include "vantage/arm_status_t.hpp"
#include "vantage/camera_status_v2_t.hpp"
#include "vantage/handeye_check_t.hpp"
#include "vantage/process_status_t.hpp"

namespace vantage {

/// A channel as it is seen on the bus, whoever listens to it.
struct SeenChannel {
  std::string type;  ///< "images_t", a fingerprint of a type that is none of ours, "(several)"
  int64_t num_messages = 0;
  int64_t num_bytes = 0;
  int64_t num_lost = 0;       ///< by gaps of seq
  int64_t num_malformed = 0;  ///< of a type of ours, but its bytes are not
  int64_t last_utime = 0;     ///< us, of arrival
  ArrivalStatistics arrivals;
};

/// What a process lost of a channel since it is watched, over its restarts.
struct ChannelLosses {
  int64_t lost = 0;
  int64_t overwritten = 0;
  int64_t decode_errors = 0;
};

struct SeenProcess {
  process_status_t status{};    ///< the last one
  int64_t last_utime = 0;       ///< us, of its arrival
  int64_t longest_silence = 0;  ///< us, between two of them
  int num_restarts = 0;
  /// Times that one came of a start before the last: two processes have this name.
  int num_conflicts = 0;
  std::string fault;  ///< the last state other than "ok" that came after an "ok"; empty: none
  std::map<std::string, ChannelLosses> losses;  ///< by channel
};

struct SeenCamera {
  camera_status_v2_t status{};  ///< the last one
  int64_t last_utime = 0;       ///< us, of its arrival
  int num_interruptions = 0;    ///< times that it streamed and then did not
  int64_t num_captured = 0;     ///< since it is watched
  int64_t num_missed = 0;       ///< likewise
};

struct SeenArm {
  arm_status_t status{};
  int64_t last_utime = 0;  ///< us, of its arrival
};

struct SeenHandEye {
  handeye_check_t check{};
  int64_t last_utime = 0;  ///< us, of its arrival
};

/// What the messages on a bus, or in a log, tell about the set-up that sends them. Memory is
/// bounded whatever comes; names are kept as they came, cut off at 200 characters.
class MonitorModel {
 public:
  /// @param utime us since the epoch, of arrival; the clock of all ages.
  void Add(const std::string& channel, int64_t utime, std::span<const std::byte> bytes);

  [[nodiscard]] const std::map<std::string, SeenChannel>& channels() const { return channels_; }
  [[nodiscard]] const std::map<std::string, SeenProcess>& processes() const { return processes_; }
  /// By the <NAME> of the camera.
  [[nodiscard]] const std::map<std::string, SeenCamera>& cameras() const { return cameras_; }
  [[nodiscard]] const std::map<std::string, SeenArm>& arms() const { return arms_; }
  [[nodiscard]] const std::map<std::string, SeenHandEye>& hand_eyes() const { return hand_eyes_; }
  /// Messages of channels, processes or cameras for which there was no room.
  [[nodiscard]] int64_t num_not_kept() const { return num_not_kept_; }
  /// us, of the first and the last message; 0: none yet.
  [[nodiscard]] int64_t first_utime() const { return first_utime_; }
  [[nodiscard]] int64_t last_utime() const { return last_utime_; }
  /// The configuration that most processes run with; of several equally many, the first by name.
  [[nodiscard]] std::string CommonConfigHash() const;

  static constexpr size_t kMaxChannels = 1000;
  static constexpr size_t kMaxProcesses = 200;
  static constexpr size_t kMaxDevices = 100;    ///< cameras, arms, hand-eye checks
  static constexpr size_t kMaxOfProcess = 200;  ///< channels, and stages, of one process

 private:
  template <class Seen>
  Seen* Find(const std::string& name, size_t most, std::map<std::string, Seen>* all);
  void Look(const std::string& type, int64_t utime, std::span<const std::byte> bytes);
  void AddProcess(process_status_t status, int64_t utime);
  void AddCamera(camera_status_v2_t status, int64_t utime);

  std::map<std::string, SeenChannel> channels_;
  std::map<std::string, SeenProcess> processes_;
  std::map<std::string, SeenCamera> cameras_;
  std::map<std::string, SeenArm> arms_;
  std::map<std::string, SeenHandEye> hand_eyes_;
  SequenceTracker sequence_;
  int64_t num_not_kept_ = 0;
  int64_t first_utime_ = 0;
  int64_t last_utime_ = 0;
};

/// Tools that listen, and come and go as they please: nothing is wrong when they fall silent or
/// lose messages.
bool IsWatcher(const std::string& process_name);

}  // namespace vantage
