"""Rules about space: where a robot starts, and the straights in which it clamps."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees, pi, remainder

from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.pipe.bend_rules import MOST_ROLL_RAD
from pirate_sm.checking.pipe.pipe_view import PipeView, mm
from pirate_sm.checking.pipe.robot_in_pipe import Fit
from pirate_sm.core.documents import Problems
from pirate_sm.core.geometry import RouteJoint


def starts_clear_of_bends(view: PipeView) -> Iterator[Finding]:
    """Report a robot that does not start in a plain piece of the pipe, clear of every joint."""
    first = view.course.situations[0]
    if first.bent:
        return  # it starts in the bend
    if message := _not_clear(view.fit, clamped=bool(view.fit.robot.held[first.configuration])):
        yield view.finding_in_pipe(view.start_path, "geometry.too_close", message)


def check_alone(fit: Fit, problems: Problems) -> None:
    """Report a start and a roll of a pipe that no mission of this robot can do anything with.

    It may begin bent, in a bend, or never come to one: these are warnings.
    """
    message = _not_clear(fit, clamped=True) if fit.pipe.start is not None else ""
    if message:
        code, path = "geometry.too_close", ("start", "at")
        problems.add(code, path, message, severity=Severity.WARNING)
    turned = abs(remainder(fit.pipe.roll, pi)) >= MOST_ROLL_RAD
    if fit.pipe.section == "bars" and turned and any(each.turn_rad for each in fit.route.joints):
        message = f"the bend lies {degrees(fit.pipe.roll):.4g} deg out of the robot's plane"
        problems.add("geometry.out_of_plane", ("roll",), message, severity=Severity.WARNING)


def _not_clear(fit: Fit, *, clamped: bool) -> str:
    """Return why a robot that is not bent cannot begin where the pipe says; empty if it can."""
    first = fit.pipe.start_of(fit.stretched_m)
    length = fit.clamped_m(fit.route.diameter_at(first)) if clamped else fit.stretched_m
    last = first - length
    how = f"{fit.profile.robot}, {mm(length)} long there, with its first wheel at {mm(first)}"
    if last < 0 or first > fit.route.length_m:
        return f"{how} juts out of the {'beginning' if last < 0 else 'end'}"
    for joint in fit.route.joints:
        begins, ends = fit.walls_end(joint)
        if last < ends and first > begins:
            return f"{how} is in {_described(joint, begins, ends)}"
    return ""


def _described(joint: RouteJoint, begins_m: float, ends_m: float) -> str:
    """Return a joint with its place."""
    place = mm(joint.arc_m)
    match joint.kind:
        case "mitre":
            before = mm(joint.before_m)
            return f"the bend at {place}, which begins {before} before the crossing of the axes"
        case "elbow":
            return f"the elbow from {mm(begins_m)} to {mm(ends_m)}"
        case "reducer":
            return f"the reducer that begins at {place}"
        case "tee":
            return f"the tee '{joint.junction}' at {place}, whose opening begins at {mm(begins_m)}"


def holds_after_the_bend(view: PipeView) -> Iterator[Finding]:
    """Report a straight after a bend that is too short for the clamped robot."""
    everything = frozenset(range(len(view.fit.robot.parts)))
    round_it = [
        each
        for each in view.course.situations
        if view.fit.robot.held[each.configuration] == everything and everything <= set(each.bent)
    ]
    leads = view.course.leads
    stretches = [each.passed + way for each in round_it if (way := leads[each.bent[0]])]
    for number in dict.fromkeys(stretches):
        yield from _too_short(view, number)


def _too_short(view: PipeView, number: int) -> Iterator[Finding]:
    """Report a stretch between two bends in which the clamped robot has no room.

    A tee that the route passes straight on is an opening in its wall. A reducer is none: the robot
    is inside it as it drives through.
    """
    arcs, pieces = view.arcs(number), view.stretch(number)
    if arcs is None or not pieces:
        return
    free_m, rooms = arcs[0], []
    for joint in view.fit.route.joints:
        if arcs[0] <= joint.arc_m <= arcs[1] and joint.kind != "reducer":
            begins, ends = view.fit.walls_end(joint)
            rooms.append(begins - free_m)
            free_m = ends
    room_m = max((*rooms, arcs[1] - free_m))
    need_m = min(view.fit.clamped_m(piece.diameter_m) for piece in pieces)
    if room_m < need_m:
        message = (
            f"there are {mm(room_m)} of straight walls here, and the clamped robot, which the"
            f" mission brings here, is {mm(need_m)} long"
        )
        path = (*view.pipe.path_of(pieces[0]), "straight")
        yield view.finding_in_pipe(path, "geometry.too_short", message)
