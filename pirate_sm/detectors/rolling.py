"""What the wheels must have rolled since their boards last reported.

Where frames get lost the odometer lags: a wheel that drives and was last heard 0.3 s ago is 3 cm
farther. What it has rolled meanwhile is taken to be its last known speed times the age of that
frame, but never more than can be vouched for: no longer than until its board counts as silent, not
beyond the moment at which it was told to stop, and no faster than the wheel that was heard last,
which shows when the robot as a whole has become slower or stands.
"""

from __future__ import annotations

from math import inf, isnan

from pirate_sm.engine.robot import RobotSpec
from pirate_sm.engine.state import EngineState


class Rolling:
    """Follows the wheels from one look to the next.

    Args:
        robot: Whose wheels they are.
    """

    def __init__(self, robot: RobotSpec) -> None:
        self._robot = robot
        self._driven_s = [-inf] * len(robot.wheels)

    def look(self, state: EngineState, now_s: float) -> float:
        """How far the odometer must be behind, m; negative when driving backward.

        Args:
            state: The engine's; a wheel is driven when the setpoints in force and the newest ones
                both say so.
            now_s: Not before that of any earlier look.
        """
        robot, sensing = self._robot, state.sensing
        in_force, newest = state.robot.values, state.robot.latest
        freshest_s, freshest = -inf, 0.0
        rolling: list[tuple[float, float, float]] = []
        for wheel, position in zip(robot.wheels, robot.wheel_boards, strict=True):
            if in_force[wheel.slot] and newest[wheel.slot]:
                self._driven_s[wheel.place] = now_s
            share, heard_s = sensing.shares[wheel.place], sensing.heard_s[position]
            if not share or now_s - heard_s > robot.link.silent_after_s:
                continue
            speed = sensing.numbers[wheel.speed] * wheel.metres_per_rad
            if not isnan(speed) and heard_s > freshest_s:
                freshest_s, freshest = heard_s, speed
            rolling.append((share, speed, self._driven_s[wheel.place] - heard_s))
        return sum(
            share * _slower(speed, freshest) * max(age, 0.0) for share, speed, age in rolling
        )


def _slower(own: float, robots: float) -> float:
    """The slower of two speeds, 0 where they differ in sign; the robot's where its own is unknown."""
    if isnan(own):
        return robots
    return min(own, robots, key=abs) if own * robots > 0.0 else 0.0
