"""Distance travelled: the median of what the wheels of the holding part have rolled.

In a bend, single wheels slip and roll up to twice as far as the robot moves. The wheels of one
clamped part all move alike, so the median ignores one of three that slips. The median is taken over
short pieces of the way, since another wheel may slip next. Wheels that the engine does not believe,
such as dead ones, are not counted; where it believes none of the part, those of the other count.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from math import inf, isnan, nan
from statistics import median

from pirate_sm.core.engine import EngineState
from pirate_sm.core.robot import RobotSpec
from pirate_sm.robot.detectors.unheard_rolling import Rolling

_PIECE_S = 0.3
"""Longer than a round of the boards, so that each wheel has reported in it [decided]."""


class Odometer:
    """Counts the distance travelled, from zero.

    Args:
        robot: The robot whose wheels are counted.
    """

    def __init__(self, robot: RobotSpec) -> None:
        count = len(robot.wheels)
        self._robot = robot
        self._rolling = Rolling(robot)
        self._angles = [nan] * count
        self._ways_m: dict[int, float] = defaultdict(float)
        self._stopped_s = inf
        self._counted_m = 0.0
        self._piece_s = nan
        self._begun_m: Sequence[float] = ()
        self._sharing: tuple[int, ...] = ()

    def look(self, state: EngineState, now_s: float, holding: Sequence[int]) -> float:
        """Return how far the robot has travelled along the pipe, m; backward counts negative.

        Args:
            state: The engine's state.
            now_s: Time, not earlier than in any earlier call.
            holding: Wheels of the part that holds the robot, or all wheels.
        """
        unheard = self._rolling.look(state, now_s)
        self._measure(state)
        totals = [self._ways_m[place] + more for place, more in enumerate(unheard)]
        piece_m = self._piece(totals)
        sharing = self._sharers(state, now_s, holding)
        if sharing != self._sharing or now_s - self._piece_s >= _PIECE_S:
            self._counted_m += piece_m
            self._begun_m, self._piece_s, self._sharing = totals, now_s, sharing
            piece_m = 0.0
        return self._counted_m + piece_m

    def _piece(self, totals: Sequence[float]) -> float:
        """Return how far the robot has travelled since the present piece began, m."""
        if not self._sharing:
            return 0.0
        return median(totals[place] - self._begun_m[place] for place in self._sharing)

    def _measure(self, state: EngineState) -> None:
        """Read the wheels' odometers."""
        for wheel in self._robot.wheels:
            shown, before = state.sensing.angles[wheel.place], self._angles[wheel.place]
            if not isnan(shown) and not isnan(before):
                self._ways_m[wheel.place] += (shown - before) * wheel.metres_per_rad
            self._angles[wheel.place] = shown

    def _may_roll(self, state: EngineState, now_s: float) -> bool:
        """Return whether wheels are driven, or one has not reported since and is not silent."""
        in_force, newest = state.robot.values, state.robot.latest
        if any(in_force[wheel.slot] or newest[wheel.slot] for wheel in self._robot.wheels):
            self._stopped_s = inf
            return True
        self._stopped_s = min(self._stopped_s, now_s)
        heard_s = [state.sensing.heard_s[position] for position in self._robot.wheel_boards]
        silent_s = now_s - self._robot.link.silent_after_s
        return any(silent_s < at <= self._stopped_s for at in heard_s)

    def _sharers(self, state: EngineState, now_s: float, holding: Sequence[int]) -> tuple[int, ...]:
        """Return the indices of the wheels whose median counts now."""
        if not self._may_roll(state, now_s):
            return ()
        in_force, newest = state.robot.values, state.robot.latest
        silent_s = now_s - self._robot.link.silent_after_s
        heard = [
            wheel
            for wheel, position in zip(self._robot.wheels, self._robot.wheel_boards, strict=True)
            if state.sensing.heard_s[position] > silent_s and not isnan(self._angles[wheel.place])
        ]
        driven = [
            wheel.place
            for wheel in heard
            if in_force[wheel.slot] or newest[wheel.slot] or wheel.place in self._sharing
        ]
        driven = [place for place in driven if place not in state.sensing.distance.out] or driven
        return tuple(place for place in driven if place in holding) or tuple(driven)
