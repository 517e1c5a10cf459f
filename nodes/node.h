#pragma once

#include <chrono>

namespace vantage {

/// The work of one process on one Bus: the same object live, on a log that is played into the bus,
/// and inside vantage-replay. Its constructor subscribes; handlers do the rest.
class Node {
 public:
  virtual ~Node() = default;

  /// Called on the bus's thread at least every poll_interval() when live, never over a log: for
  /// drivers, whose input is a device and not messages.
  virtual void Poll() {}
  [[nodiscard]] virtual std::chrono::milliseconds poll_interval() const {
    return std::chrono::milliseconds(100);
  }
};

}  // namespace vantage
