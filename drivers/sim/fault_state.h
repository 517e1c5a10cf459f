#pragma once

#include <array>
#include <cstddef>
#include <limits>

namespace vantage {

/// A way for the simulated camera to misbehave.
struct SimFault {
  enum class Kind {
    kUnplug,         ///< gone for `duration`; 0: until kReplug
    kReplug,         ///< back, and every other fault ends
    kStall,          ///< delivers no frames for `duration`; 0: until kReplug
    kShortFrame,     ///< delivers half frames for `duration`; 0: one frame
    kColorStop,      ///< delivers no color for `duration`; 0: until kReplug, as the next three
    kColorHalfRate,  ///< delivers every other color image
    kColorLate,      ///< takes color half a period after depth
    kColorOffset,    ///< stamps color 1 s ahead
    kNoData,         ///< delivers frames without pixels for `duration`; 0: one frame
    kResized,        ///< delivers frames of half the width, likewise
    kAbsurdSize,     ///< delivers frames that claim sizes no image has, likewise
    kStampBack,      ///< stamps frames 5 s early, likewise
  };
  static constexpr size_t kNumKinds = 12;

  Kind kind = Kind::kReplug;
  double duration = 0.0;  ///< s
};

/// Which faults are in force. Time is passed in, s, and never goes back.
class FaultState {
 public:
  /// A duration that is no number >= 0 counts as 0.
  void Apply(const SimFault& fault, double now);

  [[nodiscard]] bool Plugged(double now) const { return !Lasts(SimFault::Kind::kUnplug, now); }
  [[nodiscard]] bool Stalled(double now) const { return Lasts(SimFault::Kind::kStall, now); }
  /// True when the frame in hand shall have a fault; uses up one that is for one frame.
  bool TakeFrame(SimFault::Kind kind, double now);

 private:
  struct Fault {
    double until = -std::numeric_limits<double>::infinity();
    int frames = 0;
  };
  [[nodiscard]] bool Lasts(SimFault::Kind kind, double now) const;

  std::array<Fault, SimFault::kNumKinds> faults_{};  // By kind.
};

}  // namespace vantage
