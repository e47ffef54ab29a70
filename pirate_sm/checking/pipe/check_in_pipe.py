"""Check a mission in its pipe: space, its bends and tees, how parts turn, its grip on a slope.

Only the course of the mission without failures is checked (`usual_course`). The loader has already
checked that the robot's parts reach the walls (`pipe.reach`). The rules about bends are in
`bend_rules`.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import asin, degrees, pi, remainder
from typing import NamedTuple

from pirate_sm.checking.actuation_in_force import under
from pirate_sm.checking.findings import Finding, Severity, at
from pirate_sm.checking.pipe.bend_rules import (
    MOST_ROLL_RAD,
    bends_in_the_plane,
    bends_to_the_inner_wall,
    keeps_off_the_mouths,
    takes_bends_that_are_there,
    turns_where_it_can,
)
from pirate_sm.checking.pipe.pipe_view import PipeView, mm, story_of
from pirate_sm.checking.pipe.robot_in_pipe import Fit
from pirate_sm.checking.pipe.usual_course import Bends, Change, CoursePoint, course_of
from pirate_sm.core.documents import Path, Problems
from pirate_sm.core.geometry import Piece, RouteJoint, Vector, dot
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.models import Pipe

# --- space: where a robot starts, and the straights in which it clamps ------------------------


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


# --- turns of the roll joint ------------------------------------------------------------------

# A part that is relaxed by duty 0 keeps the worms of its joints wound and presses on; it turns by
# some 10 deg. A part that holds keeps the module of the roll joint oblique, and what turns about
# that runs into the wall after 6 to 26 deg (docs/decisions/0026). A command avoids both by a
# posture that it takes first.


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


# --- grip: clamped parts hold the robot on a slope --------------------------------------------


class _Hold(NamedTuple):
    """How the clamped parts hold in one piece of the pipe, with gravity in one direction.

    Attributes:
        piece: The piece of the pipe.
        torques_nm: Of each held part's apex; ``press_n`` is the sum of their normal forces.
        least_n: What friction holds at the worst place; ``most_n`` at the best one, with the grip
            raised as far as it may be and the weight resting on the walls.
        pull_n: The weight along the pipe.
        turned: Whether the pipe has turned before.
    """

    piece: Piece
    torques_nm: tuple[float, ...]
    press_n: float
    least_n: float
    most_n: float
    pull_n: float
    turned: bool

    @property
    def share(self) -> float:
        """Return which share of the weight is held; 1 where none pulls."""
        return self.least_n / self.pull_n if self.pull_n > 0 else 1.0


def clamps_bear_the_weight(view: PipeView) -> Iterator[Finding]:
    """Report clamped parts whose friction does not bear the robot's weight."""
    worst: tuple[_Hold, CoursePoint] | None = None
    every, certain = True, False
    seen: set[tuple[object, ...]] = set()
    for situation in view.course.situations:
        key = situation.actuated, situation.driven, situation.bent[:1], situation.passed
        holds = list(_holds(view, situation)) if _held(view, situation) and key not in seen else []
        seen.add(key)
        every = every and all(hold.share < 1 for hold in holds)
        for hold in holds:
            if hold.share < 1 and (worst is None or hold.share < worst[0].share):
                worst, certain = (hold, situation), all(h.most_n < h.pull_n for h in holds)
    if worst is not None:
        yield _weak(view, *worst, everywhere=every, certain=certain)


def _holds(view: PipeView, situation: CoursePoint) -> Iterator[_Hold]:
    """Yield how the robot holds wherever it can be, and however the pipe is turned then."""
    ups = view.fit.ups(view.loaded.program.time_limit_s)
    for piece in view.stands_in(situation):
        for number, up in enumerate(ups):
            yield _hold(view, situation, piece, up, turned=number > 0)


def _hold(
    view: PipeView, situation: CoursePoint, piece: Piece, up: Vector, *, turned: bool
) -> _Hold:
    fit, parts, diameter_m = view.fit, sorted(_held(view, situation)), piece.diameter_m
    slope = abs(dot(up, piece.frame.ahead))
    torques = [fit.torques_nm(part, situation.actuated, diameter_m, slope) for part in parts]
    presses, most = (
        [fit.press_n(part, torque, diameter_m) for part, torque in zip(parts, each, strict=True)]
        for each in zip(*torques, strict=True)
    )
    frictions = fit.frictions(parts, _firsts(view, situation, piece), diameter_m)
    pull, rests = fit.pull_n(piece, up)
    return _Hold(
        piece,
        tuple(torque for torque, _ in torques),
        sum(presses),
        min(_sum(presses, each) for each in frictions),
        max(_sum(most, each) + max(each) * rests for each in frictions),
        pull,
        turned,
    )


