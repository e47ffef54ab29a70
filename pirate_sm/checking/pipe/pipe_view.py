"""A mission in its pipe as seen by the rules: pieces, places in files, its progress."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from typing import Any, NamedTuple

from pirate_sm.checking.exploring.signal_ranges import signals, value
from pirate_sm.checking.findings import Finding, at
from pirate_sm.checking.pipe.robot_in_pipe import Fit, PartRolls, RollJoint
from pirate_sm.checking.pipe.usual_course import Bends, CoursePoint, UsualCourse, course_of
from pirate_sm.core.documents import Document, Path, Place
from pirate_sm.core.expressions import change_of, tree
from pirate_sm.core.geometry import Piece, RouteJoint
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.pipe import Pipe
from pirate_sm.core.profile import DetectorPoint
from pirate_sm.core.program import Do, Require, Wait


@dataclass(frozen=True)
class PipeView:
    """A mission in its pipe.

    Attributes:
        loaded: The mission.
        pipe: Its pipe.
        course: The course of the mission without failures.
        fit: The robot in the pipe.
    """

    loaded: LoadedMission
    pipe: Pipe
    course: UsualCourse
    fit: Fit

    @cached_property
    def roll_joint(self) -> RollJoint:
        """Return the roll joint of the robot."""
        return RollJoint(self.fit.force)

    @property
    def start_roll_rad(self) -> float:
        """Return the roll of the robot as it starts, against the frame of the route."""
        start = self.pipe.start
        return (start.roll if start is not None else 0.0) - self.pipe.roll

    @cached_property
    def bends(self) -> tuple[RouteJoint, ...]:
        """Return the joints in which the route turns."""
        return tuple(joint for joint in self.fit.route.joints if joint.turn_rad)

    @cached_property
    def bends_behind_start(self) -> int:
        """Return how many bends are behind the robot as it starts."""
        return sum(bend.arc_m < self._middle_m for bend in self.bends)

    def bend(self, number: int) -> RouteJoint | None:
        """Return a bend, counted from the robot's start as the course counts them."""
        index = self.bends_behind_start + number
        return self.bends[index] if 0 <= index < len(self.bends) else None

    def arcs(self, number: int) -> tuple[float, float] | None:
        """Return between which arc lengths the route does not turn, m.

        Args:
            number: Which stretch, counted from that in which the robot starts; None if the pipe
                has no such stretch.
        """
        before, behind = self.bend(number - 1), self.bend(number)
        if not 0 <= self.bends_behind_start + number <= len(self.bends):
            return None
        return before.arc_m if before else 0.0, behind.arc_m if behind else self.fit.route.length_m

    def stretch(self, number: int) -> tuple[Piece, ...]:
        """Return the straight pieces of one diameter in a stretch in which the route does not turn.

        Args:
            number: Which stretch, counted from that in which the robot starts.
        """
        arcs = self.arcs(number)
        if arcs is None:
            return ()
        return tuple(
            piece
            for piece in self.fit.route.pieces
            if piece.arc is None
            and piece.ends_with_m == piece.diameter_m
            and arcs[0] < (piece.arc_m + piece.ends_m) / 2 < arcs[1]
        )

    @cached_property
    def first_piece(self) -> Piece:
        """Return the piece in which the robot starts."""
        return self.fit.route.piece_at(self._middle_m)

    @property
    def _middle_m(self) -> float:
        return self.pipe.start_of(self.fit.stretched_m) - self.fit.stretched_m / 2

    @property
    def start_path(self) -> Path:
        """Return the path of the robot's start position in the pipe, or of the first piece."""
        if self.pipe.start is not None:
            return ("start", "at")
        return self.pipe.path_of(self.fit.route.pieces[0])

    @property
    def pipe_document(self) -> tuple[Document, Path]:
        """Return the document that contains the pipe, and the pipe's path in it."""
        inline = isinstance(self.loaded.mission.pipe, Pipe) and (
            self.loaded.pipe is self.loaded.mission.pipe
        )
        return self.loaded.documents[-1], ("pipe",) if inline else ()

    def finding_in_pipe(self, path: Path, code: str, message: str) -> Finding:
        """Return a finding at a part of the pipe's description."""
        document, _ = self.pipe_document
        return at(document, self.place_in_pipe(path), code, message)

    def place_in_pipe(self, path: Path) -> Place:
        """Return the place of a part of the pipe's description."""
        document, prefix = self.pipe_document
        return document.place_of((*prefix, *path))

    def path_of(self, joint: RouteJoint) -> Path:
        """Return the path of a joint in the pipe: of its tee, or of its fitting."""
        return self.pipe.path_of_joint(self.fit.route, joint)

    def place_of_step(self, text: str) -> Place:
        """Return the place of a step, from `file:line:col`."""
        return Place.read(text) if text else Place(self.loaded.documents[0].name)

    def calls(self, at: int) -> tuple[Require, ...]:
        """Return the calls in which an instruction is written out, outermost first."""
        program, found = self.loaded.program, list[Require]()
        if not 0 <= at < len(program.phase_of):
            return ()
        inside, wanted = program.phase_of[at], program.phase_of[at].partition("/")[0]
        for number in range(at - 1, -1, -1):
            it, phase = program.instructions[number], program.phase_of[number]
            if isinstance(it, Require) and inside.startswith(f"{phase}/") and it.call:
                found.append(it)
                inside = phase
                if phase == wanted:
                    break
        return tuple(reversed(found))

    def own_place(self, at: int, text: str) -> Place:
        """Return the place of a step, or in the mission's own file of the call that leads to it.

        Args:
            at: An instruction of the step.
            text: Its place, as `file:line:col`.
        """
        own = self.loaded.documents[0].name
        place = self.place_of_step(text)
        calls = self.calls(at)
        return self.place_of_step(calls[0].place) if place.file != own and calls else place

    def finding_at(self, point: CoursePoint, code: str, message: str, **more: Any) -> Finding:
        """Return a finding, with its story, at the step of a point or the call that leads to it.

        Args:
            point: The point.
            code: An entry of the catalogue.
            message: What is wrong, in one sentence.
            more: Further arguments of :func:`pirate_sm.checking.findings.at`.
        """
        place = self.own_place(point.at - 1, point.place)
        place = place if place.line else self.loaded.documents[0].place_of(("pipe",))
        return story_of(at(self.document(place.file), place, code, message, **more), self, point)

    def stands_in(self, point: CoursePoint) -> list[Piece]:
        """Return the pieces in which the robot can be: those before and behind its bend."""
        if not point.driven and not point.bent and not point.passed:
            return [self.first_piece]
        found = list(self.stretch(point.passed))
        if point.bent:
            found += self.stretch(point.passed + self.course.leads[point.bent[0]])
        return found or [self.first_piece]

    def document(self, name: str) -> Document:
        """Return the file of this name."""
        return next(each for each in self.loaded.documents if each.name == name)


