#include "drivers/sim/fault_state.h"

namespace vantage {
namespace {

using Kind = SimFault::Kind;

// Without a duration these hold for one frame, all others for good.
bool IsOfOneFrame(Kind kind) { return kind == Kind::kShortFrame || kind >= Kind::kNoData; }

}  // namespace

void FaultState::Apply(const SimFault& fault, double now) {
  if (fault.kind == Kind::kReplug) {
    *this = FaultState();
    return;
  }
  Fault& state = faults_.at(static_cast<size_t>(fault.kind));
  if (fault.duration > 0.0) {  // False for NaN too.
    state.until = now + fault.duration;
  } else if (IsOfOneFrame(fault.kind)) {
    ++state.frames;
  } else {
    state.until = std::numeric_limits<double>::infinity();
  }
}

bool FaultState::Lasts(Kind kind, double now) const {
  return now < faults_.at(static_cast<size_t>(kind)).until;
}

bool FaultState::TakeFrame(Kind kind, double now) {
  if (Lasts(kind, now)) return true;
  int& frames = faults_.at(static_cast<size_t>(kind)).frames;
  if (frames == 0) return false;
  --frames;
  return true;
}

}  // namespace vantage
