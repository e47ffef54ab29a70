"""Topics, JSON Schemas and batches for all inputs and outputs of the engine, and for samples.

They are derived field by field from the closed sets of events and effects. A new event or effect
needs no change here unless a field has a new type.

A message is a batch of rows, column by column. ``step`` numbers the engine's inputs from 0
without a gap; ``t_s`` is the time since the run began. An effect has the number of the step that
caused it, and ``nth``, its index among the effects of that step, from 0.

Samples, where the wheels were and when, are in recordings without messages for viewers. Everything
else that viewers are shown follows from the engine's inputs. Their times are those at which a run
in real time shows itself to viewers, so that the messages can be made later as they would have
been made then.
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import chain
from math import isfinite
from typing import Any, ClassVar, Final, NamedTuple, TypeAlias, get_args, get_type_hints

from pydantic_core import to_json

from pirate_sm.core import effects as fx
from pirate_sm.core import events
from pirate_sm.core.events import InSpace
from pirate_sm.core.geometry import Place
from pirate_sm.running.recording.format.json_values import (
    NUMBER,
    WHOLE,
    JsonKind,
    JsonSchema,
    kind_of,
)

# --- topics of the engine -------------------------------------------------------------------------


ENGINE = "/engine/"
"""Prefix of the engine's topics; all others are for viewers."""

IN, OUT = f"{ENGINE}in/", f"{ENGINE}out/"
DIALECT = "https://json-schema.org/draft/2020-12/schema"

_TIME = replace(NUMBER, schema={"type": "number"})
_UNITS = {"duty": "duty", "angle": "rad"}


class Started(NamedTuple):
    """The engine has started; it was shown what the sensors had said before this.

    Attributes:
        paused: Whether the operator had the robot first.
        body: What an earlier mission had commanded the robot to, as JSON; empty without one.
        resumed: What an interrupted mission resumes with, as JSON; empty if none does.
    """

    paused: bool = False
    body: str = ""
    resumed: str = ""


class Abandoned(NamedTuple):
    """The engine is no longer asked; the effects are those of the program around it."""


class Remembered(NamedTuple):
    """What the engine remembered after a step: from there on it can be executed again.

    Attributes:
        state: Its state as JSON.
    """

    state: str


class Unlogged(NamedTuple):
    """A command's first array was submitted before the step that gave it was on the disk.

    Attributes:
        waited_s: How long the run had waited for the disk.
    """

    waited_s: float


Input: TypeAlias = events.Event | Started | Abandoned


_INPUTS, _EFFECTS = frozenset(get_args(Input)), frozenset(get_args(fx.Effect))


class WireLayout(NamedTuple):
    """The boards and setpoints of a robot.

    Attributes:
        boards: Names of the channels of each board, by its id.
        slots: Name and unit, ``duty`` or ``angle``, of each setpoint.
    """

    boards: dict[int, tuple[str, ...]]
    slots: tuple[tuple[str, str], ...]


