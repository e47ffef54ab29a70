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

from pirate_sm.geometry.space import Place
from pirate_sm.recording.format.engine_topics import DIALECT, ENGINE
from pirate_sm.recording.format.json_values import JsonSchema

SAMPLES: Final = f"{ENGINE}samples"
"""The topic of the samples."""

SCHEMA_NAME: Final = f"pirate_sm{SAMPLES.replace('/', '.')}"

SCHEMA: Final[JsonSchema] = {
    "$schema": DIALECT,
    "title": SCHEMA_NAME,
    "description": (
        "A batch of samples, column by column: where the wheels were.\n"
        "Column places_m: for each sample x and y of each wheel in turn, in the plane of the pipe, "
        "m; an empty array where they were unknown."
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
    """

    at_s: float
    known: bool
    wheels: Sequence[Place]


class PlacesSample(NamedTuple):
    """A sample as it is kept until it is written.

    Attributes:
        at_s: Its time, s.
        known: As in :class:`Placed`.
        places_m: Its entry in the column of this name.
    """

    at_s: float
    known: bool
    places_m: tuple[float, ...]


def places_sample(at_s: float, known: bool, wheels: Sequence[Place]) -> PlacesSample:
    """Return the sample of these positions."""
    return PlacesSample(at_s, known, tuple(chain.from_iterable(wheels)))


def encode_samples(samples: Sequence[PlacesSample]) -> bytes:
    """Return a batch of samples as JSON; a position that is no number is unknown."""
    times_s, known, places_m = zip(*samples, strict=True)
    finite = [each if isfinite(sum(each)) else () for each in places_m]
    return to_json({"t_s": times_s, "known": known, "places_m": finite})


def decode_samples(batch: dict[str, Any]) -> Iterator[Placed]:
    """Yield the samples of a batch."""
    for at_s, known, places in zip(batch["t_s"], batch["known"], batch["places_m"], strict=True):
        values = iter(places)
        yield Placed(at_s, known, rounded(tuple(zip(values, values, strict=True))))


def rounded(wheels: Sequence[Place]) -> tuple[Place, ...]:
    """Return the positions with nine digits, as viewers are shown them."""
    return tuple((float(f"{x:.9g}"), float(f"{y:.9g}")) for x, y in wheels)
