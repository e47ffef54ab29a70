"""Rules about a route: its bends are there, and what is called passes them and turns there."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from math import degrees, pi

from pirate_sm.checking.findings import Finding, at
from pirate_sm.checking.pipe.course_points import Bending, Change
from pirate_sm.checking.pipe.pipe_view import PipeView
from pirate_sm.checking.pipe.roll_joint import QUARTER_RAD
from pirate_sm.core.profile import PassedBy, Travel


def takes_bends_that_are_there(view: PipeView) -> Iterator[Finding]:
    """Report steps that always bend into a bend that is not there, or is not of their kind."""
    if not view.bends or view.course.situations[0].bent:
        return  # reported elsewhere; it begins in a bend, before or after the middle of the robot
    made: dict[tuple[int, int], list[Bending]] = defaultdict(list)
    for each in view.course.bends:
        made[each.point.at, each.bend.part].append(each)
    reported = set[tuple[object, str]]()
    for (number, _), bendings in made.items():
        for found in (_not_there(view, bendings), _not_passed(view, number - 1, bendings)):
            if found is not None:
                code, message, fix = found
                finding = view.finding_at(bendings[0].point, code, message, fix=fix)
                if (finding.place, code) not in reported:
                    reported.add((finding.place, code))
                    yield finding


_Said = tuple[str, str, str]


def _not_there(view: PipeView, bendings: list[Bending]) -> _Said | None:
    """Return the finding about a step whose bends are all beyond the last one of the route."""
    leads = view.course.leads
    if any(
        view.bend(each.joint) is not None or each.point.way != leads[each.bend.part]
        for each in bendings
    ):
        return None
    back = bendings[0].joint < 0
    way, name = "behind" if back else "ahead of", view.fit.robot.parts[bendings[0].bend.part]
    message = f"this bends '{name}' into another bend {way} the robot, but the route has none"
    fix = "leave it out, or take a pipe or a route with one more bend"
    return "geometry.no_bend", message, fix


def _not_passed(view: PipeView, number: int, bendings: list[Bending]) -> _Said | None:
    """Return the finding about a called mission that is for other joints than this bend."""
    travel, bend = view.fit.profile.travel, view.bend(bendings[0].joint)
    if travel is None or bend is None:
        return None
    joints = [view.bend(each.joint) for each in bendings]
    for name in (each.call for each in view.calls(number)):
        own = [each for each in travel.passages if name in each.calls]
        if own and not any(
            joint is None or each.suits(joint.kind, joint.turn_rad)
            for joint in joints
            for each in own
        ):
            wanted = " or ".join(dict.fromkeys(map(_described, own)))
            here = _a(bend.kind)
            if any(bend.kind in each.joints for each in own):
                here += f" that turns by {degrees(abs(bend.turn_rad)):.4g} deg"
            message = f"'{name}' is for {wanted}, and the next bend of the route is {here}"
            fits = [call for each in travel.passages if each.suits(bend.kind, bend.turn_rad)
                    for call in each.calls]  # fmt: skip
            return "route.passage", message, f"call '{fits[0]}'" if fits else ""
    return None


def _a(kind: str) -> str:
    return f"an {kind}" if kind == "elbow" else f"a {kind}"


def _described(passage: PassedBy) -> str:
    """Return which joints a passage is for."""
    joints = " or ".join(map(_a, sorted(passage.joints)))
    if passage.turns is False:
        return f"{joints} that is passed straight on"
    sharpest = passage.up_to
    return joints if sharpest is None else f"{joints} of at most {degrees(sharpest):.4g} deg"


def turns_where_it_can(view: PipeView) -> Iterator[Finding]:
    """Report calls that turn the robot where the profile's `travel` says that they fail."""
    travel, reported = view.fit.profile.travel, set[object]()
    if view.pipe.section != "round" or travel is None:
        return
    for change in view.course.turns:
        number = change.after.at - 1
        names = [each.call for each in view.calls(number)]
        name = next((each for each in names if any(t.call == each for t in travel.turns)), None)
        place = view.own_place(number, change.after.place)
        if name is None or place in reported or _can_turn(view, travel, name, change):
            continue
        reported.add(place)
        fits = [each.call for each in travel.turns if _can_turn(view, travel, each.call, change)]
        message = f"'{name}' does not turn the robot as it lies here, says `travel` of its profile"
        fix = f"here {' or '.join(fits)} turns it" if fits else ""
        yield at(view.document(place.file), place, "align.slope", message, fix=fix)


def _can_turn(view: PipeView, travel: Travel, name: str, change: Change) -> bool:
    """Return whether a mission may turn a robot somewhere where it may be then."""
    rolls = change.before.rolls
    if rolls is None or rolls.ahead != rolls.behind:
        return True  # unknown, or within the turn
    mirrored = view.fit.robot.polarity == "mirrored"
    roll_rad = view.start_roll_rad + rolls.ahead * QUARTER_RAD + pi * mirrored
    return any(
        travel.turns_at(turn, piece.frame, view.fit.route.up, roll_rad)
        for turn in travel.turns
        if turn.call == name
        for piece in view.stands_in(change.before)
    )
