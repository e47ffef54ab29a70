"""Report the joint ahead on a known route, and the place on it, from the wheels' positions."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, hypot, inf, isnan, nan, pi, remainder

from pirate_sm.detectors.word_timing import REPEAT_SHARE
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.state import EngineState
from pirate_sm.geometry.joints import Joint
from pirate_sm.geometry.route import Route
from pirate_sm.geometry.space import dot
from pirate_sm.model.events import EnvironmentReport

_EVERY_M = 0.1
"""The place is reported again after this distance, about a link [decided]."""

_LEAST_SHARE = 0.2
"""With a smaller share of gravity across the pipe (78 deg) the roll is undefined."""

_BEHIND_M = 1e-6


class RouteReport:
    """Reports where the robot is on a route, and what comes next.

    Args:
        route: The route.
        roll_rad: Roll of the pipe's plane against the robot's, where the robot stays in its plane.
        planar: Whether it does: between bars.
        valid_for_s: How long a report is valid; it is repeated before.
    """

    def __init__(self, route: Route, roll_rad: float, planar: bool, valid_for_s: float) -> None:
        self._route, self._roll_rad, self._planar = route, roll_rad, planar
        self._valid_for_s = valid_for_s
        self._said: EnvironmentReport | None = None
        self._said_s = -inf

    def look(
        self, now_s: float, places_m: Sequence[float], robot: RobotSpec, state: EngineState
    ) -> EnvironmentReport | None:
        """Return a report if the place has changed or the last report must be repeated.

        Args:
            now_s: The time.
            places_m: Position of each wheel along the route; NaN is unknown.
            robot: The robot.
            state: The engine's state, for the robot's roll.
        """
        if any(map(isnan, places_m)):
            self._said = None
            return None
        front_rad = nan if self._planar else _front_roll(robot, state)
        found, before = self._report(places_m, front_rad), self._said
        if before is not None and now_s - self._said_s < REPEAT_SHARE * self._valid_for_s:
            same = (found.joint, found.junction, found.run) == (
                before.joint,
                before.junction,
                before.run,
            )
            if same and abs(found.arc_m - before.arc_m) < _EVERY_M:
                return None
        self._said, self._said_s = found, now_s
        return found

    def _report(self, places_m: Sequence[float], front_rad: float) -> EnvironmentReport:
        route, first_m, last_m = self._route, max(places_m), min(places_m)
        joint = next((each for each in route.joints if each.arc_m + each.behind_m > last_m), None)
        at_m = route.length_m if joint is None else joint.arc_m
        report = EnvironmentReport(
            *("", nan, nan, nan, self._valid_for_s),
            joint="end",
            distance_m=at_m - first_m,
            run=route.piece_at(first_m).run,
            arc_m=first_m,
        )
        if joint is None:
            return report
        behind_m = joint.arc_m + joint.behind_m + _BEHIND_M
        return report._replace(
            joint=joint.kind,
            junction=joint.junction,
            opening_roll_rad=self._opening(joint, front_rad),
            diameter_ahead_m=route.diameter_at(behind_m),
        )

    def _opening(self, joint: Joint, front_rad: float) -> float:
        """Return the roll of a joint's opening against the front part's plane; NaN if unknown."""
        if self._planar:
            return remainder(joint.towards_rad + self._roll_rad, 2 * pi)
        frame = self._route.frame_at(joint.arc_m - joint.before_m)
        side, up = dot(frame.side, self._route.up), -dot(frame.normal, self._route.up)
        if hypot(side, up) < _LEAST_SHARE:
            return nan
        return remainder(joint.towards_rad + atan2(side, up) - front_rad, 2 * pi)


def _front_roll(robot: RobotSpec, state: EngineState) -> float:
    """Return the roll of the front part against the horizontal, rad; NaN if it is unknown."""
    surveyed, imu = state.surveyed, robot.body.imu
    if imu is None or surveyed.part < 0:
        return nan
    roll_rad = surveyed.reported.roll_rad
    if imu.roll >= 0 and robot.body.parts[surveyed.part].wheels[0] > imu.link:
        roll_rad += state.sensing.numbers[imu.roll]
    return roll_rad
