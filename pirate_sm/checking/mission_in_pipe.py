"""Check that a mission fits its pipe: room, the side of its bends, and its hold on a slope.

Only what the mission does while nothing goes wrong is judged (:mod:`pirate_sm.checking.course`).
Loading has already checked that the robot's parts reach the walls (`pipe.reach`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import copysign, degrees, pi, remainder

from pirate_sm.checking.course import Bends, Course, Situation, course_of
from pirate_sm.checking.findings import Finding, Severity, at
from pirate_sm.checking.robot_in_pipe import Fit
from pirate_sm.engine.mission.program import Do
from pirate_sm.geometry.route import Piece
from pirate_sm.loading.mission import LoadedMission
from pirate_sm.loading.problems import Path, Place
from pirate_sm.loading.yaml.document import Document
from pirate_sm.model.pipe import Mitre, Pipe

MOST_ROLL_RAD = pi / 18
"""A part that is rolled by this much against a bend does not pass it (docs/simulator.md)."""


def check_in_pipe(loaded: LoadedMission) -> tuple[Finding, ...]:
    """Return where a mission does not fit its pipe, by place; nothing without a pipe."""
    if loaded.pipe is None:
        return ()
    profile = loaded.loaded_robot.profile
    course = course_of(loaded.robot, loaded.program, profile)
    if course is None:
        return ()
    check = _Check(loaded, loaded.pipe, course, Fit(profile, loaded.robot, loaded.pipe))
    found = [*check.start(), *check.side(), *check.standing(), *check.holding()]
    return tuple(sorted(found, key=lambda each: each.order))


@dataclass(frozen=True)
class _Check:
    """The checks of one mission in its pipe."""

    loaded: LoadedMission
    pipe: Pipe
    course: Course
    fit: Fit

    # --- room ----------------------------------------------------------------------------------

    def start(self) -> Iterator[Finding]:
        """Report a robot that does not begin in one piece of the pipe, clear of every bend."""
        if self.course.situations[0].bent:
            return  # it begins in the bend
        clamped = bool(self.fit.robot.held[self.course.situations[0].configuration])
        length = self.fit.clamped_m if clamped else self.fit.stretched_m
        first = self.pipe.start_of(self.fit.stretched_m)
        last = first - length
        how = f"the robot, {_mm(length)} long there, with its first wheel at {_mm(first)}"
        if last < 0 or first > self.fit.route.pieces[-1].ends_m:
            end = "beginning" if last < 0 else "end"
            yield self._of_pipe(self._start, "geometry.too_close", f"{how} juts out of the {end}")
            return
        for before in self.fit.route.pieces[:-1]:
            crossing = before.ends_m
            taken = before.taken_m[1]
            if last < crossing + taken and first > crossing - taken:
                where = f"the bend at {_mm(crossing)}, which begins {_mm(taken)} before"
                message = f"{how} stands in {where} the crossing of the axes"
                yield self._of_pipe(self._start, "geometry.too_close", message)
                return

    def standing(self) -> Iterator[Finding]:
        """Report a piece behind the bend that is too short for a robot that comes to hold in it."""
        everything = frozenset(range(len(self.fit.robot.parts)))
        round_it = [
            each
            for each in self.course.situations
            if self.fit.robot.held[each.configuration] == everything
            and everything <= set(each.bent)
        ]
        piece = self._behind(round_it[0].bent[0]) if round_it else None
        if piece is None:
            return
        low, high = piece.clear_m
        if high - low < self.fit.clamped_m:
            room, need = _mm(high - low), _mm(self.fit.clamped_m)
            message = (
                f"there are {room} of straight walls here, and the clamped robot, which the mission"
                f" brings here, is {need} long"
            )
            path = ("segments", piece.segment, "straight")
            yield self._of_pipe(path, "geometry.too_short", message)

    # --- sides ---------------------------------------------------------------------------------

    def side(self) -> Iterator[Finding]:
        """Report parts that are not bent towards the inner wall, in the plane of the bend."""
        mitres = [
            (number, each.mitre)
            for number, each in enumerate(self.pipe.segments)
            if isinstance(each, Mitre)
        ]
        if not mitres:
            yield from self._bent_in_vain()
        if not mitres or not self.course.bends or self._turns():
            return
        if abs(remainder(self.pipe.roll, 2 * pi)) >= MOST_ROLL_RAD:
            message = (
                f"the bend lies {degrees(self.pipe.roll):.4g} deg out of the robot's plane, and the"
                " mission turns no part into it"
            )
            yield self._of_pipe(("roll",), "geometry.out_of_plane", message)
            return
        inner = {int(copysign(1, mitre)) for _, mitre in mitres}
        wrong = [(bend, place) for bend, place in self.course.bends if bend.side not in inner]
        if wrong:
            yield self._wrong_side(wrong[0][0].part, [place for _, place in wrong], mitres[0])

    def _bent_in_vain(self) -> Iterator[Finding]:
        """Report parts that are bent where the pipe goes straight on."""
        mission = self.loaded.documents[0]
        called: list[tuple[Place, str]] = []
        for where, parts in self._bending().items():
            place = self._placed(where)
            name = "' or '".join(self.fit.robot.parts[part] for part in sorted(parts))
            if place.line and place.file == mission.name:
                message = f"this bends '{name}', and the pipe has no bend"
                yield at(mission, place, "geometry.no_bend", Severity.ERROR, message)
            elif place.line:
                called.append((place, f"this bends '{name}'"))
        if called:  # what is called is right by itself: it does not say in which pipe
            message = f"{called[0][0]} bends a part, and this pipe has no bend"
            place = mission.place_of(("pipe",))
            yield at(mission, place, "geometry.no_bend", Severity.ERROR, message, related=called)

    def _bending(self) -> dict[str, frozenset[int]]:
        """Return the parts by the places of the steps that bend them, those of handlers too."""
        found = {where: frozenset({bend.part}) for bend, where in self.course.bends}
        bends = Bends(self.loaded.robot, self.loaded.loaded_robot.profile)
        for each in self.loaded.program.instructions:
            if isinstance(each, Do) and each.place not in found:
                parts = bends.always(each.command)
                if parts:
                    found[each.place] = parts
        return found

    def _wrong_side(self, part: int, places: list[str], mitre: tuple[int, float]) -> Finding:
        polarity = self.fit.robot.polarity
        other = "normal" if polarity == "mirrored" else "mirrored"
        number, angle = mitre
        name = self.fit.robot.parts[part]
        message = (
            f"in {polarity} polarity '{name}' is bent away from the inner wall of the mitre of"
            f" {degrees(angle):.4g} deg"
        )
        related = [(place, "this bends it") for place in map(self._placed, places) if place.line]
        document, prefix = self._pipe
        related.append((document.place_of((*prefix, "segments", number)), "into this"))
        key = "polarity" if self.loaded.mission.polarity is not None else "pipe"
        mission = self.loaded.documents[0]
        place, code = mission.place_of((key,)), "geometry.polarity"
        mend = f"write `polarity: {other}`, or take a pipe that turns to the other side"
        return at(mission, place, code, Severity.ERROR, message, mend=mend, related=related)

    def _turns(self) -> bool:
        """Return whether the mission rolls a part, so that it is not known where its sides are."""
        robot = self.fit.robot
        rolls = {n for n, slot in enumerate(self.fit.profile.slots) if slot.roll is not None}
        return any(
            write.slot in rolls and write.how == "set" and write.value != 0
            for configuration in {each.configuration for each in self.course.situations}
            for region, state in enumerate(robot.table.configurations[configuration])
            for stage in robot.actuation[region][state]
            for write in stage
        )

    # --- forces --------------------------------------------------------------------------------

    def holding(self) -> Iterator[Finding]:
        """Report clamped parts that do not bear the robot's weight by friction."""
        worst: tuple[float, Situation, Piece] | None = None
        every = True
        for situation in self.course.situations:
            for piece in self._stands_in(situation) if self._held(situation) else ():
                pull = self.fit.pull_n(piece)[0]
                share = self._grip_n(situation) / pull if pull > 0 else 1.0
                every = every and share < 1
                if share < 1 and (worst is None or share < worst[0]):
                    worst = share, situation, piece
        if worst is not None:
            _, situation, piece = worst
            yield self._weak(situation, piece, everywhere=every)

    def _weak(self, situation: Situation, piece: Piece, *, everywhere: bool) -> Finding:
        fit, configuration = self.fit, situation.configuration
        held = sorted(self._held(situation))
        torques = [f"{fit.torque_nm(part, configuration):.3g} Nm" for part in held]
        names = " and ".join(f"'{fit.robot.parts[part]}'" for part in held)
        press = sum(fit.press_n(part, configuration) for part in held)
        pull, rests = fit.pull_n(piece)
        message = (
            f"{names}, clamped with {' and '.join(torques)}, press the walls with {press:.3g} N:"
            f" with a friction of {fit.friction:g} that holds {self._grip_n(situation):.3g} N, and"
            f" the weight pulls {pull:.3g} N along the pipe"
        )
        # The weight that rests on the walls helps: where even that is too little, it is certain.
        certain = fit.friction * (press + rests) < pull
        severity = Severity.ERROR if certain else Severity.WARNING
        place = self._placed(situation.place)
        if everywhere or not place.line:
            mission = self.loaded.documents[0]
            inline: Path = ("pipe", "tilt") if isinstance(self.loaded.mission.pipe, Pipe) else ()
            place = mission.place_of(inline or ("pipe",))
        document = self._document(place.file)
        return at(document, place, "geometry.clamp_torque", severity, message)

    def _held(self, situation: Situation) -> frozenset[int]:
        return self.fit.robot.held[situation.configuration]

    def _grip_n(self, situation: Situation) -> float:
        """Return the largest friction of all clamped parts."""
        configuration = situation.configuration
        return self.fit.friction * sum(
            self.fit.press_n(part, configuration) for part in self._held(situation)
        )

    # --- places --------------------------------------------------------------------------------

    def _stands_in(self, situation: Situation) -> list[Piece]:
        """Return where the robot can be: where it began, and behind the bend once it has bent."""
        behind = self._behind(situation.bent[0]) if situation.bent else None
        return [self._first] if behind is None else [self._first, behind]

    def _behind(self, leading: int) -> Piece | None:
        """Return the piece behind the first bend of a robot whose leading part is this one."""
        wheels, pieces = self.fit.profile.body.wheels, self.fit.route.pieces
        part, first = self.fit.robot.parts[leading], pieces.index(self._first)
        step = 1 if part == wheels[0].part else -1 if part == wheels[-1].part else 0
        return pieces[first + step] if step and 0 <= first + step < len(pieces) else None

    @property
    def _first(self) -> Piece:
        """The piece that the robot begins in."""
        middle = self.pipe.start_of(self.fit.stretched_m) - self.fit.stretched_m / 2
        return self.fit.route.piece_at(middle)

    @property
    def _start(self) -> Path:
        """Where the pipe says where the robot begins, or the piece that it is put into."""
        return ("start", "at") if self.pipe.start is not None else ("segments", 0)

    @property
    def _pipe(self) -> tuple[Document, Path]:
        """The file that describes the pipe, and where in it."""
        inline = isinstance(self.loaded.mission.pipe, Pipe) and (
            self.loaded.pipe is self.loaded.mission.pipe
        )
        return self.loaded.documents[-1], ("pipe",) if inline else ()

    def _of_pipe(self, path: Path, code: str, message: str) -> Finding:
        document, prefix = self._pipe
        place = document.place_of((*prefix, *path))
        return at(document, place, code, Severity.ERROR, message)

    def _placed(self, text: str) -> Place:
        """Return the place of a step, from `file:line:col`."""
        if not text:
            return Place(self.loaded.documents[0].name)
        file, line, column = text.rsplit(":", 2)
        return Place(file, int(line), int(column))

    def _document(self, name: str) -> Document:
        return next(each for each in self.loaded.documents if each.name == name)


def _mm(length_m: float) -> str:
    return f"{length_m * 1000:.4g} mm"
