"""Whether a mission fits its pipe: room, the side of its bends, and what holds it on a slope.

Judged is what the mission does while nothing goes wrong (:mod:`pirate_sm.checking.course`). That
the robot's parts reach the walls at all is found at loading (`pipe.reach`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import copysign, degrees, pi, remainder

from pirate_sm.checking.course import Bends, Course, Situation, course_of
from pirate_sm.checking.findings import Finding, Severity, at
from pirate_sm.checking.fit import Fit, Leg, legs_of
from pirate_sm.engine.mission.program import Do
from pirate_sm.loading.mission import LoadedMission
from pirate_sm.loading.problems import Path, Place
from pirate_sm.loading.source import Document
from pirate_sm.model.pipe import Mitre, Pipe

MOST_ROLL_RAD = pi / 18
"""A part that is turned by this much against a bend does not pass it (docs/simulator.md)."""


def check_geometry(loaded: LoadedMission) -> tuple[Finding, ...]:
    """What of a mission does not fit its pipe, by place; nothing for one without a pipe."""
    if loaded.pipe is None:
        return ()
    profile = loaded.loaded_robot.profile
    course = course_of(loaded.robot, loaded.program, profile)
    if course is None:
        return ()
    fit = Fit(profile, loaded.robot, loaded.pipe)
    check = _Geometry(loaded, loaded.pipe, course, fit, legs_of(loaded.pipe))
    found = [*check.start(), *check.side(), *check.standing(), *check.holding()]
    return tuple(sorted(found, key=lambda each: each.order))


@dataclass(frozen=True)
class _Geometry:
    """A mission in its pipe, under examination.

    Attributes:
        legs: Of the pipe, in order.
    """

    loaded: LoadedMission
    pipe: Pipe
    course: Course
    fit: Fit
    legs: tuple[Leg, ...]

    # --- room ----------------------------------------------------------------------------------

    def start(self) -> Iterator[Finding]:
        """The robot stands in one leg when it begins, clear of every bend."""
        if self.course.situations[0].bent:
            return  # it begins in the bend
        clamped = bool(self.fit.robot.held[self.course.situations[0].configuration])
        length = self.fit.clamped_m if clamped else self.fit.stretched_m
        first = self.pipe.start_of(self.fit.stretched_m)
        last = first - length
        how = f"the robot, {_mm(length)} long there, with its first wheel at {_mm(first)}"
        if last < 0 or first > self.legs[-1].ends_m:
            end = "beginning" if last < 0 else "end"
            yield self._of_pipe(self._start, "geometry.too_close", f"{how} juts out of the {end}")
            return
        for before in self.legs[:-1]:
            crossing = before.ends_m
            taken = before.taken_m[1]
            if last < crossing + taken and first > crossing - taken:
                yield self._of_pipe(
                    self._start, "geometry.too_close",
                    f"{how} stands in the bend at {_mm(crossing)}, which begins {_mm(taken)} before"
                    " the crossing of the axes",
                )  # fmt: skip
                return

    def standing(self) -> Iterator[Finding]:
        """Behind the bend there is room for a robot that has come round it and holds."""
        everything = frozenset(range(len(self.fit.robot.parts)))
        round_it = [
            each
            for each in self.course.situations
            if self.fit.robot.held[each.configuration] == everything
            and everything <= set(each.bent)
        ]
        leg = self._behind(round_it[0].bent[0]) if round_it else None
        if leg is None:
            return
        low, high = leg.clear_m
        if high - low < self.fit.clamped_m:
            room, need = _mm(high - low), _mm(self.fit.clamped_m)
            yield self._of_pipe(
                ("segments", leg.segment, "straight"), "geometry.too_short",
                f"there are {room} of straight walls here, and the clamped robot, which the mission"
                f" brings here, is {need} long",
            )  # fmt: skip

    # --- sides ---------------------------------------------------------------------------------

    def side(self) -> Iterator[Finding]:
        """Each part is bent towards the inner wall, in the plane of the bend."""
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
            yield self._of_pipe(
                ("roll",), "geometry.out_of_plane",
                f"the bend lies {degrees(self.pipe.roll):.4g} deg out of the robot's plane, and the"
                " mission turns no part into it",
            )  # fmt: skip
            return
        inner = {int(copysign(1, mitre)) for _, mitre in mitres}
        wrong = [(bend, place) for bend, place in self.course.bends if bend.side not in inner]
        if wrong:
            yield self._wrong_side(wrong[0][0].part, [place for _, place in wrong], mitres[0])

    def _bent_in_vain(self) -> Iterator[Finding]:
        """Parts that are bent where the pipe goes straight on."""
        mission = self.loaded.documents[0]
        called: list[tuple[Place, str]] = []
        for where, parts in self._bending().items():
            place = self._placed(where)
            name = "' or '".join(self.fit.robot.parts[part] for part in sorted(parts))
            if place.line and place.file == mission.name:
                yield at(
                    mission, place, "geometry.no_bend", Severity.ERROR,
                    f"this bends '{name}', and the pipe has no bend",
                )  # fmt: skip
            elif place.line:
                called.append((place, f"this bends '{name}'"))
        if called:  # what is called is right by itself: it does not say in which pipe
            yield at(
                mission, mission.place_of(("pipe",)), "geometry.no_bend", Severity.ERROR,
                f"{called[0][0]} bends a part, and this pipe has no bend", related=tuple(called),
            )  # fmt: skip

    def _bending(self) -> dict[str, frozenset[int]]:
        """Parts by the places of the steps that bend one of them, those of handlers too."""
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
        return at(
            mission, mission.place_of((key,)), "geometry.polarity", Severity.ERROR, message,
            mend=f"write `polarity: {other}`, or take a pipe that turns to the other side",
            related=related,
        )  # fmt: skip

    def _turns(self) -> bool:
        """Whether the mission turns parts against each other, so that sides are not known."""
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
        """What is clamped bears the robot's weight by friction."""
        worst: tuple[float, Situation, Leg] | None = None
        every = True
        for situation in self.course.situations:
            for leg in self._legs(situation) if self._held(situation) else ():
                pull = self.fit.pull_n(leg)[0]
                share = self._grip_n(situation) / pull if pull > 0 else 1.0
                every = every and share < 1
                if share < 1 and (worst is None or share < worst[0]):
                    worst = share, situation, leg
        if worst is not None:
            _, situation, leg = worst
            yield self._weak(situation, leg, everywhere=every)

    def _weak(self, situation: Situation, leg: Leg, *, everywhere: bool) -> Finding:
        fit, configuration = self.fit, situation.configuration
        held = sorted(self._held(situation))
        torques = [f"{fit.torque_nm(part, configuration):.3g} Nm" for part in held]
        names = " and ".join(f"'{fit.robot.parts[part]}'" for part in held)
        press = sum(fit.press_n(part, configuration) for part in held)
        pull, rests = fit.pull_n(leg)
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
        """The largest friction of all that is clamped."""
        configuration = situation.configuration
        return self.fit.friction * sum(
            self.fit.press_n(part, configuration) for part in self._held(situation)
        )

    # --- places --------------------------------------------------------------------------------

    def _legs(self, situation: Situation) -> list[Leg]:
        """Where the robot can be: where it began, and behind the bend once it has bent."""
        behind = self._behind(situation.bent[0]) if situation.bent else None
        return [self._first] if behind is None else [self._first, behind]

    def _behind(self, leading: int) -> Leg | None:
        """The leg behind the first bend of a robot whose leading part is this one."""
        wheels = self.fit.profile.body.wheels
        number = self.legs.index(self._first)
        part = self.fit.robot.parts[leading]
        number += 1 if part == wheels[0].part else -1 if part == wheels[-1].part else 0
        if number == self.legs.index(self._first) or not 0 <= number < len(self.legs):
            return None
        return self.legs[number]

    @property
    def _first(self) -> Leg:
        """The leg that the robot begins in."""
        middle = self.pipe.start_of(self.fit.stretched_m) - self.fit.stretched_m / 2
        return next((leg for leg in self.legs if middle <= leg.ends_m), self.legs[-1])

    @property
    def _start(self) -> Path:
        """Where the pipe says where the robot begins, or the leg that it is put into."""
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
        """The place of a step, from `file:line:col`."""
        if not text:
            return Place(self.loaded.documents[0].name)
        file, line, column = text.rsplit(":", 2)
        return Place(file, int(line), int(column))

    def _document(self, name: str) -> Document:
        return next(each for each in self.loaded.documents if each.name == name)


def _mm(length_m: float) -> str:
    return f"{length_m * 1000:.4g} mm"