@dataclass(frozen=True, eq=False)
class Topic:
    """One topic of the engine.

    Attributes:
        name: Name of the topic.
        made: The type of its rows.
        fields: Name and encoding of each field.
        spread: Index of the field whose numbers have a name each; -1 without.
        names: These names.
        board: The board, for a topic of its frames.
    """

    name: str
    made: type[Any]
    fields: tuple[tuple[str, JsonKind], ...]
    spread: int = -1
    names: tuple[str, ...] = ()
    board: int | None = None

    @cached_property
    def is_input(self) -> bool:
        """Whether the rows are inputs of the engine."""
        return self.name.startswith(IN)

    @cached_property
    def keys(self) -> tuple[str, ...]:
        """Return the columns of every row."""
        return ("step", "t_s", "nth") if self.name.startswith(OUT) else ("step", "t_s")

    @cached_property
    def schema(self) -> JsonSchema:
        """Return the JSON Schema of a batch.

        Viewers know only arrays of one plain type; Lichtblick drops a topic with any other
        column. Columns that may hold ``null`` (unknown), ``"inf"`` or arrays are therefore
        described in words.
        """
        described = inspect.cleandoc(self.made.__doc__ or "")
        kinds = {key: _TIME if key == "t_s" else WHOLE for key in self.keys} | dict(self.fields)
        plain = {name: kind.schema for name, kind in kinds.items() if kind.schema is not None}
        others = [
            f"Column {name}: {kind.words}." for name, kind in kinds.items() if not kind.schema
        ]
        if self.spread >= 0:
            others.append(f"It is an object of columns: {', '.join(self.names)}.")
        return {
            "$schema": DIALECT,
            "title": self.schema_name,
            "description": "\n".join([f"A batch of rows, column by column. {described}", *others]),
            "type": "object",
            "properties": {name: {"type": "array", "items": each} for name, each in plain.items()},
            "required": list(kinds),
        }

    @cached_property
    def schema_json(self) -> bytes:
        """Return the JSON Schema as it is written."""
        return json.dumps(self.schema, allow_nan=False).encode()

    @cached_property
    def schema_name(self) -> str:
        """Return the name of the schema in the file."""
        return "pirate_sm" + self.name.replace("/", ".")

    def encode(self, rows: Sequence[tuple[Any, ...]]) -> bytes:
        """Return the batch as JSON.

        Args:
            rows: For each row the values of ``keys``, then the event or effect.
        """
        *first, made = zip(*rows, strict=True)
        columns: dict[str, Any] = dict(zip(self.keys, first, strict=True))
        if self.fields:
            for (name, _), column in zip(self.fields, zip(*made, strict=True), strict=True):
                columns[name] = column
        if self.spread >= 0:
            name = self.fields[self.spread][0]
            columns[name] = dict(zip(self.names, zip(*columns[name], strict=True), strict=True))
        return self._encoded(columns)

    def encode_frames(
        self, steps: Sequence[int], times_s: Sequence[float], channels: Sequence[Sequence[float]]
    ) -> bytes:
        """Return a batch of a board's frames as JSON, as :meth:`encode` does.

        Args:
            steps: Number of the step of each frame.
            times_s: Time of each frame, s.
            channels: For each channel the values in all frames.
        """
        (board, _), (values, _) = self.fields
        named = dict(zip(self.names, channels, strict=True))
        boards = [self.board] * len(steps)
        return self._encoded({"step": steps, "t_s": times_s, board: boards, values: named})

    def _encoded(self, columns: dict[str, Any]) -> bytes:
        with suppress(ValueError):  # invalid Unicode
            data = to_json(columns)  # three times as fast as the standard library
            if b"NaN" not in data and b"Infinity" not in data:
                return data
        try:
            return _json(columns)
        except ValueError:  # JSON has neither NaN nor infinities
            return _json(self._spelled(columns))

    def _spelled(self, columns: dict[str, Any]) -> dict[str, Any]:
        spelled = dict(columns)
        for number, (name, kind) in enumerate(self.fields):
            if number == self.spread:
                each = columns[name].items()
                spelled[name] = {key: list(map(NUMBER.encode, column)) for key, column in each}
            else:
                spelled[name] = list(map(kind.encode, columns[name]))
        return spelled

    def decode(self, data: bytes) -> Iterator[tuple[int, float, int, Any]]:
        """Yield step, time, index and content of each row.

        Raises:
            ValueError: The batch does not fit the schema.
        """
        batch = json.loads(data)
        try:
            columns: list[Sequence[Any]] = [
                self._decoded(batch, number, name, kind)
                for number, (name, kind) in enumerate(self.fields)
            ]
            steps, times = batch["step"], [NUMBER.decode(at) for at in batch["t_s"]]
            places = batch["nth"] if "nth" in self.keys else [0] * len(steps)
            made = zip(*columns, strict=True) if columns else [()] * len(steps)
            for step, at_s, place, values in zip(steps, times, places, made, strict=True):
                yield WHOLE.decode(step), at_s, WHOLE.decode(place), self.made(*values)
        except (KeyError, TypeError, AttributeError) as error:
            raise ValueError(f"{self.name}: {error!r}") from None

    def _decoded(
        self, batch: dict[str, Any], number: int, name: str, kind: JsonKind
    ) -> Sequence[Any]:
        """Return a column; a field that an older alphabet does not have gets its default."""
        if name not in batch and name in self.made._field_defaults:
            return [self.made._field_defaults[name]] * len(batch["step"])
        column = batch[name]
        if number != self.spread:
            return list(map(kind.decode, column))
        each = [map(NUMBER.decode, column[name]) for name in self.names]
        return list(zip(*each, strict=True))


