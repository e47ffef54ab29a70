"""What the ways of a mission along its route say of its waits: distances and words of signals."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterator, Mapping
from functools import cached_property
from math import inf
from typing import NamedTuple

from pirate_sm.checking.exploring.signal_ranges import signals, value
from pirate_sm.checking.pipe.pipe_view import PipeView, mm
from pirate_sm.checking.pipe.usual_course import Bends, CoursePoint, course_of
from pirate_sm.core.expressions import change_of, tree
from pirate_sm.core.geometry import RouteJoint
from pirate_sm.core.program import Wait

_JOINT, _OUT = "Joint", "Out"


class Silent(NamedTuple):
    """Words that a signal never has in a wait.

    Attributes:
        signal: The signal.
        words: The words.
        why: The reason, for people.
        here: Whether it follows from what the mission has done before.
    """

    signal: str
    words: frozenset[str]
    why: str
    here: bool = False


class AtWaits:
    """What the ways of a mission along its route say of its waits.

    All ways to a wait count, those after failures, time limits and faults too. Nothing is said of a
    wait that only these lead to, nor if there are too many ways.
    """

    def __init__(self, view: PipeView) -> None:
        self._view = view
        robot, profile = view.fit.robot, view.fit.profile
        bends, program = len(view.bends), view.loaded.program
        self._course = course_of(view.fit.force, program, bends, failing=True)
        situations = self._course.situations if self._course is not None else ()
        usual = {each.at for each in view.course.situations}
        self._points: dict[int, list[CoursePoint]] = defaultdict(list)
        for each in situations:
            if each.at in usual:
                self._points[each.at].append(each)
        self._onward = all(each.way >= 0 for each in situations)
        self._bends_parts = _bending(view)
        self._anywhere = {each.word for each in robot.word_conditions}
        said = ((w, it) for w, it in profile.detector.words.items() if w not in self._anywhere)
        self._words = {word: it for word, it in said if it.forward}
        numbers = robot.vocabulary.numbers
        self._changed = change_of(numbers[robot.odometry]) if robot.odometry >= 0 else ""
        self._blocked = self._bends_parts and all(_stops(joint) for joint in view.bends)

    # --- distances --------------------------------------------------------------------------

    def most_m(self, at: int) -> tuple[float, float, str]:
        """Return how far the robot comes in a wait and since its start, and what ends the way."""
        points = self._points[at]
        if not points or not self._blocked:
            return inf, inf, ""
        found = [self._way(each) for each in points]
        most, what = max(found)
        first = all(not each.bent and not each.passed and each.way > 0 for each in points)
        return most, most if first and self._onward else inf, what

    def _way(self, point: CoursePoint) -> tuple[float, str]:
        """Return how far the robot can drive from a point, and what is there."""
        view = self._view
        numbers, first, last = self._stretches(point)
        if first is None or last is None or not point.way:
            return inf, ""
        start_m = view.pipe.start_of(view.fit.stretched_m)
        begins_m = start_m if self._onward and not point.bent and not point.passed else first[0]
        whole = len(point.bent) == len(view.fit.robot.parts)
        if whole and view.course.leads[point.bent[0]] == point.way > 0:
            begins_m = last[0]  # the first wheel is round the bend
        joint = view.bend(numbers[-1] if point.way > 0 else numbers[0] - 1)
        diameter_m = view.fit.route.diameter_at(begins_m)
        way_m = last[1] - begins_m + (diameter_m if joint is not None else 0.0)
        way_m -= max(self._driven_m.get(point[:-1], 0.0), 0.0)
        return way_m, _described(view, joint, point.way)

    def _stretches(
        self, point: CoursePoint
    ) -> tuple[list[int], tuple[float, float] | None, tuple[float, float] | None]:
        """Return the stretches in which a robot can be, and the arc lengths of the outer two."""
        others = [self._view.course.leads[part] for part in point.bent[:1]]
        numbers = sorted({point.passed, *(point.passed + each for each in others)})
        return numbers, self._view.arcs(numbers[0]), self._view.arcs(numbers[-1])

    @cached_property
    def _driven_m(self) -> Mapping[tuple[object, ...], float]:
        """How far the robot has come at least since its last bend, by points; -inf if unknown."""
        assert self._course is not None  # there are points
        first, onward = self._course.situations[0], self._course.onward
        least: dict[tuple[object, ...], float] = {first[:-1]: 0.0}
        waiting = deque([first])
        while waiting:
            now = waiting.popleft()
            for after in onward[now[:-1]]:
                same = (now.bent, now.passed) == (after.bent, after.passed)
                way_m = least[now[:-1]] + self._least_m(now.at, after.at) if same else 0.0
                way_m = way_m if after.way >= 0 else -inf
                if way_m < least.get(after[:-1], inf):
                    least[after[:-1]] = way_m
                    waiting.append(after)
        return least

    def _least_m(self, at: int, target: int) -> float:
        """Return how far the robot has come at least in a wait that led to an instruction."""
        program = self._view.loaded.program
        it = program.instructions[at]
        if not isinstance(it, Wait) or it.counts_on or target in program.failures(at):
            return 0.0
        led = [each.condition for each in it.triggers if each.go == target]
        return min(0.0 if each is None else self._change_m(each.tree) for each in led)

    def _change_m(self, node: tree.Node) -> float:
        """Return from which change of the odometry on a condition can be true; 0 if unknown."""
        match node:
            case tree.And(parts):
                return max(map(self._change_m, parts))
            case tree.Compare(">=" | ">", tree.Signal(self._changed), most) if not signals(most):
                return max(value(most, 0.0), 0.0)
            case tree.Compare("<=" | "<", least, tree.Signal(self._changed)) if not signals(least):
                return max(value(least, 0.0), 0.0)
        return 0.0

    # --- words ------------------------------------------------------------------------------

    def silent(self, at: int) -> Iterator[Silent]:
        """Yield what signals never say in a wait, where the course leads to it."""
        route, points = self._view.fit.route, self._points[at]
        if not self._view.bends:
            why = "waits for a bend, and the pipe has none"
            yield Silent("detector", frozenset(self._words), why)
            if not self._anywhere:
                yield Silent("segment", frozenset({_JOINT}), why)
        kinds = {"mitre", "elbow", "tee", "reducer"} - {each.kind for each in route.joints}
        said = {it.joint for it in self._view.fit.profile.detector.words.values()}
        why = "waits for a joint of a kind that the pipe does not have"
        if not self._anywhere:
            yield Silent("joint", frozenset(kinds), why)
        of_kinds = {w for w, it in self._words.items() if it.joint in kinds & said}
        yield Silent("detector", frozenset(of_kinds), why)
        if not points or not all(each.way for each in points):
            return
        if self._blocked and not self._anywhere and all(each.way > 0 for each in points):
            ahead = {kind for each in points for kind in self._ahead(each)}
            why = "waits for a joint that is not the next one here"
            others = {"end", *(each.kind for each in route.joints)} - ahead
            yield Silent("joint", frozenset(others), why, here=True)
        if self._view.bends and self._bends_parts:
            of_bends = [w for w, it in self._words.items() if it.joint in (None, "mitre", "elbow")]
            never = {word for word in of_bends if not any(self._said(word, p) for p in points)}
            yield Silent("detector", frozenset(never), self._why(never, points), here=True)
        if not self._anywhere and all(_capped(self._view, each.way) for each in points):
            yield Silent("segment", frozenset({_OUT}), "waits to leave a pipe that ends in a cap")

    def _said(self, word: str, point: CoursePoint) -> bool:
        """Return whether a word can be said at a point of the course."""
        view, it = self._view, self._words[word]
        at = it.forward if point.way > 0 else it.backward
        assert at is not None  # as __init__ has chosen them
        lead = view.course.leads[point.bent[0]] if point.bent else 0
        whole = len(point.bent) == len(view.fit.robot.parts)
        if not point.bent or (whole and lead == point.way):
            ahead = point.passed - (point.way < 0) + lead
            # A word of the first wheels is of the next bend, one of the last of that before.
            number = (
                ahead - point.way if self._leads_m(at.wheel, at.passed, point.way) > 0 else ahead
            )
            return view.bend(number) is not None
        return whole or lead != point.way or not self._is_last(at.wheel, at.passed, point.way)

    def _ahead(self, point: CoursePoint) -> set[str]:
        """Return the kinds of the joints before which the robot can be in a wait, driving on."""
        view = self._view
        numbers, first, last = self._stretches(point)
        if first is None or last is None:
            return {"end"}
        found: set[str] = {
            each.kind for each in view.fit.route.joints if first[0] <= each.arc_m <= last[1]
        }
        return found if view.bend(numbers[-1]) is not None else found | {"end"}

    def _leads_m(self, wheel: str, passed_m: float, way: int) -> float:
        """Return how far the first wheel is beyond the crossing when a word is said."""
        body = self._view.fit.profile.body
        number = [each.name for each in body.wheels].index(wheel)
        links = body.links[:number] if way > 0 else body.links[number:]
        return passed_m + sum(link.length for link in links)

    def _is_last(self, wheel: str, passed_m: float, way: int) -> bool:
        """Return whether a word is said when a wheel of the last part is round the bend."""
        wheels = self._view.fit.profile.body.wheels
        part = next(each.part for each in wheels if each.name == wheel)
        return passed_m > 0 and part == wheels[-1 if way > 0 else 0].part

    def _why(self, words: set[str], points: list[CoursePoint]) -> str:
        """Return why words are not said at points of the course."""
        view, point = self._view, points[0]
        lead = view.course.leads[point.bent[0]] if point.bent else 0
        if not point.bent and view.bend(point.passed - (point.way < 0)) is not None:
            return "is said in a bend, and no part of the robot has bent into one before"
        if len(point.bent) < len(view.fit.robot.parts) and lead == point.way:
            return "is said after the bend, and only a part of the robot has bent into it"
        return "waits for a bend, and the route has no other bend in that direction"


def _stops(joint: RouteJoint) -> bool:
    """Return whether a robot that does not bend stops at a joint: a mitre, or the wall of a tee."""
    return joint.kind in ("mitre", "tee", "elbow") and joint.turn_rad > _LEAST_TURN_RAD


_LEAST_TURN_RAD = 0.5
"""Smallest turn that a straight robot does not drive round [decided]: 29 deg."""


def _bending(view: PipeView) -> bool:
    """Return whether the robot has commands that bend a part into a bend."""
    bends, table = Bends(view.fit.force), view.fit.robot.table
    return any(bends.of(number) for number in range(len(table.configurations)))


def _capped(view: PipeView, way: int) -> bool:
    """Return whether the route ends in a cap in a direction."""
    route = view.fit.route
    return route.ends[way > 0] in route.network.closed


def _described(view: PipeView, joint: RouteJoint | None, way: int) -> str:
    if joint is not None:
        where = f"the {joint.kind} at {mm(joint.arc_m)} of the route"
        return f"the robot comes to {where} before, and does not bend into it"
    place = f"the end of the route at {mm(view.fit.route.length_m)}" if way > 0 else "its beginning"
    leaves = "which is closed" if _capped(view, way) else "where it leaves the pipe"
    return f"the robot comes to {place} before, {leaves}"
