"""Rules about bends: parts bend where there is a bend, and between bars to its inner wall."""

from __future__ import annotations

from collections.abc import Iterator
from math import cos, degrees, pi, remainder

from pirate_sm.checking.findings import Finding, at
from pirate_sm.checking.pipe.bend_planes import MOST_ROLL_RAD
from pirate_sm.checking.pipe.bends import Bends
from pirate_sm.checking.pipe.pipe_view import PipeView
from pirate_sm.core.documents import Place
from pirate_sm.core.geometry import RouteJoint
from pirate_sm.core.program import Do


def bends_to_the_inner_wall(view: PipeView) -> Iterator[Finding]:
    """Report parts that are bent without a bend, or between bars not towards the inner wall."""
    if not view.bends:
        yield from _bent_in_vain(view)
    elif view.pipe.section == "bars" and view.course.bends and not _turns(view):
        yield from _in_the_plane(view)


def _turns(view: PipeView) -> bool:
    """Return whether the mission rolls a part, which no bend between bars lets pass."""
    return any(view.roll_joint.aim(each.configuration) for each in view.course.situations)


def _in_the_plane(view: PipeView) -> Iterator[Finding]:
    """Report the same of a pipe between bars, in which all bends lie in one plane."""
    if abs(remainder(view.pipe.roll, 2 * pi)) >= MOST_ROLL_RAD:
        message = (
            f"the bend lies {degrees(view.pipe.roll):.4g} deg out of the robot's plane, and the"
            " mission turns no part into it"
        )
        yield view.finding_in_pipe(("roll",), "geometry.out_of_plane", message)
        return
    inner = {side_of(joint) for joint in view.bends}
    wrong = [each for each in view.course.bends if each.bend.side not in inner]
    if wrong:
        places = list(dict.fromkeys(each.point.place for each in wrong))
        yield _wrong_side(view, wrong[0].bend.part, places)


def side_of(joint: RouteJoint) -> int:
    """Return to which side a bend in the plane of the drawing turns: 1 is side A, -1 side B."""
    return 1 if cos(joint.towards_rad) > 0 else -1


def _bent_in_vain(view: PipeView) -> Iterator[Finding]:
    """Report parts that are bent in a pipe without bends, by handlers too."""
    bends, reported = Bends(view.fit.force), set[Place]()
    steps = [(b.point.at - 1, b.point.place, {b.bend.part}) for b in view.course.bends]
    for number, it in enumerate(view.loaded.program.instructions):
        if isinstance(it, Do) and (parts := bends.always(it.command)):
            steps.append((number, it.place, {*parts}))
    for number, text, bent in steps:
        step, place = view.place_of_step(text), view.own_place(number, text)
        if step.line and place not in reported:
            reported.add(place)
            name = "' or '".join(view.fit.robot.parts[part] for part in sorted(bent))
            message = f"this bends '{name}', and the pipe has no bend"
            related = [(step, "here")] if step != place else []
            document = view.document(place.file)
            yield at(document, place, "geometry.no_bend", message, related=related)


def _wrong_side(view: PipeView, part: int, places: list[str]) -> Finding:
    polarity = view.fit.robot.polarity
    other = "normal" if polarity == "mirrored" else "mirrored"
    joint = view.bends[0]
    angle = degrees(joint.turn_rad) * side_of(joint)
    name = view.fit.robot.parts[part]
    message = (
        f"in {polarity} polarity '{name}' is bent away from the inner wall of the mitre of"
        f" {angle:.4g} deg"
    )
    related = [(place, "this bends it") for place in map(view.place_of_step, places) if place.line]
    related.append((view.place_in_pipe(view.path_of(joint)), "into this"))
    key = "polarity" if view.loaded.mission.polarity is not None else "pipe"
    mission = view.loaded.documents[0]
    place, code = mission.place_of((key,)), "geometry.polarity"
    fix = f"write `polarity: {other}`, or take a pipe that turns to the other side"
    return at(mission, place, code, message, fix=fix, related=related)
