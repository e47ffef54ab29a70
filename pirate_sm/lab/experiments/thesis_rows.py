"""The thesis's values beside ours: what a row of an experiment's file says, and its verdict."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from math import isnan
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from pirate_sm.core.profile import Frozen
from pirate_sm.core.quantities import Number
from pirate_sm.core.units import parse_unit

Unjudged = Literal["not reproducible", "impossible", "ours alone"]
Verdict = Literal["reproduced", "shape only", "not reproduced"] | Unjudged


def _in_order(limits: tuple[float, float]) -> tuple[float, float]:
    if limits[0] > limits[1]:
        raise ValueError(f"expected the lower limit first, got {limits[0]:g}, {limits[1]:g}")
    return limits


Range = Annotated[
    tuple[Number, Number], Field(min_length=2, max_length=2), AfterValidator(_in_order)
]


class ThesisRow(Frozen):
    """A value or a claim of the thesis.

    Attributes:
        of: The part of the experiment, such as 3c.
        what: What it is.
        place: Its section, table or figure in the thesis.
        thesis: Its value, as it is printed.
        ours: Name of our value for it; empty without one.
        unit: Of our value.
        between: Our value within these reproduces it, in ``unit``.
        shape: Our value within these has the shape alone, in ``unit``.
        cannot: The verdict where no value of ours can be held against it.
        reason: What a reader must know of the verdict.
    """

    of: str
    what: str
    place: str
    thesis: str
    ours: str = ""
    unit: str = ""
    between: Range | None = None
    shape: Range | None = None
    cannot: Unjudged | None = None
    reason: str = ""


@dataclass(frozen=True)
class ComparedRow:
    """A row of the thesis with our value.

    Attributes:
        row: The thesis's.
        ours: Our value, in the row's unit; NaN where there is none.
        verdict: How they compare.
    """

    row: ThesisRow
    ours: float
    verdict: Verdict

    @property
    def ours_text(self) -> str:
        """Our value with its unit."""
        return "–" if isnan(self.ours) else f"{self.ours:.4g} {self.row.unit}".rstrip()

    @property
    def verdict_text(self) -> str:
        """The verdict with its reason."""
        return f"{self.verdict}: {self.row.reason}" if self.row.reason else self.verdict


def compared(rows: Iterable[ThesisRow], values: Mapping[str, float]) -> Iterator[ComparedRow]:
    """Yield the rows for which there is a value, and those that need none.

    Args:
        rows: Of the thesis.
        values: Ours by their names, in SI units.
    """
    for row in rows:
        if row.ours and row.ours not in values:
            continue
        scale = parse_unit(row.unit).value if row.unit else 1.0
        ours = values[row.ours] / scale if row.ours else float("nan")
        yield ComparedRow(row, ours, _verdict(row, ours))


def _verdict(row: ThesisRow, ours: float) -> Verdict:
    if row.cannot is not None:
        return row.cannot
    if row.between is not None and row.between[0] <= ours <= row.between[1]:
        return "reproduced"
    if row.shape is not None and row.shape[0] <= ours <= row.shape[1]:
        return "shape only"
    return "not reproduced"
