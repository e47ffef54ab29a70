"""Rules about the bends and tees of a route: the robot bends where they are, and passes them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from math import cos, degrees, pi, remainder, sin, sqrt
from typing import NamedTuple

from pirate_sm.checking.findings import Finding, Severity, at
from pirate_sm.checking.pipe.pipe_view import PipeView, mm
from pirate_sm.checking.pipe.robot_in_pipe import QUARTER_RAD, PartRolls
from pirate_sm.checking.pipe.usual_course import Bending, Bends, Change, CoursePoint
from pirate_sm.core.documents import Place
from pirate_sm.core.geometry import RouteJoint
from pirate_sm.core.models import PassedBy, Travel
from pirate_sm.core.program import Do

# --- planes of bends -----------------------------------------------------------------------------
# A part is rolled about the axis by what the robot is rolled as it starts, and by what commands
# have turned it since. Both stay as they are from piece to piece, in the frame that is carried
# along the route.


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
        f" inner wall of the {_described_bend(missed.joint)}"
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
        f" {_described_bend(missed.joint)}"
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


def _described_bend(joint: RouteJoint) -> str:
    turns = f"of {degrees(joint.turn_rad):.4g} deg at {joint.arc_m * 1000:.4g} mm"
    return f"tee '{joint.junction}'" if joint.junction else f"{joint.kind} {turns}"


# --- sides of bends ------------------------------------------------------------------------------


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


# --- bends and turns on the route ----------------------------------------------------------------


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
            wanted = " or ".join(dict.fromkeys(map(_described_passage, own)))
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


def _described_passage(passage: PassedBy) -> str:
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


# --- mouths of tees ------------------------------------------------------------------------------


MOST_SINK_M = 0.01
"""How far a wheel may sink into a mouth. Simulated robots pass a tee in 120 mm where it is 7.5 mm,
and lose their hold or stay there where it is 10.5 mm (docs/decisions/0070)."""


def keeps_off_the_mouths(view: PipeView) -> Iterator[Finding]:
    """Report tees that are passed straight on while a part's wheels are over the mouth."""
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


# --- the mouth of a tee's branch --------------------------------------------------------------


_POINTS = 96
_STEP_M = 0.0005


def sink_m(
    run_radius_m: float, branch_radius_m: float, wheel_radius_m: float, aside_rad: float
) -> float:
    """Return how far a wheel leaves the wall of a run where its line passes a mouth, m.

    A wheel is a sphere that is pushed outwards, away from the run's axis, where the axis of the
    branch crosses it. It stops at the edge of the mouth, X + b cos α t + b sin α (t × b) + b √(R² −
    b² sin² α) for a branch of radius b, a run of radius R and the run's direction t, or at the wall
    of the branch. It sinks by its diameter at most.

    Args:
        run_radius_m: Inner radius of the run.
        branch_radius_m: Inner radius of the branch.
        wheel_radius_m: Radius of the wheel.
        aside_rad: Angle about the run's axis from the middle of the mouth to the wheel.
    """
    aside, out = sin(aside_rad), cos(aside_rad)
    if run_radius_m * abs(aside) >= branch_radius_m or out <= 0.0:
        return 0.0  # its line does not cross the mouth
    edge = [
        (branch_radius_m * cos(angle), branch_radius_m * sin(angle))
        for angle in (2 * pi * number / _POINTS for number in range(_POINTS))
    ]
    ring = [(x, y, sqrt(run_radius_m**2 - y**2)) for x, y in edge]
    beyond_m = sqrt(run_radius_m**2 - branch_radius_m**2)
    least_m = (wheel_radius_m - _STEP_M / 100) ** 2

    def free(away_m: float) -> bool:
        across, high = away_m * aside, away_m * out
        if abs(across) > branch_radius_m - wheel_radius_m and high > beyond_m:
            return False
        return all(x**2 + (y - across) ** 2 + (z - high) ** 2 >= least_m for x, y, z in ring)

    start_m, steps = run_radius_m - wheel_radius_m, 0
    while steps * _STEP_M < 2 * wheel_radius_m and free(start_m + (steps + 1) * _STEP_M):
        steps += 1
    return steps * _STEP_M
