"""A rule about tees that a route passes straight on: no wheel drives over the branch's mouth."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi, remainder

from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.pipe.course_points import CoursePoint
from pirate_sm.checking.pipe.pipe_view import PipeView, mm
from pirate_sm.checking.pipe.roll_joint import QUARTER_RAD, PartRolls
from pirate_sm.core.geometry import RouteJoint, sink_m

MOST_SINK_M = 0.01
"""How far a wheel may sink into a mouth. Simulated robots pass a tee in 120 mm where it is 7.5 mm,
and lose their hold or stay there where it is 10.5 mm (docs/decisions/0070)."""


def keeps_off_the_mouths(view: PipeView) -> Iterator[Finding]:
    """Report tees that are passed straight on while a part's wheels stand over the mouth."""
    bends = view.bends_behind_start
    for joint in view.fit.route.joints:
        if joint.kind != "tee" or joint.turn_rad:
            continue
        number = sum(bend.arc_m < joint.arc_m for bend in view.bends) - bends
        driven = [each for each in view.course.situations if _drives_at(view, each, joint, number)]
        sinks = [_sinks_m(view, joint, each.rolls) for each in driven if each.rolls is not None]
        deep = [max(each) > MOST_SINK_M for each in sinks]
        if driven and len(deep) == len(driven) and all(deep):
            yield _finding(view, joint, driven[0], sinks[0], number)


def _drives_at(view: PipeView, point: CoursePoint, joint: RouteJoint, number: int) -> bool:
    """Return whether the robot drives towards a tee in the stretch with this number."""
    if not view.fit.robot.driven[point.configuration]:
        return False
    if point.bent and len(point.bent) < len(view.fit.robot.parts):
        return False  # it drives into a bend or out of one
    way = view.course.leads[point.bent[0]] if point.bent else 0
    if point.passed + way != number:
        return False
    first_m = view.pipe.start_of(view.fit.stretched_m)
    ahead = (joint.arc_m - first_m) * point.way > 0
    return ahead or number != 0


def _sinks_m(view: PipeView, joint: RouteJoint, rolls: PartRolls) -> list[float]:
    """Return for each part how far its wheels sink into the mouth as they pass it, m."""
    run_m = view.fit.route.diameter_at(joint.arc_m) / 2
    branch_m, wheel_m = view.fit.mouth_m(joint) / 2, view.fit.profile.body.wheel_radius
    found = []
    for part in range(len(view.fit.robot.parts)):
        roll_rad = view.start_roll_rad + view.roll_joint.roll(rolls, part) * QUARTER_RAD
        aside_rad = remainder(joint.towards_rad - roll_rad, pi)  # its wheels touch both sides
        found.append(sink_m(run_m, branch_m, wheel_m, aside_rad))
    return found


def _finding(
    view: PipeView, joint: RouteJoint, point: CoursePoint, sinks_m: list[float], number: int
) -> Finding:
    name = view.fit.robot.parts[sinks_m.index(max(sinks_m))]
    diameter_m = view.fit.mouth_m(joint)
    message = (
        f"'{name}' passes the tee '{joint.junction}' in its plane: its wheels sink into the mouth"
        f" of {mm(diameter_m)}, and it loses its hold or stays there"
    )
    beyond = any(each.joint >= number for each in view.course.bends if point.way > 0)
    beyond |= any(each.joint < number for each in view.course.bends if point.way < 0)
    if not beyond:
        message = f"if the robot drives so far: {message}"
    severity = Severity.ERROR if beyond else Severity.WARNING
    related = [(view.place_in_pipe(view.path_of(joint)), "past this")]
    return view.finding_at(point, "tee.in_plane", message, severity=severity, related=related)
