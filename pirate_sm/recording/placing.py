"""Where a robot's wheels are in the plane of its pipe: known, or reckoned from its signals."""

from __future__ import annotations

from math import isnan

from pirate_sm.detectors.reckoning import Reckoned, Reckoner, chain_of
from pirate_sm.detectors.route import Place, Route
from pirate_sm.engine.robot import RobotSpec
from pirate_sm.engine.robot_state import confirmed_parts
from pirate_sm.engine.state import EngineState
from pirate_sm.model.body import Body
from pirate_sm.model.pipe import Pipe, Straight
from pirate_sm.model.profile import Profile

_PATIENCE_S = 1.0
"""A joint that has said nothing for so long is taken to be straight."""

_LONGEST_M = 100.0


class Placing:
    """Follows a robot by its joints and its odometer, where nobody knows better.

    Args:
        profile: The robot.
        robot: The same, as the engine knows it.
        pipe: Where it is; None: somewhere straight.
        first_wheel_m: Where its first wheel began along the pipe; None: as the pipe says.
    """

    def __init__(
        self, profile: Profile, robot: RobotSpec, pipe: Pipe | None, first_wheel_m: float | None
    ) -> None:
        pipe = pipe or _somewhere(profile.body)
        chain = chain_of(profile, robot, pipe)
        length_m = sum(chain.lengths_m)
        self._robot = robot
        self._joints = [joint for joint in chain.joints if joint >= 0]
        self._reckoner = Reckoner(chain, Route(pipe), robot.odometry)
        self._first_m = pipe.start_of(length_m) if first_wheel_m is None else first_wheel_m
        self._reckoned: Reckoned | None = None

    def look(self, state: EngineState, now_s: float) -> tuple[Place, ...] | None:
        """The place of each wheel now; None before its joints have spoken."""
        numbers, held = state.sensing.numbers, confirmed_parts(self._robot, state.robot)
        if self._reckoned is not None:
            self._reckoned = self._reckoner.look(self._reckoned, numbers, held)
        elif now_s < _PATIENCE_S and any(isnan(numbers[joint]) for joint in self._joints):
            return None
        else:
            self._reckoned = self._reckoner.begin(self._first_m, numbers, held)
        return self._reckoned.points


def _somewhere(body: Body) -> Pipe:
    """A straight just wide enough for the robot, for a run of which no pipe is known."""
    straight = Straight(straight=_LONGEST_M)
    return Pipe(diameter=2.5 * body.wheel_radius, segments=(straight,))
