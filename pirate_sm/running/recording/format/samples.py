"""Samples of a run in a recording without messages for viewers: where the wheels were, and when.

Everything else that viewers are shown follows from the engine's inputs. A message is a batch of
samples, column by column. Its times are those at which a run in real time shows itself to viewers,
so that the messages can be made later as they would have been made then.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from math import isfinite
from typing import Any, Final, NamedTuple

from pydantic_core import to_json

from pirate_sm.core.geometry import Place
from pirate_sm.core.simulation import InSpace, Rows
from pirate_sm.running.recording.format.engine_topics import DIALECT, ENGINE
from pirate_sm.running.recording.format.json_values import JsonSchema

SAMPLES: Final = f"{ENGINE}samples"
"""The topic of the samples."""

SCHEMA_NAME: Final = f"pirate_sm{SAMPLES.replace('/', '.')}"

SCHEMA: Final[JsonSchema] = {
    "$schema": DIALECT,
    "title": SCHEMA_NAME,
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
        known: Whether it is a simulator's true position; else it is reckoned.
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
    """Return a batch of samples as JSON; a position that is no number is unknown."""
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


def _finite(rows: Rows) -> Rows:
    if isfinite(sum(map(sum, rows))):
        return rows
    return [row if isfinite(sum(row)) else () for row in rows]


def _space_of(values: Sequence[float], wheels: int) -> InSpace | None:
    """Return what a robot in space has beside its places; None if that is unknown."""
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
