"""Estimates how far the wheels have rolled since their boards last reported.

A driven wheel that last reported 0.3 s ago is 3 cm farther. This distance is added up from its last
known speed, but conservatively: not once its board counts as silent; not after the command to stop;
and no faster than the wheel that reported last, which shows when the whole robot has slowed down or
stands. What has been added stays until the wheel reports, so that positions do not jump back.
"""

from __future__ import annotations

from math import inf, isnan, nan
from operator import itemgetter

from pirate_sm.core.engine import EngineState
from pirate_sm.core.robot import RobotSpec


class Rolling:
    """Follows the wheels from one look to the next.

    Args:
        robot: The robot with the wheels.
    """

    def __init__(self, robot: RobotSpec) -> None:
        count = len(robot.wheels)
        self._robot = robot
        self._now_s = -inf
        self._heard_s, self._rolled_m = [nan] * count, [nan] * count

    def look(self, state: EngineState, now_s: float) -> tuple[float, ...]:
        """Return how far each wheel has rolled since its last report, m; backward is negative.

        Args:
            state: The engine's state; a wheel is driven if the setpoints in force and the newest
                ones both drive it.
            now_s: Time, not earlier than in any earlier call.
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
        """Return the speed of the driven wheel that reported last, m/s; 0 if none is known."""
        robot, sensing = self._robot, state.sensing
        speeds = (
            (sensing.heard_s[position], sensing.numbers[wheel.speed] * wheel.metres_per_rad)
            for wheel, position in zip(robot.wheels, robot.wheel_boards, strict=True)
            if sensing.shares[wheel.place]
        )
        known = [each for each in speeds if not isnan(each[1])]
        return max(known, key=itemgetter(0))[1] if known else 0.0


def _slower(own: float, robots: float) -> float:
    """Return the slower of two speeds; 0 if signs differ, the other if one is unknown."""
    if isnan(own):
        return robots
    return sorted((own, robots, 0.0))[1]
