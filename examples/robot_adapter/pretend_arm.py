"""An arm that is none: the same as pretend_arm.h. Put your robot's own interface in its place."""
import math
import time

SPEED = 0.5  # m/s
REACH = 1.5  # m, from the world's origin
LOWEST = 0.1  # m


class PretendArm:
    """Carries a camera straight to where it is sent. Poses are of the camera in the world: m; w, x, y, z."""

    def __init__(self):
        # Looks down at the table from the front, as the simulated arm does at its start.
        self._from = self._to = [0.0, -0.53, 0.58, 0.38268343, -0.92387953, 0.0, 0.0]
        self._duration = 0.0  # s
        self._start = time.monotonic()

    def move_to(self, trans, quat):
        """Starts to move. Returns why it does not, or an empty text when it does."""
        if not abs(math.hypot(*quat) - 1.0) < 1e-3:
            return "the orientation is no unit quaternion"
        if not (math.hypot(*trans) <= REACH and trans[2] >= LOWEST):
            return "the position is out of reach"
        _, here, turn = self.pose()
        if sum(a * b for a, b in zip(turn, quat)) < 0.0:  # q and -q are the same: by the nearer one.
            quat = [-value for value in quat]
        self._from, self._to = [*here, *turn], [*trans, *quat]
        self._duration = 0.2 + math.dist(here, trans) / SPEED
        self._start = time.monotonic()
        return ""

    def pose(self):
        """When it was measured (us since the epoch), position and orientation of the camera."""
        share = 1.0 - self.remaining() / self._duration if self._duration > 0.0 else 1.0
        pose = [a + share * (b - a) for a, b in zip(self._from, self._to)]
        norm = math.hypot(*pose[3:])
        return time.time_ns() // 1000, pose[:3], [value / norm for value in pose[3:]]

    def remaining(self):
        """Seconds until it arrives; 0 at rest."""
        return max(0.0, self._duration - (time.monotonic() - self._start))
