"""Positions of a robot's wheels in the plane of its pipe, reckoned from its signals."""

from __future__ import annotations

from math import isnan

from pirate_sm.core.engine import EngineState
from pirate_sm.core.geometry import Place
from pirate_sm.core.pipe import Pipe, Straight
from pirate_sm.core.profile import Body, Profile
from pirate_sm.core.robot import RobotSpec, confirmed_parts
from pirate_sm.robot.detectors.dead_reckoning import Reckoned, Reckoner

_PATIENCE_S = 1.0
"""A joint without a value for this long is drawn straight, s."""

_LONGEST_M = 100.0


class WheelPlacing:
    """Follows a robot by its joints and its odometer, if its true position is not known.

    Args:
        profile: The robot's profile.
        robot: The robot as the engine knows it.
        pipe: The pipe; None: a straight one.
        first_wheel_m: Position of the first wheel along the pipe at the start; None: the pipe's.
    """

    def __init__(
        self, profile: Profile, robot: RobotSpec, pipe: Pipe | None, first_wheel_m: float | None
    ) -> None:
        pipe = pipe or _somewhere(profile.body)
        self._robot = robot
        joints = (*robot.body.joints, robot.body.roll)
        self._joints = [joint for joint in joints if joint >= 0]
        self._reckoner = Reckoner(robot.body, pipe.route(), robot.odometry)
        length_m = sum(robot.body.lengths_m)
        self._first_m = pipe.start_of(length_m) if first_wheel_m is None else first_wheel_m
        self._roll_rad = pipe.start.roll if pipe.start is not None else 0.0
        self._reckoned: Reckoned | None = None
        self._angles = dict.fromkeys(self._joints, 0.0)

    def look(self, state: EngineState, now_s: float) -> tuple[Place, ...] | None:
        """Return the present position of each wheel; None before its joints have values.

        A picture needs an angle, so an unknown one is drawn with its last value.
        """
        numbers, held = list(state.sensing.numbers), confirmed_parts(self._robot, state.robot)
        unknown = [joint for joint in self._joints if isnan(numbers[joint])]
        if unknown and self._reckoned is None and now_s < _PATIENCE_S:
            return None
        for joint in unknown:
            numbers[joint] = self._angles[joint]
        self._angles = {joint: numbers[joint] for joint in self._joints}
        if self._reckoned is None:
            self._reckoned = self._reckoner.begin(self._first_m, numbers, held, self._roll_rad)
        else:
            self._reckoned = self._reckoner.look(self._reckoned, numbers, held)
        return self._reckoned.points


def _somewhere(body: Body) -> Pipe:
    """Return a straight pipe just wide enough for the robot, if the pipe is unknown."""
    straight = Straight(straight=_LONGEST_M)
    return Pipe(diameter=2.5 * body.wheel_radius, segments=(straight,))