def _sum(presses: list[float], frictions: list[float]) -> float:
    return sum(press * friction for press, friction in zip(presses, frictions, strict=True))


def _firsts(view: PipeView, situation: CoursePoint, piece: Piece) -> tuple[float, float]:
    """Return between which arc lengths the first wheel of the clamped robot may be in a piece.

    Until wheels are driven it is where the robot begins; a robot that clamps there grows shorter.
    """
    fit = view.fit
    clamped_m = fit.clamped_m(piece.diameter_m)
    if situation.driven or situation.bent or piece != view.first_piece:
        low, high = piece.clear_m
        return min(low + clamped_m, high), high
    first = view.pipe.start_of(fit.stretched_m)
    begins_clamped = bool(fit.robot.held[view.course.situations[0].configuration])
    return first - (0.0 if begins_clamped else fit.stretched_m - clamped_m), first


def _weak(
    view: PipeView, hold: _Hold, situation: CoursePoint, *, everywhere: bool, certain: bool
) -> Finding:
    robot = view.fit.robot
    torques = " and ".join(f"{torque:.3g} Nm" for torque in hold.torques_nm)
    names = " and ".join(f"'{robot.parts[part]}'" for part in sorted(_held(view, situation)))
    friction = hold.least_n / hold.press_n if hold.press_n else view.fit.friction
    patched = f"{friction:.3g}" != f"{view.fit.friction:.3g}"
    message = (
        f"{names}, clamped with {torques}{under(robot, situation.control)}, press the walls with"
        f" {hold.press_n:.3g} N: with a friction of {friction:.3g}"
        f"{', part of it on a patch,' if patched else ''} that holds {hold.least_n:.3g} N, and the"
        f" weight pulls {hold.pull_n:.3g} N along the pipe"
        f"{' once it has turned' if hold.turned else ''}"
    )
    # The weight on the walls adds friction: if even that is too little, it is certain.
    severity = Severity.ERROR if certain else Severity.WARNING
    place = view.place_of_step(situation.place)
    if everywhere or not place.line:
        mission = view.loaded.documents[0]
        inline: Path = ("pipe", "tilt") if isinstance(view.loaded.mission.pipe, Pipe) else ()
        place = mission.place_of(inline or ("pipe",))
    document = view.document(place.file)
    spatial = view.pipe.section == "round"
    related = [(view.place_in_pipe(view.pipe.path_of(hold.piece)), "in this")] if spatial else []
    return at(document, place, "geometry.clamp_torque", message, severity=severity, related=related)


def _held(view: PipeView, situation: CoursePoint) -> frozenset[int]:
    return view.fit.robot.held[situation.configuration]


# --- the check --------------------------------------------------------------------------------


RULES = (
    starts_clear_of_bends,
    bends_to_the_inner_wall,
    bends_in_the_plane,
    keeps_off_the_mouths,
    holds_after_the_bend,
    turns_what_is_slack,
    clamps_bear_the_weight,
    takes_bends_that_are_there,
    turns_where_it_can,
)
"""All rules about missions in pipes; each yields the findings of a `PipeView`."""


def view_in_pipe(loaded: LoadedMission) -> PipeView | None:
    """Return a mission as seen in its pipe; None without a pipe, or if its course is too large."""
    if loaded.pipe is None:
        return None
    profile = loaded.loaded_robot.profile
    fit = Fit(profile, loaded.robot, loaded.pipe)
    bends = sum(1 for joint in fit.route.joints if joint.turn_rad)
    course = course_of(fit.force, loaded.program, bends)
    return PipeView(loaded, loaded.pipe, course, fit) if course is not None else None


def pipe_findings(view: PipeView) -> list[Finding]:
    """Return the findings about a mission in its pipe."""
    return [finding for rule in RULES for finding in rule(view)]
