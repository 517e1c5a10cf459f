"""The message contract of docs/robot-adapter.md, asked of a running adapter over the bus. Arguments: none.
Exits with 0 when it keeps every part, else tells the first that it breaks."""
import math
import sys
import time

import lcm
from vantage import arm_status_t, next_view_t, rigid_transform_t, view_candidate_t

PATIENCE = 30  # s
poses, states = [], []
bus = lcm.LCM()
bus.subscribe("CAMERA_XTION_TO_WORLD", lambda _, data: poses.append(rigid_transform_t.decode(data)))
bus.subscribe("ARM_STATUS", lambda _, data: states.append(arm_status_t.decode(data)))


def check(holds, sentence):
    if not holds:
        sys.exit(f"FAILED: {sentence}; last status: {states and [getattr(states[-1], s) for s in states[-1].__slots__]}")
    print("ok:", sentence)


def listen(seconds):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        bus.handle_timeout(20)


def wait(condition, sentence):
    end = time.monotonic() + PATIENCE
    while not condition() and time.monotonic() < end:
        bus.handle_timeout(20)
    check(condition(), sentence)


def view(seq, trans, quat=(0.38268343, -0.92387953, 0.0, 0.0), selected=0, num=1):
    message = next_view_t()
    message.utime, message.seq, message.selected, message.num_candidates = time.time_ns() // 1000, seq, selected, num
    for _ in range(num):
        candidate = view_candidate_t()
        candidate.trans, candidate.quat, candidate.reachable = list(trans), list(quat), True
        message.candidates.append(candidate)
    return message


def ask(*arguments, **keywords):
    states.clear()
    bus.publish("NEXT_VIEW", view(*arguments, **keywords).encode())


def last(state, seq):
    return bool(states) and states[-1].state == state and states[-1].view_seq == seq


def refused(seq, sentence, *arguments, **keywords):
    before = poses[-1].trans
    ask(seq, *arguments, **keywords)
    wait(lambda: last(arm_status_t.REFUSED, seq), sentence + ": refused")
    check(states[-1].reason != "", "with a reason: " + states[-1].reason)
    listen(0.3)
    check(poses[-1].trans == before, "and the arm stays")


wait(lambda: len(poses) > 50 and states, "poses and states come")
check(last(arm_status_t.RESTING, -1), "at the start it rests and has seen no view")
gaps = sorted(b.utime - a.utime for a, b in zip(poses, poses[1:]))
check(gaps[0] > 0, "poses are in the order of their times")
check(gaps[len(gaps) // 2] <= 20000, "most poses are at most 20 ms apart")
check(abs(poses[-1].utime - time.time_ns() // 1000) < 60_000_000, "their times are us since the epoch")
check([b.seq - a.seq for a, b in zip(states, states[1:])].count(1) > 0, "states count themselves")
check(all(abs(math.hypot(*pose.quat) - 1) < 1e-6 for pose in poses), "orientations are unit quaternions")

goal = (0.2, -0.5, 0.6)
ask(1000, goal)
wait(lambda: last(arm_status_t.MOVING, 1000), "a view is accepted: it moves")
check(states[-1].remaining > 0, "and tells how long it will")
wait(lambda: last(arm_status_t.RESTING, 1000), "and rests when it is there")
listen(0.3)
check(math.dist(poses[-1].trans, goal) < 1e-6, "at the place that was asked for")
rest = poses[-10:]
check(all(pose.trans == rest[0].trans and pose.quat == rest[0].quat for pose in rest), "where the poses are the same")

ask(1000, (0.4, -0.4, 0.6))
listen(1.0)
check(last(arm_status_t.RESTING, 1000), "the same seq again is the same request")
ask(1001, goal, selected=-1)
listen(1.0)
check(last(arm_status_t.RESTING, 1000), "selected = -1 means stay")
refused(1002, "selected beyond the list", goal, selected=7)
refused(1003, "selected = -2", goal, selected=-2)
refused(1004, "no candidates", goal, selected=0, num=0)
refused(1005, "a position that is NaN", (math.nan, 0, 0.5))
refused(1006, "one that is infinite", (math.inf, 0, 0.5))
refused(1007, "one out of reach", (5, 0, 0.5))
refused(1008, "an orientation that is NaN", goal, quat=(math.nan, 0, 0, 0))
refused(1009, "one that is no rotation", goal, quat=(0, 0, 0, 0))
bus.publish("NEXT_VIEW", b"\0" * 40)
bus.publish("NEXT_VIEW", b"")
bus.publish("NEXT_VIEW", view(1010, goal).encode()[:30])
listen(0.5)
ask(1011, (0.0, -0.53, 0.58), quat=(-0.38268343, 0.92387953, 0.0, 0.0))
wait(lambda: last(arm_status_t.RESTING, 1011), "messages that are none change nothing; -q is q")
check(states[-1].reason == "", "and the reason of a refusal is forgotten")
