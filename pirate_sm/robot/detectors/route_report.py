"""Report the joint ahead on a known route, and the place on it, from the wheels' positions."""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan, nan, pi, remainder

from pirate_sm.core.events import EnvironmentReport
from pirate_sm.core.geometry import Route, RouteJoint
from pirate_sm.robot.detectors.word_timing import REPEAT_SHARE

_EVERY_M = 0.1
"""The place is reported again after this distance, about a link [decided]."""

_BEHIND_M = 1e-6


class RouteReport:
    """Reports where the robot is on a route, and what comes next.

    Args:
        route: The route.
        valid_for_s: How long a report is valid; it is repeated before.
    """

    def __init__(self, route: Route, valid_for_s: float) -> None:
        self._route = route
        self._valid_for_s = valid_for_s
        ends_m = [joint.arc_m + joint.behind_m for joint in route.joints]
        self._changes_m = *ends_m, *(piece.arc_m for piece in route.pieces)
        self._said: tuple[float, RouteJoint | None, EnvironmentReport] | None = None

    def look(
        self, now_s: float, places_m: Sequence[float], front_roll_rad: float
    ) -> EnvironmentReport | None:
        """Return a report if the place has changed or the last report must be repeated.

        Args:
            now_s: The time.
            places_m: Position of each wheel along the route; NaN is unknown.
            front_roll_rad: Roll of the front part against the frame of the pipe; NaN is unknown.
        """
        if any(map(isnan, places_m)):
            self._said = None
            return None
        joints, first_m, last_m = self._route.joints, max(places_m), min(places_m)
        joint = next((each for each in joints if each.arc_m + each.behind_m > last_m), None)
        if self._said is not None and now_s - self._said[0] < REPEAT_SHARE * self._valid_for_s:
            _, known, before = self._said
            same = joint is known and self._route.piece_at(first_m).run == before.run
            if same and abs(first_m - before.arc_m) < _EVERY_M:
                return None
        found = self._report(joint, first_m, front_roll_rad)
        self._said = now_s, joint, found
        return found

    def wait_s(self, places_m: Sequence[float], top_m_s: float) -> float:
        """Return how long no wheel can reach another joint or pipe; arguments as for the others."""
        ends_m = max(places_m), min(places_m)
        return min([abs(at - end) for at in self._changes_m for end in ends_m]) / top_m_s

    def _report(
        self, joint: RouteJoint | None, first_m: float, front_roll_rad: float
    ) -> EnvironmentReport:
        route = self._route
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
            # The frame is carried to the joint without twist.
            opening_roll_rad=remainder(joint.towards_rad - front_roll_rad, 2 * pi),
            diameter_ahead_m=route.diameter_at(behind_m),
        )
