"""A rule about bends in round pipes: a part bends in the plane of its bend, towards its inner wall.

A part is rolled about the axis by what the robot is rolled as it starts, and by what commands have
turned it since. Both stay as they are from piece to piece, in the frame that is carried along the
route.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees, pi, remainder
from typing import NamedTuple

from pirate_sm.checking.findings import Finding
from pirate_sm.checking.pipe.course_points import Bending
from pirate_sm.checking.pipe.pipe_view import PipeView
from pirate_sm.checking.pipe.roll_joint import QUARTER_RAD
from pirate_sm.core.geometry import RouteJoint

MOST_ROLL_RAD = pi / 18
"""Smallest roll of a part relative to a bend that it cannot pass (docs/simulator.md)."""


class _Missed(NamedTuple):
    """A part that is bent out of the plane of its bend, or away from its inner wall.

    Attributes:
        bending: The part.
        joint: The bend.
        off_rad: The roll from where it bends to where the pipe turns, within half a turn.
    """

    bending: Bending
    joint: RouteJoint
    off_rad: float

    @property
    def passage(self) -> tuple[int, int]:
        """Return into which bend it bends, and which part leads."""
        return self.bending.joint, self.bending.point.bent[0]

    @property
    def quarters(self) -> int:
        """Return how many quarter turns are missing, within ±2."""
        return round(self.off_rad / QUARTER_RAD)

    @property
    def askew(self) -> bool:
        """Return whether quarter turns alone do not bring the part into the plane."""
        return abs(self.off_rad - self.quarters * QUARTER_RAD) >= MOST_ROLL_RAD


def bends_in_the_plane(view: PipeView) -> Iterator[Finding]:
    """Report for each bend the first part that is never bent in its plane, to its inner wall."""
    if view.pipe.section != "round":
        return
    reported = set[tuple[int, int]]()
    for each in _missed(view):
        if each.passage in reported:
            continue
        reported.add(each.passage)
        away = abs(each.quarters) == 2 and not each.askew
        yield _away(view, each) if away else _aside(view, each)


def _missed(view: PipeView) -> Iterator[_Missed]:
    """Yield the parts that miss a bend each time that they bend into it."""
    looked = [found for each in view.course.bends if (found := _looked_at(view, each)) is not None]
    right = {
        (each.passage, each.bending.bend.part)
        for each in looked
        if abs(each.off_rad) < MOST_ROLL_RAD
    }
    for each in looked:
        if (each.passage, each.bending.bend.part) not in right:
            yield each


def _looked_at(view: PipeView, bending: Bending) -> _Missed | None:
    """Return how far a part bends off; None if it is unknown."""
    joint = view.bend(bending.joint)
    if joint is None or bending.roll is None:
        return None
    roll_rad = view.start_roll_rad + bending.roll * QUARTER_RAD
    towards_rad = roll_rad if bending.bend.side > 0 else roll_rad + pi
    return _Missed(bending, joint, remainder(joint.towards_rad - towards_rad, 2 * pi))


def _away(view: PipeView, missed: _Missed) -> Finding:
    """Return the finding about a part that bends in the plane, away from the inner wall."""
    polarity = view.fit.robot.polarity
    other = "normal" if polarity == "mirrored" else "mirrored"
    message = (
        f"in {polarity} polarity, rolled as it is, '{_name(view, missed)}' is bent away from the"
        f" inner wall of the {_described(missed.joint)}"
    )
    turned = missed.bending.roll or 0.0
    how = "to the other side than it is turned" if abs(turned) == 1 else "by two quarter turns"
    fix = f"write `polarity: {other}`, or turn every part {how}, before this"
    return _at_step(view, missed, "geometry.polarity", message, fix)


def _aside(view: PipeView, missed: _Missed) -> Finding:
    """Return the finding about a part that bends out of the plane of its bend."""
    off_deg = degrees(missed.off_rad)
    message = (
        f"'{_name(view, missed)}' is bent {abs(off_deg):.4g} deg out of the plane of the"
        f" {_described(missed.joint)}"
    )
    if missed.askew:
        fix = (
            "no quarter turn brings it there: let the robot start with another `roll`, or lay the"
            " bend otherwise"
        )
        return _at_step(view, missed, "geometry.out_of_plane", message, fix)
    many = "one quarter turn is" if abs(missed.quarters) == 1 else "two quarter turns are"
    message += f": {many} missing"
    return _at_step(view, missed, "geometry.out_of_plane", message, _how_to_turn(view, missed))


def _how_to_turn(view: PipeView, missed: _Missed) -> str:
    """Return which command turns a part into the plane of its bend."""
    joint, rolls, part = view.roll_joint, missed.bending.point.rolls, missed.bending.bend.part
    assert rolls is not None  # _looked_at has checked it
    ahead = joint.is_ahead(part)
    turned = rolls.turned(missed.quarters if ahead else -missed.quarters, ahead=ahead)
    name = view.fit.robot.parts[part]
    commands = joint.commands_to(turned.joint)
    if joint.link < 0:
        return "the robot has no joint that rolls its parts: let it start with another `roll`"
    if not commands:
        return f"turn the other parts first, then '{name}': the roll joint does not turn so far"
    words = "' or '".join(commands)
    return f"'{words}' turns '{name}' there, before it bends, while the other part holds"


def _at_step(view: PipeView, missed: _Missed, code: str, message: str, fix: str) -> Finding:
    """Return a finding at the step that bends, or at the call of a mission that bends."""
    point = missed.bending.point
    step, place = view.place_of_step(point.place), view.own_place(point.at - 1, point.place)
    related = [(view.place_in_pipe(view.path_of(missed.joint)), "into this")]
    related[:0] = [(step, "this bends it")] if place != step and step.line else []
    return view.finding_at(point, code, message, fix=fix, related=related)


def _name(view: PipeView, missed: _Missed) -> str:
    return view.fit.robot.parts[missed.bending.bend.part]


def _described(joint: RouteJoint) -> str:
    turns = f"of {degrees(joint.turn_rad):.4g} deg at {joint.arc_m * 1000:.4g} mm"
    return f"tee '{joint.junction}'" if joint.junction else f"{joint.kind} {turns}"
