"""Samples of a run in a recording without messages for viewers: where the wheels were, and when.

Everything else that viewers are shown follows from the engine's inputs. A message is a batch of
samples, column by column. Its times are those at which a run in real time shows itself to viewers,
so that the messages can be made later as they would have been made then.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from itertools import chain
from typing import Any, Final, NamedTuple

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


class SampleText(NamedTuple):
    """A sample as it is written.

    Attributes:
        at_s: Its time, s.
        known: As in :class:`Placed`.
        places: Its entry in the column ``places_m``.
    """

    at_s: float
    known: bool
    places: str


def rounded(wheels: Sequence[Place]) -> tuple[Place, ...]:
    """Return the positions with nine digits, as a recording has them."""
    return tuple((float(f"{x:.9g}"), float(f"{y:.9g}")) for x, y in wheels)


def sample_text(at_s: float, known: bool, wheels: Sequence[Place]) -> SampleText:
    """Return the sample as it is written; positions have nine digits."""
    text = _layout(len(wheels)) % (*chain.from_iterable(wheels),)
    return SampleText(at_s, known, "[]" if "n" in text else text)  # JSON has no nan and no inf


@cache
def _layout(wheels: int) -> str:
    return f"[{','.join(['%.9g,%.9g'] * wheels)}]"


def encode_samples(samples: Sequence[SampleText]) -> bytes:
    """Return a batch of samples as JSON."""
    times = ",".join([repr(each.at_s) for each in samples])
    known = ",".join(["true" if each.known else "false" for each in samples])
    places = ",".join([each.places for each in samples])
    return f'{{"t_s":[{times}],"known":[{known}],"places_m":[{places}]}}'.encode()


def decode_samples(batch: dict[str, Any]) -> Iterator[Placed]:
    """Yield the samples of a batch."""
    for at_s, known, places in zip(batch["t_s"], batch["known"], batch["places_m"], strict=True):
        values = iter(places)
        yield Placed(at_s, known, tuple(zip(values, values, strict=True)))