class Topics:
    """Every topic of a robot with this layout, made when it is needed first by any run."""

    _plain: ClassVar[dict[type[Any], Topic]] = {}

    def __init__(self, layout: WireLayout) -> None:
        self._frames = {
            board: _frames(board, names) for board, names in layout.boards.items() if names
        }
        self._setpoints = _setpoints(layout.slots)

    @cached_property
    def by_name(self) -> dict[str, Topic]:
        """Return all topics by their names."""
        plain = (self._of(made) for made in (*_INPUTS, *_EFFECTS))
        return {topic.name: topic for topic in (*plain, *self._frames.values(), self._setpoints)}

    @property
    def channels(self) -> dict[int, int]:
        """Return the number of channels of each board whose frames have a topic of their own."""
        return {board: len(topic.names) for board, topic in self._frames.items()}

    def of_input(self, event: Input) -> Topic:
        """Return the topic of an event."""
        if type(event) is events.SensorFrame:
            named = self._frames.get(event.board)
            if named is not None and len(named.names) == len(event.values):
                return named
        return self._plain.get(type(event)) or self._of(type(event))

    def of_frames(self, board: int) -> Topic:
        """Return the topic of a board's frames.

        Raises:
            KeyError: The robot has no such board, or it has no channels.
        """
        return self._frames[board]

    def of_effect(self, effect: fx.Effect) -> Topic:
        """Return the topic of an effect."""
        if isinstance(effect, fx.Setpoints) and len(effect.values) == len(self._setpoints.names):
            return self._setpoints
        return self._plain.get(type(effect)) or self._of(type(effect))

    def _of(self, made: type[Any]) -> Topic:
        """Return the topic of a type of events or effects.

        Raises:
            KeyError: There is no such type.
        """
        if made not in self._plain:
            if made not in _INPUTS | _EFFECTS:
                raise KeyError(made)
            self._plain[made] = _topic(IN if made in _INPUTS else OUT, made)
        return self._plain[made]


def _topic(where: str, made: type[Any]) -> Topic:
    return Topic(where + made.__name__, made, _fields(made))


def _fields(made: type[Any]) -> tuple[tuple[str, JsonKind], ...]:
    return tuple((name, kind_of(hint)) for name, hint in get_type_hints(made).items())


STATE: Final = Topic(f"{ENGINE}state", Remembered, _fields(Remembered))
"""Checkpoints, see :mod:`pirate_sm.running.recording.format.json_values`."""

UNLOGGED: Final = Topic(f"{ENGINE}unlogged", Unlogged, _fields(Unlogged))
"""Steps whose command may be missing in a recording that ends soon after."""


@lru_cache(maxsize=256)
def _frames(board: int, channels: tuple[str, ...]) -> Topic:
    names = _distinct([f"{name}_raw" for name in channels])
    made = events.SensorFrame
    return Topic(f"{IN}{made.__name__}/{board}", made, _fields(made), 1, names, board)


@lru_cache(maxsize=16)
def _setpoints(slots: tuple[tuple[str, str], ...]) -> Topic:
    names = _distinct([f"{name}_{_UNITS[unit]}" for name, unit in slots])
    made = fx.Setpoints
    return Topic(f"{OUT}{made.__name__}/slots", made, _fields(made), 1, names)


def _distinct(names: Sequence[str]) -> tuple[str, ...]:
    """Return the names; a repeated one gets its number as a suffix."""
    return tuple(
        name if name not in names[:number] else f"{name}_{number}"
        for number, name in enumerate(names)
    )


def _json(columns: dict[str, Any]) -> bytes:
    return json.dumps(columns, separators=(",", ":"), allow_nan=False).encode()


# --- samples --------------------------------------------------------------------------------------


SAMPLES: Final = f"{ENGINE}samples"
"""The topic of the samples."""

SAMPLES_SCHEMA_NAME: Final = f"pirate_sm{SAMPLES.replace('/', '.')}"

