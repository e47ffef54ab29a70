"""Where parts of the robot are in the legs of a map, and the bend that it is in."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan
from typing import NamedTuple

from pirate_sm.core.geometry import Frame


class Anchor(NamedTuple):
    """A part whose place is known.

    Attributes:
        part: Its index.
        axis: The axis of its leg, at the middle of the wheels that show it.
        along_m: Place of that in the leg.
        whole: Whether all its wheels show the axis, or its outermost link alone.
    """

    part: int
    axis: Frame
    along_m: float
    whole: bool


class Spot(NamedTuple):
    """Where a held part is.

    Attributes:
        leg: Index of its leg.
        along_m: Place in the leg of the middle of the wheels.
        wheels: These wheels: the part's, or the two of its outermost link.
    """

    leg: int
    along_m: float
    wheels: tuple[int, ...]


@dataclass
class Approach:
    """A joint ahead, by the words that announced it.

    Attributes:
        leg: Index of the leg behind it.
        leads: The direction of travel.
        begins_m: Where it begins, in that leg.
        ends_m: Where it ends, had the leg gone on round it; NaN before a word says so.
    """

    leg: int
    leads: int
    begins_m: float
    ends_m: float = nan


@dataclass
class BendPassage:
    """A bend that the robot is in.

    Attributes:
        bend: Index of the bend.
        leads: 1 if the front part has gone first, -1 if the rear part has.
        first: The part that has gone first.
        anchor: The part that lay along the leg behind then; it comes last.
        numbers: The signals then.
        new: Whether the bend was not known before.
        placed: Whether the part that comes last has given the place of the other one.
        passed: Whether a word says that the whole robot is behind it.
    """

    bend: int
    leads: int
    first: int
    anchor: Anchor
    numbers: tuple[float, ...]
    new: bool
    placed: bool = False
    passed: bool = False

    @property
    def last(self) -> int:
        """Return the part that comes last."""
        return self.anchor.part
