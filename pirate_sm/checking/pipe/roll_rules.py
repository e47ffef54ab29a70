"""A rule about turns of the roll joint.

A part that is relaxed by duty 0 keeps the worms of its joints wound and presses on; it turns by
some 10 deg. A part that holds keeps the module of the roll joint oblique, and what turns about
that runs into the wall after 6 to 26 deg (docs/decisions/0026). A command avoids both by a
posture that it takes first.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import asin, degrees

from pirate_sm.checking.findings import Finding, at
from pirate_sm.checking.pipe.pipe_view import PipeView, story_of
from pirate_sm.checking.pipe.usual_course import Bends, Change

_MOST_OBLIQUE_RAD = asin(0.1)
"""Smallest obliqueness of the module that is reported [decided]: 6 deg, against the 47 deg at which
a part runs into the wall in a pipe of 120 mm."""


def turns_what_is_slack(view: PipeView) -> Iterator[Finding]:
    """Report commands that turn a part that presses on the walls, or about an oblique module."""
    reported = set[str]()
    for change in view.course.turns:
        turning = view.roll_joint.turning(change.after.configuration)
        command = view.fit.robot.commands[change.command]
        if not turning or command.posture(change.after.configuration) is not None:
            continue  # the posture slackens it, or refuses
        found = _wound(view, change, turning) or _oblique(view, change, turning)
        if found is not None and change.after.place not in reported:
            reported.add(change.after.place)
            yield found


def _wound(view: PipeView, change: Change, turning: frozenset[int]) -> Finding | None:
    wound = sorted(turning & change.after.wound)
    if not wound:
        return None
    message = (
        f"{_command(view, change)} turns {_names(view, wound)}, which still presses on the walls:"
        " it clamped, and its worms stay wound"
    )
    return _at_step(view, change, "align.wound", message)


def _oblique(view: PipeView, change: Change, turning: frozenset[int]) -> Finding | None:
    bend = Bends(view.fit.force).of(change.before.configuration)
    if bend is not None and bend.part in turning:
        message = f"{_command(view, change)} turns {_names(view, [bend.part])}, which is bent"
        return _at_step(view, change, "align.oblique", message)
    diameter_m = view.first_piece.diameter_m
    length_m = view.fit.profile.body.links[view.roll_joint.link].length
    oblique_rad = asin(min(view.fit.height_m(diameter_m) / length_m, 1.0))
    if oblique_rad < _MOST_OBLIQUE_RAD:
        return None
    held = sorted(view.fit.robot.held[change.after.configuration])
    message = (
        f"{_command(view, change)} turns {_names(view, sorted(turning))} about a module that"
        f" {_names(view, held)} holds obliquely, {degrees(oblique_rad):.2g} deg off the pipe's axis"
        f" in {diameter_m * 1000:.4g} mm"
    )
    return _at_step(view, change, "align.oblique", message)


def _command(view: PipeView, change: Change) -> str:
    return view.fit.robot.commands[change.command].name


def _names(view: PipeView, parts: list[int]) -> str:
    return " and ".join(f"'{view.fit.robot.parts[part]}'" for part in parts)


def _at_step(view: PipeView, change: Change, code: str, message: str) -> Finding:
    place = view.place_of_step(change.after.place)
    found = at(view.document(place.file), place, code, message)
    return story_of(found, view, change.after)
