#pragma once

#include <limits>

namespace vantage {

/// A way for the simulated camera to misbehave.
struct SimFault {
  enum class Kind {
    kUnplug,      ///< gone for `duration`; 0: until kReplug
    kReplug,      ///< back, and every other fault ends
    kStall,       ///< delivers no frames for `duration`; 0: until kReplug
    kShortFrame,  ///< delivers half frames for `duration`; 0: one frame
  };
  Kind kind = Kind::kReplug;
  double duration = 0.0;  ///< s
};

/// Which faults are in force. Time is passed in, s, and never goes back.
class FaultState {
 public:
  /// A duration that is no number >= 0 counts as 0.
  void Apply(const SimFault& fault, double now);

  [[nodiscard]] bool Plugged(double now) const { return now >= unplugged_until_; }
  [[nodiscard]] bool Stalled(double now) const { return now < stalled_until_; }
  /// True when the frame in hand shall be short.
  bool TakeShortFrame(double now);

 private:
  static constexpr double kForEver = std::numeric_limits<double>::infinity();

  double unplugged_until_ = -kForEver;
  double stalled_until_ = -kForEver;
  double short_until_ = -kForEver;
  int short_frames_ = 0;
};

}  // namespace vantage
