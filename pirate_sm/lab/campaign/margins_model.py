"""How far a mission holds: what a campaign says of the factors that are changed for it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from math import pi
from typing import Annotated, Any, Literal, NamedTuple, TypeAlias

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from pirate_sm.core.fields import AlsoWritten, Count, Frozen, Ratio, kind_fault
from pirate_sm.lab.campaign.sequential import MOST_RUNS, SequentialTest

_BOUND = re.compile(r"(>=|<=)\s*(\S.*)")
_FACTOR = re.compile(r"[A-Za-z_][\w.]*(?::\w+)?")


_DIGITS = 4
"""Significant digits of a value, as the command that repeats its runs has it."""

READ_IN = {"rad": "deg", "m": "mm"}
_SCALES = {"deg": pi / 180, "mm": 1e-3}
"""Units in which people read what is in rad and m, and how much one of them is."""


@dataclass(frozen=True)
class MarginFactor:
    """A factor, and the range in which it is changed.

    Attributes:
        name: As campaigns have it.
        unit: In which people read it; empty for a share.
        low: The least value, in SI units; likewise ``high``.
        nominal: The value of the cell itself: of a defect that is not there, the end of the range
            at which it does least.
        added: Whether the cell lacks the defect, and has it with the nominal value, too: that is
            a change to be run.
    """

    name: str
    unit: str
    low: float
    high: float
    nominal: float
    added: bool = False

    def rounded(self, value: float) -> float:
        """Return a value as it is written in an order."""
        scale = _SCALES.get(self.unit, 1.0)
        return float(f"{value / scale:.{_DIGITS}g}") * scale

    def shown(self, value: float) -> float:
        """Return a value in the unit in which people read it."""
        return float(f"{value / _SCALES.get(self.unit, 1.0):.{_DIGITS}g}")

    def written(self, value: float) -> str:
        """Return a value as text with its unit."""
        return f"{self.shown(value):g} {self.unit}".strip()

    def between(self, share: float) -> float:
        """Return the value at a share of the way: -1 is ``low``, 0 nominal, 1 ``high``."""
        end = self.high if share > 0.0 else self.low
        return self.nominal + abs(share) * (end - self.nominal)


class MarginBound(NamedTuple):
    """A wanted margin: the mission holds from the nominal value to this one.

    Attributes:
        side: ``>=``: down to the value; ``<=``: up to it.
        text: The value as it is written, with its unit.
    """

    side: Literal[">=", "<="]
    text: str


def _read_bounds(value: Any) -> tuple[MarginBound, ...]:
    """Return the bounds of `>= 0.35`, or of a list of two."""
    listed = value if isinstance(value, list | tuple) else [value]
    found: list[MarginBound] = []
    for one in listed:
        each: Any = " ".join(map(str, one)) if isinstance(one, list) else one  # as stored
        match = None if isinstance(each, MarginBound) else _BOUND.fullmatch(str(each))
        if match is None and not isinstance(each, MarginBound):
            raise kind_fault(f"expected a bound such as '>= 0.35' or '<= 10 deg', got '{each}'")
        found.append(each if match is None else MarginBound(match[1], match[2]))  # type: ignore[arg-type]
    return tuple(found)


def _read_range(value: Any) -> tuple[str, str] | None:
    """Return the two ends of `0.1..0.9` as text; None of `usual`."""
    if value in (None, "usual"):
        return None
    if isinstance(value, list | tuple):  # as stored with results
        value = "..".join(map(str, value))
    low, dots, high = map(str.strip, str(value).partition(".."))
    if not (dots and low and high):
        raise kind_fault(f"expected `usual`, or a range such as 0.1..0.9, got '{value}'")
    return low, high


def _read_factors(value: Any) -> Any:
    """Return factors by name; a list has those with their default ranges."""
    named = dict.fromkeys(value) if isinstance(value, list | tuple) else value
    for name in named if isinstance(named, dict) else ():
        if not _FACTOR.fullmatch(str(name)):
            raise kind_fault(f"'{name}' is not a factor, such as friction or stiff_joint:friction")
    return named


_RANGE = WithJsonSchema(
    {
        "type": ["string", "null"],
        "description": "From where to where it is changed, with units; `usual`.",
        "examples": ["0.1..0.9", "usual"],
    }
)
Range: TypeAlias = Annotated[tuple[str, str] | None, BeforeValidator(_read_range), _RANGE]
Bounds: TypeAlias = Annotated[
    tuple[MarginBound, ...],
    BeforeValidator(_read_bounds),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "string", "pattern": f"^{_BOUND.pattern}$"},
                {"type": "array", "items": {"type": "string"}, "minItems": 1, "maxItems": 2},
            ],
            "description": "How far it must hold: down to a value, or up to one.",
            "examples": [">= 0.35", [">= -5 deg", "<= 5 deg"]],
        }
    ),
]


class Margins(Frozen):
    """How far each cell of a campaign holds: its factors are changed, one by one, until it fails.

    Attributes:
        share: A value of a factor counts as held if at least this share of the runs passes there.
        factors: What is changed, from where to where: `friction`, `diameter`, `tilt`, `roll` and
            `start` of the pipe, numbers of a twin such as `motors.bend.stall_torque`, or numbers
            of a defect, `stiff_joint:friction`; `each:after` is every defect that takes it.
            Without it, a choice of these.
        pairs: Pairs of these factors, of which a map is made.
        expects: How far it must hold; else the campaign fails.
        runs: The most runs at one value.
        levels: Values at equal distances that are tried on each side, first.
        halvings: How often the distance to the first value at which it does not hold is halved.
    """

    share: Annotated[Ratio, Field(gt=0, lt=1)] = 0.9
    factors: Annotated[
        dict[str, Range],
        BeforeValidator(_read_factors),
        AlsoWritten(lambda usual: [{"type": "array", "items": {"type": "string"}}]),
    ] = {}
    pairs: tuple[tuple[str, str], ...] = ()
    expects: dict[str, Bounds] = {}
    runs: Annotated[Count, Field(ge=10, le=MOST_RUNS)] = 200
    levels: Annotated[Count, Field(ge=1, le=50)] = 4
    halvings: Annotated[Count, Field(ge=0, le=10)] = 3

    def test(self, confidence: float) -> SequentialTest:
        """Return the test of a value, such that the edge of a side is as sure as this."""
        return SequentialTest(self.share, (1.0 - confidence) / (1 + self.halvings), self.runs)

    def cannot_end(self, confidence: float) -> str:
        """Return why `runs` are too few for any value to hold, or to fail; empty: they are not."""
        least = self.test(confidence).least
        if least <= self.runs:
            return ""
        way = f"give at least {least:,}" if least <= MOST_RUNS else "ask for another share"
        return (
            f"`runs`: with {self.runs:,} runs no value can be sure enough to hold, or to fail, "
            f"at a share of {100 * self.share:.12g} %, which takes {least:,}: {way}"
        )

    @model_validator(mode="after")
    def _names_factors(self) -> Margins:
        wanted = {*self.expects, *(name for pair in self.pairs for name in pair)}
        if self.factors and (wrong := sorted(wanted - self.factors.keys())):
            raise ValueError(f"'{wrong[0]}' is none of the `factors`")
        for first, second in self.pairs:
            if first == second:
                raise ValueError(f"a pair has '{first}' twice")
        return self