def mm(length_m: float) -> str:
    """Return a length in mm for messages."""
    return f"{length_m * 1000:.4g} mm"


def story_of(finding: Finding, view: PipeView, point: CoursePoint) -> Finding:
    """Return a finding with its story: one sentence for each step that leads to a point."""
    steps = {
        each.place: view.fit.robot.commands[each.command].name
        for each in view.loaded.program.instructions
        if isinstance(each, Do)
    }
    return replace(finding, story=tuple(_sentences(view, point, steps)))


def _sentences(view: PipeView, point: CoursePoint, steps: dict[str, str]) -> Iterator[str]:
    yield "the mission begins"
    rolls = view.course.situations[0].rolls
    for each in view.course.way_to(point):
        name = steps.get(each.place, "the control")
        yield f"{name} ({each.place}) is done{_turned(view, rolls, each.rolls)}"
        rolls = each.rolls


def _turned(view: PipeView, before: PartRolls | None, after: PartRolls | None) -> str:
    """Return which part a command has turned, with its angle; empty if none."""
    if before is None or after is None or before == after:
        return ""
    joint = view.roll_joint
    ahead = before.ahead != after.ahead
    names = [
        name for part, name in enumerate(view.fit.robot.parts) if joint.is_ahead(part) == ahead
    ]
    change = after.ahead - before.ahead if ahead else after.behind - before.behind
    turned = f"{(change + 2) % 4 - 2:+.3g} quarter turn"
    return f"; it rolls '{' and '.join(names)}' by {turned}"


# --- at waits ------------------------------------------------------------------------------------


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
            # A word of the first wheels is of the next bend, one of the last of that behind.
            number = ahead - point.way if self._leads_m(at, point.way) > 0 else ahead
            return view.bend(number) is not None
        return whole or lead != point.way or not self._is_last(at, point.way)

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

    def _leads_m(self, at: DetectorPoint, way: int) -> float:
        """Return how far the first wheel is beyond the crossing when a word is said."""
        body = self._view.fit.profile.body
        number = [wheel.name for wheel in body.wheels].index(at.wheel)
        links = body.links[:number] if way > 0 else body.links[number:]
        return at.passed + sum(link.length for link in links)

    def _is_last(self, at: DetectorPoint, way: int) -> bool:
        """Return whether a word is said when a wheel of the last part is round the bend."""
        wheels = self._view.fit.profile.body.wheels
        part = next(wheel.part for wheel in wheels if wheel.name == at.wheel)
        return at.passed > 0 and part == wheels[-1 if way > 0 else 0].part

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
