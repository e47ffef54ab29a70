"""A mission in its pipe as seen by the rules: pieces, places in files, its progress."""

from __future__ import annotations

from bisect import bisect
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from pirate_sm.checking.findings import Finding, at
from pirate_sm.checking.pipe.robot_in_pipe import Fit, PartRolls, RollJoint
from pirate_sm.checking.pipe.usual_course import CoursePoint, UsualCourse
from pirate_sm.core.documents import Document, Path, Place
from pirate_sm.core.geometry import Piece, RouteJoint
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.models import Pipe
from pirate_sm.core.program import Do, Require


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

    def stretch(self, number: int) -> Sequence[Piece]:
        """Return the straight pieces of one diameter in a stretch in which the route does not turn.

        Args:
            number: Which stretch, counted from that in which the robot starts.
        """
        return self._stretches.get(self.bends_behind_start + number, ())

    @cached_property
    def _stretches(self) -> Mapping[int, Sequence[Piece]]:
        """Return the straight pieces of one diameter by how many bends are behind them."""
        found, arcs = defaultdict[int, list[Piece]](list), [bend.arc_m for bend in self.bends]
        for piece in self.fit.route.pieces:
            if piece.arc is None and piece.ends_with_m == piece.diameter_m:
                found[bisect(arcs, (piece.arc_m + piece.ends_m) / 2)].append(piece)
        return found

    @cached_property
    def first_piece(self) -> Piece:
        """Return the piece in which the robot starts."""
        return self.fit.route.piece_at(self._middle_m)

    @cached_property
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
