// Connects an arm to Vantage: tells where its camera is and goes where it is asked.
#include <lcm/lcm-cpp.hpp>

#include "pretend_arm.h"  // your robot's interface instead
#include "vantage/arm_status_t.hpp"
#include "vantage/next_view_t.hpp"
#include "vantage/rigid_transform_t.hpp"
struct Adapter {
  PretendArm arm;
  vantage::arm_status_t status{0, 0, "XTION", 0, -1, 0.0, ""};
  void OnView(const lcm::ReceiveBuffer*, const std::string&, const vantage::next_view_t* view) {
    if (view->selected == -1 || view->seq == status.view_seq) return;  // stay; asked before
    const bool known = view->selected >= 0 && view->selected < view->num_candidates;
    const auto* goal = known ? &view->candidates[view->selected] : nullptr;
    status.reason = known ? arm.MoveTo(goal->trans, goal->quat) : "there is no such candidate";
    status.view_seq = view->seq;
  }
};
int main() {
  lcm::LCM lcm;
  Adapter self;
  if (!lcm.good() || !lcm.subscribe("NEXT_VIEW", &Adapter::OnView, &self)) return 1;
  for (vantage::rigid_transform_t pose{}; lcm.handleTimeout(10) >= 0; ++self.status.seq) {
    pose.utime = self.status.utime = self.arm.Pose(pose.trans, pose.quat);
    self.status.remaining = self.arm.Remaining();  // RESTING = 0, MOVING = 1, REFUSED = 2
    self.status.state = self.status.remaining > 0.0 ? 1 : (self.status.reason.empty() ? 0 : 2);
    lcm.publish("CAMERA_XTION_TO_WORLD", &pose);
    lcm.publish("ARM_STATUS", &self.status);
  }
}
