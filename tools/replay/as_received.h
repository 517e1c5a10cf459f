#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/log_bus.h"
#include "bus/log_bus_port.h"
#include "nodes/estimator_node.h"

namespace vantage {

/// Gives the estimators of a rerun the images that they worked on when the log was recorded, and no
/// others: each image when the recorded detections of it stand in the log, and with their seq.
/// Until then it is held.
class AsReceived {
 public:
  /// @param bus outlives this; every event is seen. @param most_bytes of images that are held.
  AsReceived(LogBus* bus, size_t most_bytes);

  /// @param name of the estimator's process. @param camera the <NAME> of its channel.
  /// @param port on which `node` has its images, which outlive this.
  void Add(const std::string& name,
           const std::string& camera,
           LogBus::Port* port,
           EstimatorNode* node);

  /// What can't be reproduced and why, a sentence each.
  [[nodiscard]] std::vector<std::string> Warnings() const;
  /// Recorded detections whose images were delivered.
  [[nodiscard]] int64_t num_delivered() const;

 private:
  struct Image {
    int64_t utime;
    int64_t arrival;
    LogEvent event;
  };
  /// An estimator that is rerun, by the channel of its detections.
  struct Estimator {
    std::string camera_channel;
    LogBus::Port* port;
    EstimatorNode* node;
    int64_t last_arrival = -1;  ///< of the images it got
    int64_t num_delivered = 0;
    int64_t num_absent = 0;    ///< detections of images that are not in the log
    int64_t num_given_up = 0;  ///< of images that could not be held so long
    int64_t num_corrupt = 0;
    double first_absent = 0.0;  ///< s since the log's start, of either
  };
  /// A count of messages of one process, as recorded.
  struct Count {
    std::optional<int64_t> first;
    int64_t last = -1;
    int64_t num_lost = 0;
    int64_t num_restarts = 0;
    double first_restart = 0.0;  ///< s since the log's start
  };

  void OnEvent(const LogEvent& event);
  void Hold(const LogEvent& event);
  void OnDetections(const LogEvent& event, Estimator* estimator);
  void Drop();
  void Note(int64_t seq, Count* count) const;
  void OnOthers(const LogEvent& event);
  [[nodiscard]] double Now() const;

  LogBus& bus_;
  size_t most_bytes_;
  std::optional<int64_t> start_utime_;
  std::map<std::string, Estimator> estimators_;
  std::map<std::string, Count> counts_;    // Of detections, and OBJECTS.
  bool has_unknown_start_ = false;         // Fusion knew something before the first detections.
  std::map<std::string, int64_t> others_;  // Detections of estimators that are not rerun.
  std::deque<Image> held_;
  size_t held_bytes_ = 0;
  int64_t arrivals_ = 0;
  std::map<std::string, int64_t> given_up_utime_;  // By camera channel, of the last one.
};

}  // namespace vantage
