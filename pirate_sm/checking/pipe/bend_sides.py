"""Rules about bends: parts bend towards the inner wall, in the plane of the bend."""

from __future__ import annotations

from collections.abc import Iterator
from math import copysign, degrees, pi, remainder

from pirate_sm.checking.actuation_in_force import InForce
from pirate_sm.checking.findings import Finding, at
from pirate_sm.checking.pipe.pipe_view import PipeView
from pirate_sm.checking.pipe.usual_course import Bends
from pirate_sm.engine.mission.program import Do
from pirate_sm.loading.problems import Place
from pirate_sm.model.pipe_segments import Mitre

MOST_ROLL_RAD = pi / 18
"""Smallest roll of a part relative to a bend that it cannot pass (docs/simulator.md)."""


def bends_to_the_inner_wall(view: PipeView) -> Iterator[Finding]:
    """Report parts that are not bent towards the inner wall, in the plane of the bend."""
    mitres = [
        (number, each.mitre)
        for number, each in enumerate(view.pipe.segments or ())
        if isinstance(each, Mitre)
    ]
    if not mitres:
        yield from _bent_in_vain(view)
    if not mitres or not view.course.bends or _turns(view):
        return
    if abs(remainder(view.pipe.roll, 2 * pi)) >= MOST_ROLL_RAD:
        message = (
            f"the bend lies {degrees(view.pipe.roll):.4g} deg out of the robot's plane, and the"
            " mission turns no part into it"
        )
        yield view.finding_in_pipe(("roll",), "geometry.out_of_plane", message)
        return
    inner = {int(copysign(1, mitre)) for _, mitre in mitres}
    wrong = [(bend, place) for bend, place in view.course.bends if bend.side not in inner]
    if wrong:
        yield _wrong_side(view, wrong[0][0].part, [place for _, place in wrong], mitres[0])


def _bent_in_vain(view: PipeView) -> Iterator[Finding]:
    """Report parts that are bent in a pipe without bends."""
    mission = view.loaded.documents[0]
    called: list[tuple[Place, str]] = []
    for where, parts in _bending(view).items():
        place = view.place_of_step(where)
        name = "' or '".join(view.fit.robot.parts[part] for part in sorted(parts))
        if place.line and place.file == mission.name:
            message = f"this bends '{name}', and the pipe has no bend"
            yield at(mission, place, "geometry.no_bend", message)
        elif place.line:
            called.append((place, f"this bends '{name}'"))
    if called:  # a called mission is valid itself: it names no pipe
        message = f"{called[0][0]} bends a part, and this pipe has no bend"
        place = mission.place_of(("pipe",))
        yield at(mission, place, "geometry.no_bend", message, related=called)


def _bending(view: PipeView) -> dict[str, frozenset[int]]:
    """Return the parts by the places of the steps that bend them, including handlers."""
    found = {where: frozenset({bend.part}) for bend, where in view.course.bends}
    bends = Bends(view.loaded.robot, view.loaded.loaded_robot.profile)
    for each in view.loaded.program.instructions:
        if isinstance(each, Do) and each.place not in found:
            parts = bends.always(each.command)
            if parts:
                found[each.place] = parts
    return found


def _wrong_side(view: PipeView, part: int, places: list[str], mitre: tuple[int, float]) -> Finding:
    polarity = view.fit.robot.polarity
    other = "normal" if polarity == "mirrored" else "mirrored"
    number, angle = mitre
    name = view.fit.robot.parts[part]
    message = (
        f"in {polarity} polarity '{name}' is bent away from the inner wall of the mitre of"
        f" {degrees(angle):.4g} deg"
    )
    related = [(place, "this bends it") for place in map(view.place_of_step, places) if place.line]
    document, prefix = view.pipe_document
    related.append((document.place_of((*prefix, "segments", number)), "into this"))
    key = "polarity" if view.loaded.mission.polarity is not None else "pipe"
    mission = view.loaded.documents[0]
    place, code = mission.place_of((key,)), "geometry.polarity"
    mend = f"write `polarity: {other}`, or take a pipe that turns to the other side"
    return at(mission, place, code, message, mend=mend, related=related)


def _turns(view: PipeView) -> bool:
    """Return whether the mission rolls a part, which makes the directions of its sides unknown."""
    robot = view.fit.robot
    rolls = {n for n, slot in enumerate(view.fit.profile.slots) if slot.roll is not None}
    force = InForce(view.fit.profile, robot)
    return any(
        write.slot in rolls and write.how == "set" and write.value != 0
        for here in {each.actuated for each in view.course.situations}
        for write in force.writes(here)
    )
