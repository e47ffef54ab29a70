"""Missions that are in no file: along a route, and for driving the robot by hand.

A mission along a route is composed of the missions that pass the joints of the pipe.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from math import degrees, inf, isnan, pi, remainder
from pathlib import Path
from typing import NamedTuple

from pirate_sm.core._engine.mission.program import Enter, HandlerSpec, Program, Wait
from pirate_sm.core._geometry.route import Route, RouteJoint
from pirate_sm.core._loading.mission.loader import LoadedMission
from pirate_sm.core._loading.pipe import check_fit, load_pipe
from pirate_sm.core._loading.problems import Problems
from pirate_sm.core._loading.robot.loader import LoadedRobot
from pirate_sm.core._model.mission import End, Mission, Phase
from pirate_sm.core._model.pipe import Pipe
from pirate_sm.core._model.pipe_runs import KeyPath
from pirate_sm.core._model.robot.profile import PassedBy, Profile, Travel, Turn
from pirate_sm.core.errors import UsageError
from pirate_sm.core.spelling import meant

_SPARE_M = 0.1
"""The robot stops this far before the end of the route, and leaves so much room to each side of the
place where it turns: a quarter turn shifts it by up to 60 mm [measured in 3-D]; the rest is for
odometry and for the word of the next joint [decided]."""

_MOST_TURNS = 2
"""Half a turn; three quarters to one side are one to the other."""


class UndrivableError(UsageError):
    """Raised where a robot cannot pass a joint of a route.

    Attributes:
        path: Path of the joint in the pipe's file.
        needed: What would be needed.
    """

    def __init__(self, message: str, needed: str, path: KeyPath) -> None:
        self.message, self.needed, self.path = message, needed, path
        super().__init__(f"{message}: {needed}")


class RouteStep(NamedTuple):
    """A call of a mission.

    Attributes:
        call: The mission.
        way_m: How far it shall drive; None for one that does not drive by a distance.
    """

    call: str
    way_m: float | None = None


class RouteCourse(NamedTuple):
    """What a mission along a route is made of.

    Attributes:
        polarity: Which sides the wheels touch.
        calls: For each joint before which the robot turns, or that missions pass, the joint and the
            calls.
        last_m: How far the robot drives behind the last of these, to the end of the route.
    """

    polarity: str
    calls: tuple[tuple[RouteJoint, tuple[RouteStep, ...]], ...]
    last_m: float


class _Reached(NamedTuple):
    """How a robot can come behind some of the joints.

    Attributes:
        roll_rad: Its roll against the frame of the route; of side B in mirrored polarity.
        first_m: Where its first wheel is, at the farthest.
        clear_m: Where its first wheel is to be before it may turn, clear of the last joint.
        turns: How often it has turned.
        calls: What it has done.
    """

    roll_rad: float
    first_m: float
    clear_m: float
    turns: int = 0
    calls: tuple[tuple[RouteJoint, tuple[RouteStep, ...]], ...] = ()


class _Composer:
    """Composes missions along one route."""

    def __init__(self, pipe: Pipe, profile: Profile, travel: Travel) -> None:
        self.pipe, self.robot, self.travel = pipe, profile.robot, travel
        self.route: Route = pipe.route()
        self.length_m = sum(link.length for link in profile.body.links)
        self.start_m = pipe.start_of(self.length_m)
        joints = self.route.joints
        self.joints = [each for each in joints if each.arc_m + each.behind_m > self.start_m]

    def reached(self, mirrored: bool) -> tuple[list[_Reached], int]:
        """Return the ways behind the joints that can be passed, and how many these are."""
        roll_rad = (self.pipe.start.roll if self.pipe.start else 0.0) - self.pipe.roll
        found = [_Reached(roll_rad + pi * mirrored, self.start_m, self.start_m)]
        for number, joint in enumerate(self.joints):
            best: dict[int, _Reached] = {}
            for now in found:
                for after in self._past(now, joint):
                    key = round(degrees(remainder(after.roll_rad, 2 * pi))) % 360
                    if key not in best or after.turns < best[key].turns:
                        best[key] = after
            if not best:
                return found, number
            found = list(best.values())
        return found, len(self.joints)

    def _past(self, now: _Reached, joint: RouteJoint) -> Iterator[_Reached]:
        """Yield how the robot comes behind a joint."""
        for count in range(_MOST_TURNS + 1):
            for turns in product(self.travel.turns, repeat=count):
                turned_rad = sum(turn.rolls for turn in turns)
                by = self._by(joint, now.roll_rad + turned_rad)
                steps = None if by is None else self._turned(now, joint, turns)
                if by is not None and steps is not None:
                    yield self._after(now, joint, steps, turned_rad, by, count)

    def _by(self, joint: RouteJoint, roll_rad: float) -> PassedBy | None:
        """Return what passes a joint in a robot with this roll."""
        turn_rad, towards_rad = joint.turn_rad, joint.towards_rad - roll_rad
        passages = self.travel.passages
        return next(
            (each for each in passages if each.passes(joint.kind, turn_rad, towards_rad)), None
        )

    def _turned(
        self, now: _Reached, joint: RouteJoint, turns: Sequence[Turn]
    ) -> tuple[RouteStep, ...] | None:
        """Return the steps that turn the robot before a joint; None if they cannot."""
        if not turns:
            return ()
        if self.route.section != "round" or self.room_m(now, joint) < _SPARE_M * len(turns):
            return None
        roll_rad, at_m = now.roll_rad, max(now.first_m, now.clear_m)
        if len(turns) > 1 and self.travel.is_upright(self.route.frame_at(at_m), self.route.up):
            return None  # it slides back into the bend in 5 of 20 runs [measured in 3-D]
        for turn in turns:
            if not self._turns(turn, roll_rad, at_m):
                return None
            roll_rad += turn.rolls
        ahead_m = now.clear_m - now.first_m
        drive = (RouteStep(self.travel.last, ahead_m),) if ahead_m > 0 else ()
        return (*drive, *(RouteStep(turn.call) for turn in turns))

    def room_m(self, now: _Reached, joint: RouteJoint) -> float:
        """Return how far a joint begins ahead of a robot at the place where it may turn."""
        return joint.arc_m - joint.before_m - max(now.first_m, now.clear_m)

    def _turns(self, turn: Turn, roll_rad: float, at_m: float) -> bool:
        """Return whether a mission turns a robot with this roll at a place."""
        return self.travel.turns_at(turn, self.route.frame_at(at_m), self.route.up, roll_rad)

    def _after(
        self,
        now: _Reached,
        joint: RouteJoint,
        steps: tuple[RouteStep, ...],
        turned_rad: float,
        by: PassedBy,
        turns: int,
    ) -> _Reached:
        """Return where the robot is after it has turned and has passed a joint."""
        at_m = max(now.first_m, now.clear_m) if turns else now.first_m
        steps = (*steps, *map(RouteStep, by.calls))
        behind_m, opens = joint.arc_m + self.length_m, joint.kind == "tee"
        return _Reached(
            now.roll_rad + turned_rad,
            behind_m if by.calls else at_m,
            behind_m if by.calls and not opens else behind_m + joint.behind_m + _SPARE_M,
            now.turns + turns,
            (*now.calls, (joint, steps)) if steps else now.calls,
        )

    def refusal(self, before: Sequence[_Reached], number: int) -> UndrivableError:
        """Return why none of these ways leads past a joint."""
        joint = self.joints[number]
        where = f"{self.robot} does not get past the {joint.kind} at {joint.arc_m * 1e3:.0f} mm"
        path = self.pipe.path_of_joint(self.route, joint)
        if not isnan(joint.towards_rad):
            opens = "turns" if joint.turn_rad else "opens"
            where += f", which {opens} towards {_deg(joint.towards_rad)}"
        rolls = sorted({_deg(each.roll_rad) for each in before})
        turnable = self.route.section == "round" and self.travel.turns
        fits = [each for each in self.travel.passages if each.suits(joint.kind, joint.turn_rad)]
        if not fits:
            by = f" of {_deg(abs(joint.turn_rad))}" if joint.turn_rad else ""
            needed = f"`travel` in its profile has no passage for a {joint.kind}{by}"
            return UndrivableError(where, needed, path)
        counts = range(_MOST_TURNS + 1) if turnable else range(1)
        sums = {
            sum(t.rolls for t in each)
            for n in counts
            for each in product(self.travel.turns, repeat=n)
        }
        if not any(self._by(joint, each.roll_rad + by) for each in before for by in sums):
            sides = sorted({_deg(side) for each in fits for side in each.towards})
            how = "by turns of its own it comes to no other" if turnable else "it cannot turn there"
            needed = f"it passes one towards {' or '.join(sides)} against its plane, which is at"
            return UndrivableError(where, f"{needed} {' or '.join(rolls)} there; {how}", path)
        room_m = max(self.room_m(each, joint) for each in before)
        if room_m < _SPARE_M:
            needed = (
                f"it has to turn before: {(_SPARE_M - room_m) * 1e3:.0f} mm are missing for that"
                f" between the joint before and this one, and farther back {self._limit}"
            )
            return UndrivableError(where, needed, path)
        return UndrivableError(where, f"it has to turn before, but {self._limit}", path)

    @property
    def _limit(self) -> str:
        return (
            "no mission turns it so as it lies there; in a leg steeper than"
            f" {_deg(self.travel.upright)} it turns by one quarter at most"
        )


def _deg(angle_rad: float) -> str:
    return f"{round(degrees(remainder(angle_rad, 2 * pi))):d} deg"


def course_along(pipe: Pipe, profile: Profile) -> RouteCourse:
    """Return what passes the joints of a pipe's first route, in order, with the fewest turns.

    Raises:
        UsageError: The robot does not know how to travel, or has no room at the end.
        UndrivableError: The robot cannot pass one of the joints.
    """
    travel = profile.travel
    if travel is None:
        raise UsageError(
            f"{profile.robot} does not say how it travels: `travel` in its profile names the "
            "missions that pass joints"
        )
    composer = _Composer(pipe, profile, travel)
    found = {each: composer.reached(each == "mirrored") for each in ("normal", "mirrored")}
    ways = [
        (each.turns, polarity != "normal", polarity, each)
        for polarity, (reached, passed) in found.items()
        if passed == len(composer.joints)
        for each in reached
    ]
    if not ways:
        before, number = max(found.values(), key=lambda each: each[1])
        raise composer.refusal(before, number)
    *_, polarity, best = min(ways, key=lambda way: way[:2])
    last_m = composer.route.length_m - _SPARE_M - best.first_m
    if last_m <= 0:
        what = "behind the last joint" if best.calls else "before its end"
        raise UsageError(f"the robot has no room {what}: the route ends too early")
    return RouteCourse(polarity, best.calls, last_m)


def mission_along(
    name: str, route: str, pipe_name: str, robot_name: str, course: RouteCourse, travel: Travel
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
        steps = ", ".join(_written(step) for step in calls)
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


def _written(step: RouteStep) -> str:
    """Return a step of a mission."""
    if step.way_m is None:
        return f"{{call: {step.call}}}"
    return f"{{call: {step.call}, with: {{way: {step.way_m * 1e3:.0f} mm}}}}"


def _following(phases: Sequence[str]) -> Sequence[str]:
    """Return the phase after each."""
    return (*phases[1:], "arrive") if phases else ()


BY_HAND = "by_hand"


def mission_on_route(
    name: str, pipe_name: str, file: Path, route: str | None, robot: str, profile: Profile
) -> str:
    """Return the text of a mission along a route of a pipe.

    Args:
        name: Name of the mission.
        pipe_name: What the mission calls the pipe.
        file: The file of the pipe.
        route: Name of the route; None: the pipe's own.
        robot: What the mission calls the robot.
        profile: The robot's profile.

    Raises:
        LoadError: The pipe has faults, or the robot does not fit into it or cannot pass a joint.
        UsageError: There is no such route.
    """
    pipe, document = load_pipe(file)
    problems = Problems(document)
    check_fit(pipe, profile, document, problems)
    problems.raise_errors()
    if route is not None and route not in pipe.ways:
        hint = meant(route, sorted(pipe.ways))
        raise UsageError(f"'{pipe_name}' has no route '{route}': {hint}")
    try:
        course = course_along(pipe.along(route) if route else pipe, profile)
    except UndrivableError as refusal:
        problems.add("route.undrivable", refusal.path, refusal.message, expected=refusal.needed)
        problems.raise_errors()
        raise
    assert profile.travel is not None  # as course_along has seen
    return mission_along(name, route or "", pipe_name, robot, course, profile.travel)


def by_hand(robot: LoadedRobot, pipe: Pipe | None = None, pipe_name: str = "") -> LoadedMission:
    """Return a mission with one endless wait, in which only the operator moves the robot.

    Faults that a mission may handle are only reported, because the operator is present. All other
    faults end it in the safe state. Safety rules that a mission may waive are waived.
    """
    spec = robot.normal
    codes = [code for code, catchable in spec.fault_codes.items() if catchable]
    handlers = tuple(HandlerSpec(code, None, "") for code in codes)
    bores_m = pipe.bores_m(sum(spec.body.lengths_m)) if pipe is not None else ()
    program = Program(
        instructions=(Enter(BY_HAND, 1), Wait(BY_HAND, (), inf, -1, "", "")),
        start=0,
        start_configuration=robot.table.initial,
        handlers=(handlers, handlers),
        phases=(BY_HAND,),
        phase_of=(BY_HAND, BY_HAND),
        time_limit_s=inf,
        rules=tuple(rule for rule in robot.rules if not rule.waived_by),
        diameter_m=bores_m[0] if bores_m else None,
        bores_m=bores_m,
    )
    mission = Mission(
        format=1,
        mission=BY_HAND,
        robot=robot.profile.robot,
        start=BY_HAND,
        phases={BY_HAND: Phase(go=BY_HAND)},
        ends={BY_HAND: End(succeed="")},
    )
    return LoadedMission(mission, robot, spec, program, pipe, pipe_name, robot.documents, {}, {})
