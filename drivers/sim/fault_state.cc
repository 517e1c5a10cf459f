#include "drivers/sim/fault_state.h"

namespace vantage {

void FaultState::Apply(const SimFault& fault, double now) {
  const bool lasts = fault.duration > 0.0;  // False for NaN too.
  const double end = lasts ? now + fault.duration : kForEver;
  switch (fault.kind) {
    case SimFault::Kind::kUnplug:
      unplugged_until_ = end;
      break;
    case SimFault::Kind::kReplug:
      *this = FaultState();
      break;
    case SimFault::Kind::kStall:
      stalled_until_ = end;
      break;
    case SimFault::Kind::kShortFrame:
      if (lasts) {
        short_until_ = end;
      } else {
        ++short_frames_;
      }
      break;
  }
}

bool FaultState::TakeShortFrame(double now) {
  if (now < short_until_) return true;
  if (short_frames_ == 0) return false;
  --short_frames_;
  return true;
}

}  // namespace vantage
