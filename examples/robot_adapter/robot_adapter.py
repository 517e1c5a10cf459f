"""Connects an arm to Vantage: tells where its camera is and goes where it is asked."""
import lcm  # pip install lcm
from pretend_arm import PretendArm  # your robot's interface instead
from vantage import arm_status_t, next_view_t, rigid_transform_t

arm, status, pose = PretendArm(), arm_status_t(), rigid_transform_t()
status.name, status.view_seq = "XTION", -1


def on_view(_channel, data):
    try:
        view = next_view_t.decode(data)
    except Exception:
        return  # no such message
    if view.selected == -1 or view.seq == status.view_seq:
        return  # stay; asked before
    goal = view.candidates[view.selected] if 0 <= view.selected < view.num_candidates else None
    status.reason = arm.move_to(goal.trans, goal.quat) if goal else "there is no such candidate"
    status.view_seq = view.seq


bus = lcm.LCM()
bus.subscribe("NEXT_VIEW", on_view)
while True:
    bus.handle_timeout(10)  # ms
    pose.utime, pose.trans, pose.quat = arm.pose()
    status.utime, status.seq, status.remaining = pose.utime, status.seq + 1, arm.remaining()
    status.state = 1 if status.remaining > 0 else 2 if status.reason else 0  # MOVING, REFUSED, RESTING
    bus.publish("CAMERA_XTION_TO_WORLD", pose.encode())
    bus.publish("ARM_STATUS", status.encode())
