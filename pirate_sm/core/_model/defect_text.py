"""The text of a defect, as options, files and Python write it: its numbers and what they mean.

A defect is written ``stiff_joint:friction=0.9Nm,after=2s``, its name and its numbers, which replace
those of the profile. A range, ``after=2s..20s``, is drawn uniformly from the seed of the run, which
shows and records the number that was drawn. Files and Python may write a mapping:
``{defect: stiff_joint, after: 2 s}``.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import Final, NamedTuple

from pirate_sm.core.units import DIMENSIONLESS, TIME, TORQUE, Dimension


class DefectKey(NamedTuple):
    """A number that a defect takes.

    Attributes:
        meaning: What it is, in words.
        dimension: Its dimension; None: that of the affected signals.
        most: Its largest value. Numbers with a dimension of their own are at least 0.
    """

    meaning: str
    dimension: Dimension | None = None
    most: float = inf


DEFECT_KEYS: Final[Mapping[str, DefectKey]] = {
    "after": DefectKey("when it begins, from the start of the run", TIME),
    "every": DefectKey("mean time between two occurrences", TIME),
    "lasting": DefectKey("how long one occurrence lasts", TIME),
    "friction": DefectKey("dry friction of a stiff joint, drag of a dead wheel", TORQUE),
    "share": DefectKey("share of lost messages", DIMENSIONLESS, 0.5),
    "by": DefectKey("how far the zero jumps"),
    "shows": DefectKey("what the sensor shows"),
}
_SPELLS: Final = ("after", "every", "lasting")
_TAKES: Final[Mapping[str, tuple[str, ...]]] = {
    "dead_wheel": ("friction", "after"),
    "stiff_joint": ("friction", "after"),
    "sensor_stuck": ("shows", *_SPELLS),
    "sensor_drop": ("shows", *_SPELLS),
    "sensor_spike": ("shows", *_SPELLS),
    "zero_jump": ("by", "after", "every"),
    "lost_messages": ("share", *_SPELLS),
    "firmware_reset": ("after", "every"),
    "stray_motion": ("after", "every"),
}


def keys_of_defect(kind: str) -> tuple[str, ...]:
    """Return the names of the numbers that a kind of defect takes."""
    return _TAKES.get(kind, _SPELLS)


def defect_as_text(written: object) -> object:
    """Return a defect that is written as a mapping as text; anything else as it is."""
    if not (isinstance(written, Mapping) and isinstance(written.get("defect"), str)):
        return written
    pairs = [f"{key}={value}".replace(" ", "") for key, value in written.items() if key != "defect"]
    return f"{written['defect']}:{','.join(pairs)}" if pairs else written["defect"]
