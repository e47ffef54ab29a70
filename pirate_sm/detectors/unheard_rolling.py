"""Estimates what the wheels have rolled since their boards last reported.

A wheel that drives and was last heard 0.3 s ago is 3 cm farther. What it rolls meanwhile is added
up from its last known speed, but no more than is sure: not once its board counts as silent; not
after it was told to stop; and no faster than the wheel that was heard last, which shows when the
robot as a whole has become slower or stands. What has been added stays until the wheel is heard:
else places would leap back.
"""

from __future__ import annotations

from math import inf, isnan

from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.state import EngineState


class Rolling:
    """Follows the wheels from one look to the next.

    Args:
        robot: Whose wheels they are.
    """

    def __init__(self, robot: RobotSpec) -> None:
        count = len(robot.wheels)
        self._robot = robot
        self._now_s = -inf
        self._heard_s = [-inf] * count
        self._rolled_m = [0.0] * count

    def look(self, state: EngineState, now_s: float) -> tuple[float, ...]:
        """Return how far each wheel has rolled unheard, m; negative when driving backward.

        Args:
            state: The engine's; a wheel is driven when the setpoints in force and the newest ones
                both say so.
            now_s: Not before that of any earlier look.
        """
        robot, sensing = self._robot, state.sensing
        in_force, newest = state.robot.values, state.robot.latest
        robots = self._freshest(state)
        for wheel, position in zip(robot.wheels, robot.wheel_boards, strict=True):
            place, heard_s = wheel.place, sensing.heard_s[position]
            if heard_s != self._heard_s[place]:
                self._heard_s[place], self._rolled_m[place] = heard_s, 0.0
            if in_force[wheel.slot] and newest[wheel.slot]:
                speed = _slower(sensing.numbers[wheel.speed] * wheel.metres_per_rad, robots)
                until_s = min(now_s, heard_s + robot.link.silent_after_s)
                lasting_s = max(0.0, until_s - max(self._now_s, heard_s))
                self._rolled_m[place] += speed * lasting_s
        self._now_s = now_s
        return tuple(self._rolled_m)

    def _freshest(self, state: EngineState) -> float:
        """Speed of the driven wheel that was heard last, m/s; 0 where none is known."""
        robot, sensing = self._robot, state.sensing
        heard_s, freshest = -inf, 0.0
        for wheel, position in zip(robot.wheels, robot.wheel_boards, strict=True):
            speed = sensing.numbers[wheel.speed] * wheel.metres_per_rad
            known = sensing.shares[wheel.place] and not isnan(speed)
            if known and sensing.heard_s[position] > heard_s:
                heard_s, freshest = sensing.heard_s[position], speed
        return freshest


def _slower(own: float, robots: float) -> float:
    """Return the slower of two speeds; 0 where signs differ, the other where one is unknown."""
    if isnan(own):
        return robots
    return min(own, robots, key=abs) if own * robots > 0.0 else 0.0