SAMPLES_SCHEMA: Final[JsonSchema] = {
    "$schema": DIALECT,
    "title": SAMPLES_SCHEMA_NAME,
    "description": (
        "A batch of samples, column by column: where the wheels were.\n"
        "Column places_m: for each sample x and y of each wheel in turn, in the plane of the pipe, "
        "m; an empty array where they were unknown.\n"
        "Column space, of a robot in space: for each sample z of each wheel, m, then the rolls of "
        "joint, front and rear, rad.\n"
        "Column rolls_rad, of a robot in a plane: these rolls for each sample; one entry if all "
        "samples have the same."
    ),
    "type": "object",
    "properties": {
        "t_s": {"type": "array", "items": {"type": "number"}},
        "known": {"type": "array", "items": {"type": "boolean"}},
    },
    "required": ["t_s", "known", "places_m"],
}


class Placed(NamedTuple):
    """Where the wheels were at one time.

    Attributes:
        at_s: The time, s.
        known: Whether it is a simulator's true position; else it is estimated.
        wheels: Position of each wheel in the plane of the pipe, m; empty if unknown.
        space: What they leave out of a robot in space, if known.
        rolls_rad: The same of a robot in a plane: angle of its roll joint, roll of the front and
            of the rear part; empty if unknown.
    """

    at_s: float
    known: bool
    wheels: Sequence[Place]
    space: InSpace | None = None
    rolls_rad: tuple[float, ...] = ()


class PlacesSample(NamedTuple):
    """A sample as it is kept until it is written.

    Attributes:
        at_s: Its time, s.
        known: As in :class:`Placed`.
        places_m: Its entry in the column of this name.
        space: Its entry in the column of this name; empty for a robot in a plane.
        rolls_rad: Its entry in the column of this name; empty for a robot in space.
    """

    at_s: float
    known: bool
    places_m: Sequence[float]
    space: Sequence[float] = ()
    rolls_rad: Sequence[float] = ()


def places_sample(
    at_s: float,
    known: bool,
    wheels: Sequence[Place],
    space: InSpace | None = None,
    rolls_rad: tuple[float, ...] = (),
) -> PlacesSample:
    """Return the sample of these positions; the arguments are those of :class:`Placed`."""
    beyond = () if space is None else (*space.z_m, *space.rolls_rad)
    return PlacesSample(at_s, known, tuple(chain.from_iterable(wheels)), beyond, rolls_rad)


def encode_samples(samples: Sequence[PlacesSample]) -> bytes:
    """Return a batch of samples as JSON; a position that is not a number is unknown."""
    times_s, known, *others = zip(*samples, strict=True)
    places_m, space, rolls_rad = map(_finite, others)
    columns = {"t_s": times_s, "known": known, "places_m": places_m}
    if any(space):
        columns["space"] = space
    if any(rolls_rad):
        stay = rolls_rad.count(rolls_rad[0]) == len(rolls_rad)
        columns["rolls_rad"] = rolls_rad[:1] if stay else rolls_rad
    return to_json(columns)


def decode_samples(batch: dict[str, Any]) -> Iterator[Placed]:
    """Yield the samples of a batch."""
    columns = (batch["t_s"], batch["known"], batch["places_m"])
    count = len(batch["t_s"])
    beyond, rolls = batch.get("space", [()] * count), batch.get("rolls_rad", [()])
    each_roll = rolls * count if len(rolls) == 1 else rolls
    for at_s, known, places, more, rolled in zip(*columns, beyond, each_roll, strict=True):
        values = iter(places)
        wheels = rounded(tuple(zip(values, values, strict=True)))
        yield Placed(at_s, known, wheels, _space_of(more, len(wheels)), _nine_digits(rolled))


def _finite(rows: Sequence[Sequence[float]]) -> Sequence[Sequence[float]]:
    if isfinite(sum(map(sum, rows))):
        return rows
    return [row if isfinite(sum(row)) else () for row in rows]


def _space_of(values: Sequence[float], wheels: int) -> InSpace | None:
    """Return what a robot in space has in addition to its places; None if that is unknown."""
    if not values:
        return None
    digits = _nine_digits(values)
    return InSpace(digits[:wheels], digits[wheels:])


def _nine_digits(values: Sequence[float]) -> tuple[float, ...]:
    """Return the numbers as viewers are shown them."""
    return tuple(float(f"{each:.9g}") for each in values)


def rounded(wheels: Sequence[Place]) -> tuple[Place, ...]:
    """Return the positions with nine digits, as viewers are shown them."""
    return tuple((float(f"{x:.9g}"), float(f"{y:.9g}")) for x, y in wheels)
