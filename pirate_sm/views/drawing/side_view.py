"""A robot from the side, clamped between two walls, and which way each setpoint moves it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from math import ceil, floor
from typing import NamedTuple

from pirate_sm.core.documents import Path
from pirate_sm.core.documents import Place as FilePlace
from pirate_sm.core.geometry import Place, span_m
from pirate_sm.core.loading import LoadedRobot, reach
from pirate_sm.core.models import (
    Board,
    Duty,
    HeldTorque,
    Level,
    Profile,
    Share,
    Slot,
    Speed,
    Stage,
    Target,
)
from pirate_sm.core.units import in_degrees
from pirate_sm.views.drawing.canvas import ACROSS, DOWN, Canvas
from pirate_sm.views.drawing.wrapping import wrapped

Faults = Mapping[FilePlace, str]
"""What is wrong with a robot, by its place in the files."""

WRONG = "✗"
SCALE = "To scale, in a pipe of {:.0f} mm inner diameter."
LEGEND = (
    "The front is to the right, side A up. Of states in normal polarity: → ← drives the robot "
    "forward, backward; ↑ ↓ presses the joint's wheel to side A, B; an angle is turned to, and a "
    "negative one turns the body ahead of a joint to side A; ↺ turns what is ahead of a roll joint "
    "counter-clockwise, looking ahead."
)
_SHARE_OF_REACH = 0.6
"""How far from the smallest to the largest pipe that it can clamp the drawn one is [decided]."""

_WIDTH, _LABEL = 80, 28
"""Columns of the drawing in text, and those of them for the names of states [decided]."""


class SlotPlace(NamedTuple):
    """A slot, where it is on the wire and in the profile, and its column in the drawing.

    The column of a wheel or a joint is the number of its node, counted from 0 at the front; that of
    a roll joint is between two nodes.
    """

    slot: Slot
    board: Board
    number: int
    path: Path
    column: float

    @property
    def lines(self) -> list[str]:
        """Return its own name, where it is on the wire, and whether it is missing."""
        name = [] if self.slot.name == self.slot.drives else [self.slot.name]
        missing = [] if self.board.fitted else ["not fitted"]
        return [*name, f"board {self.board.id} slot {self.number}", *missing]


class StageRow(NamedTuple):
    """What a stage of a state writes, by columns; a row without cells is a heading."""

    name: str
    cells: Mapping[float, str]


class SideView(NamedTuple):
    """All that is drawn.

    Attributes:
        profile: The robot's profile.
        diameter_m: Inner diameter of the pipe in which it is clamped.
        places: Where its wheels are there: x ahead, and y from the middle of the pipe to side A.
        slots: What each slot drives; lights and the like are not there.
        pressed: The arrow at each joint that is driven in the state that holds most parts.
        rows: The positive setpoints, then the states.
        bad_wheels: The wheels of which, or of whose joint or slots, something is wrong.
        notes: What is wrong, in words.
    """

    profile: Profile
    diameter_m: float
    places: tuple[Place, ...]
    slots: tuple[SlotPlace, ...]
    pressed: Mapping[float, str]
    rows: tuple[StageRow, ...]
    bad_wheels: frozenset[int]
    notes: tuple[str, ...]

    def at(self, column: float) -> float:
        """Return where a column is along the pipe, m."""
        return (self.places[floor(column)][0] + self.places[ceil(column)][0]) / 2


def side_view(robot: LoadedRobot, faults: Faults | None = None) -> SideView:
    """Return the view of a robot; what is wrong with it is marked where it is drawn."""
    faults, profile = faults or {}, robot.profile
    least, largest = reach(profile)
    diameter_m = least + _SHARE_OF_REACH * (largest - least)
    view = _Reader(robot, faults, tuple(_slots(profile)))
    return SideView(
        profile,
        diameter_m,
        tuple(_places(profile, diameter_m)),
        view.slots,
        view.pressed(),
        tuple(view.rows()),
        frozenset(view.bad_wheels()),
        tuple(f"{WRONG} {place}: {message}" for place, message in faults.items()),
    )


def _places(profile: Profile, diameter_m: float) -> Iterator[Place]:
    """Yield where each wheel is if it touches the wall of its direction."""
    body, x = profile.body, 0.0
    aside = diameter_m / 2 - body.wheel_radius
    sides = [wheel.direction * aside for wheel in body.wheels]
    yield x, sides[0]
    for link, (ahead, behind) in zip(body.links, pairwise(sides), strict=True):
        x -= span_m(link.length, ahead - behind)
        yield x, behind


def _slots(profile: Profile) -> Iterator[SlotPlace]:
    body = profile.body
    columns: dict[str, float] = {each.name: n for n, each in enumerate(body.wheels)}
    columns |= {joint.name: columns[joint.wheel] for joint in body.joints}
    columns |= {each.roll: n + 0.5 for n, each in enumerate(body.links) if each.roll}
    for place, board in enumerate(profile.boards):
        for number, slot in enumerate(board.slots):
            if slot.drives:
                path = ("boards", place, "slots", number)
                yield SlotPlace(slot, board, number, path, columns[slot.drives])


class _Reader(NamedTuple):
    robot: LoadedRobot
    faults: Faults
    slots: tuple[SlotPlace, ...]

    def is_wrong(self, path: Path, keys: Sequence[str] = ()) -> bool:
        document = self.robot.documents[0]
        paths = (path, *((*path, key) for key in keys))
        return any(document.place_of(each) in self.faults for each in paths)

    def bad_wheels(self) -> Iterator[int]:
        body = self.robot.profile.body
        wheels = [each.name for each in body.wheels]
        for number, wheel in enumerate(body.wheels):
            if self.is_wrong(("body", "wheels", number), list(type(wheel).model_fields)):
                yield number
        for number, joint in enumerate(body.joints):
            if self.is_wrong(("body", "joints", number), list(type(joint).model_fields)):
                yield wheels.index(joint.wheel)
        for each in self.slots:
            if self.is_wrong(each.path, list(Slot.model_fields)):
                yield floor(each.column)

    def rows(self) -> Iterator[StageRow]:
        slots = sorted(self.slots, key=lambda each: not each.slot.wheel)
        ones = ((each, Duty(1.0) if each.slot.unit == "duty" else None) for each in slots)
        positive = _joined((each.column, self._text(each, value)) for each, value in ones)
        yield StageRow("positive setpoint", positive)
        for region, states in self.robot.profile.actuation.items():
            rows = [
                StageRow("  " + (f"{state}, stage {n + 1}" if n else state), cells)
                for state, stages in states.items()
                for n in range(len(stages))
                if (cells := self._cells(region, state, n)) and set(cells.values()) != {"0"}
            ]
            if rows:
                yield StageRow(region, {})
                yield from rows

    def pressed(self) -> Mapping[float, str]:
        """Return the last arrow of each joint in the configuration that holds most parts."""
        spec = self.robot.normal
        most = max(range(len(spec.held)), key=lambda each: len(spec.held[each]))
        found: dict[float, str] = {}
        states = zip(spec.regions, self.robot.table.configurations[most], strict=True)
        for region, state in states:
            for n in range(len(self.robot.profile.actuation[region][state])):
                cells = self._cells(region, state, n)
                found |= {c: text for c, text in cells.items() if text[0] in "↑↓"}
        return found

    def _cells(self, region: str, state: str, stage: int) -> dict[float, str]:
        stages: Sequence[Stage] = self.robot.profile.actuation[region][state]
        at: Path = ("actuation", region, state, *([stage] if len(stages) > 1 else ()))
        by_name = {each.slot.name: each for each in self.slots}
        return _joined(
            (
                by_name[name].column,
                self._text(by_name[name], value) + WRONG * self.is_wrong((*at, name)),
            )
            for name, value in stages[stage].items()
            if name in by_name
        )

    def _text(self, place: SlotPlace, value: object) -> str:
        """Return the arrow or the angle of a setpoint; None is a positive angle."""
        match value:
            case Duty(sign) | Speed(sign) | HeldTorque(sign):
                if not sign:
                    return "0"
                if not place.slot.wheel:
                    return "↑" if sign > 0 else "↓"
                direction = self.robot.profile.body.wheels[floor(place.column)].direction
                return "→" if sign * direction > 0 else "←"
            case Target(angle_rad):
                return in_degrees(angle_rad)
            case Share(factor):
                return f"{factor:g}×"
            case Level(angle_rad):
                return f"level {in_degrees(angle_rad)}"
            case None:
                return "↺" if place.slot.roll else "+"
            case _:
                return "keep"


def _joined(cells: Iterator[tuple[float, str]]) -> dict[float, str]:
    """Return one text per column: a wheel and its joint share one."""
    found: dict[float, str] = {}
    for column, text in cells:
        found[column] = f"{found[column]} {text}" if column in found else text
    return found


# --- in text -----------------------------------------------------------------------------------


def side_text(view: SideView) -> str:
    """Return the view as text of 80 columns: the robot to scale, and a line for each state."""
    body = view.profile.body
    length_m = -view.places[-1][0] + 2 * body.wheel_radius
    scale = (_WIDTH - _LABEL - 2) * ACROSS / length_m
    rows = round(view.diameter_m * scale / DOWN) + 2
    canvas = Canvas(_WIDTH, rows)
    middle = rows * DOWN / 2

    def at(x: float) -> float:
        return (_WIDTH - 2) * ACROSS + (x - body.wheel_radius) * scale

    for side, name in ((1, "A"), (-1, "B")):
        y = middle - side * (view.diameter_m / 2 * scale + 1)
        canvas.line(_LABEL * ACROSS, y, canvas.width - 2 * ACROSS, y, "")
        canvas.write(canvas.width - ACROSS, y, name, "")
    spots = [(at(x), middle - y * scale) for x, y in view.places]
    for (x0, y0), (x1, y1) in pairwise(spots):
        canvas.line(x0, y0, x1, y1, "")
    for number, (x, y) in enumerate(spots):
        canvas.erase(x, y, body.wheel_radius * scale)
        canvas.circle(x, y, body.wheel_radius * scale, "")
        mark = WRONG if number in view.bad_wheels else ""
        canvas.write(x, y, f"{number + 1}{mark}", "")
    lines = ["".join(text for text, _ in runs).rstrip() for runs in canvas.runs()]
    for row in view.rows:
        line = f"{row.name:<{_LABEL}}"
        for column, text in sorted(row.cells.items(), reverse=True):
            middle_at = round(at(view.at(column)) / ACROSS) - len(text) // 2
            line = f"{line:<{middle_at}}{' ' * (len(line) >= middle_at > _LABEL)}{text}"
        lines.append(line.rstrip())
    notes = (f"{SCALE.format(view.diameter_m * 1e3)} {LEGEND}", *view.notes)
    return "\n".join([*lines, "", *(each for note in notes for each in wrapped(note, _WIDTH))])
