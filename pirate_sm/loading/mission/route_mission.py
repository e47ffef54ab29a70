"""Compose a mission along a route, of the missions that pass its joints."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees, isnan, pi
from typing import NamedTuple

from pirate_sm.errors import UsageError
from pirate_sm.geometry.joints import Joint
from pirate_sm.model.pipe import Pipe
from pirate_sm.model.profile import Profile
from pirate_sm.model.travel import PassedBy, Travel

_SPARE_M = 0.1
"""The robot stops this far before the end of the route [decided]."""


class Course(NamedTuple):
    """What a mission along a route is made of.

    Attributes:
        polarity: Which sides the wheels touch.
        calls: For each joint that missions pass, the joint and these missions.
        last_m: How far the robot drives behind the last of these, to the end of the route.
    """

    polarity: str
    calls: tuple[tuple[Joint, tuple[str, ...]], ...]
    last_m: float


def course_along(pipe: Pipe, profile: Profile) -> Course:
    """Return what passes the joints of a pipe's first route, in order.

    Raises:
        UsageError: The robot does not know how to travel, or how to pass one of the joints.
    """
    travel = profile.travel
    if travel is None:
        raise UsageError(
            f"{profile.robot} does not say how it travels: `travel` in its profile names the "
            "missions that pass joints"
        )
    route, length_m = pipe.route(), sum(link.length for link in profile.body.links)
    start_m = pipe.start_of(length_m)
    ahead = [each for each in route.joints if each.arc_m + each.behind_m > start_m]
    rolled_rad = (pipe.start.roll if pipe.start else 0.0) - pipe.roll
    found = _normal_or_mirrored(ahead, travel, rolled_rad, profile.robot)
    polarity, passed = found
    calls = tuple((joint, by.calls) for joint, by in passed if by.calls)
    from_m = calls[-1][0].arc_m + length_m if calls else start_m
    last_m = route.length_m - _SPARE_M - from_m
    if last_m <= 0:
        what = "behind the last joint" if calls else "before its end"
        raise UsageError(f"the robot has no room {what}: the route ends too early")
    return Course(polarity, calls, last_m)


def _normal_or_mirrored(
    joints: Sequence[Joint], travel: Travel, rolled_rad: float, robot: str
) -> tuple[str, list[tuple[Joint, PassedBy]]]:
    """Return the polarity in which all joints are passed, and what passes each."""
    failed: Joint | None = None
    for polarity, turned_rad in (("normal", 0.0), ("mirrored", pi)):
        passed: list[tuple[Joint, PassedBy]] = []
        roll_rad = rolled_rad + turned_rad
        for joint in joints:
            by = _by(joint, travel, roll_rad)
            if by is None:
                failed = failed or joint
                break
            roll_rad += by.rolls
            passed.append((joint, by))
        else:
            return polarity, passed
    assert failed is not None
    where = f"the {failed.kind} at {failed.arc_m * 1e3:.0f} mm"
    towards = "" if isnan(failed.towards_rad) else f" towards {degrees(failed.towards_rad):.0f} deg"
    raise UsageError(
        f"no mission of {robot} passes {where}{towards} in one polarity with all others: "
        "`travel` in its profile lists what it passes"
    )


def _by(joint: Joint, travel: Travel, rolled_rad: float) -> PassedBy | None:
    towards_rad = joint.towards_rad - rolled_rad
    turns = bool(joint.turn_rad)
    return next(
        (each for each in travel.passages if each.passes(joint.kind, turns, towards_rad)), None
    )


def mission_along(
    name: str, route: str, pipe_name: str, robot_name: str, course: Course, travel: Travel
) -> str:
    """Return the text of a mission along a route.

    Args:
        name: Name of the mission.
        route: Name of the route; empty for the only one of a pipe.
        pipe_name: Name or path of the pipe, as the mission shall name it.
        robot_name: Name or path of the robot.
        course: What passes the joints.
        travel: How the robot travels.
    """
    states = ", ".join(f"{region}: {state}" for region, state in travel.starts_in.items())
    names = [f"joint_{number}" for number in range(1, len(course.calls) + 1)]
    phases: list[str] = []
    for phase, (joint, calls), after in zip(names, course.calls, _following(names), strict=True):
        at = f"{joint.kind} {joint.junction}".strip()
        steps = ", ".join(f"{{call: {call}}}" for call in calls)
        phases += [
            f"  {phase}:",
            f"    description: The {at} at {joint.arc_m * 1e3:.0f} mm of the route",
            f"    do: [{steps}]",
            f"    go: {after}",
        ]
    lines = [
        "# Along a route, made of the missions that pass its joints, by pirate new mission.",
        "format: 1",
        f"mission: {name}",
        f"description: Along the route {route or 'of the pipe'} to its end",
        f"robot: {robot_name}",
        f"pipe: {pipe_name}",
        *([f"route: {route}"] if route else []),
        *(["polarity: mirrored"] if course.polarity == "mirrored" else []),
        "parameters:",
        f"  last: {{type: length, default: {course.last_m * 1e3:.0f} mm, min: 10 mm, max: 100 m,"
        " description: How far to drive behind the last joint}",
        *([f"starts_in: {{{states}}}"] if states else []),
        "time_limit: 2 h",
        "on_failure: stopped",
        f"start: {names[0] if names else 'arrive'}",
        "phases:",
        *phases,
        "  arrive:",
        f"    do: [{{call: {travel.last}, with: {{way: $last}}}}]",
        "    go: arrived",
        "ends:",
        "  arrived: {succeed: At the end of the route}",
        '  stopped: {fail: "Stopped on the way: {cause}"}',
    ]
    return "\n".join(lines) + "\n"


def _following(phases: Sequence[str]) -> Sequence[str]:
    """Return the phase after each."""
    return (*phases[1:], "arrive") if phases else ()
