"""The thesis's values next to ours, and how a row of them is judged."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from math import isnan
from typing import Annotated, Any, Literal, get_args

from pydantic import AfterValidator, Field, model_validator

from pirate_sm.core.fields import Frozen, Number
from pirate_sm.core.units import parse_unit

Given = Literal["input", "not modelled", "impossible", "ours alone"]
Failed = Literal["contradicted", "not measured"]
Verdict = Literal["predicted", "assumed", "consistent with no effect"] | Failed | Given
FAILED: tuple[str, ...] = get_args(Failed)
_OF_BEFORE = {
    "shape": "'shape' is not read any more: write its limits as 'between', with their 'source'",
    "not reproducible": "'cannot: not reproducible' is not read any more: write a band, 'between',"
    " that our value misses, or 'cannot: not modelled'",
}
"""What stood in files of before, and what stands for it now."""


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
        between: The band of the thesis, in ``unit``: what its own spread leaves to our value.
        source: What of the thesis the band follows from; needed with one.
        no_effect: What a simulator without the effect gives, in ``unit``; needed where ours may be
            a prediction. A band that contains it cannot tell the two apart.
        assumes: Numbers on which our value depends and which were not measured, by their keys in
            the file or in the profile of the robot. With one, our value is not a prediction.
        cannot: The verdict without a band, or of a value that was put in and is read back.
        reason: What a reader must know of the verdict.
    """

    of: str
    what: str
    place: str
    thesis: str
    ours: str = ""
    unit: str = ""
    between: Range | None = None
    source: str = ""
    no_effect: Number | None = None
    assumes: tuple[str, ...] = ()
    cannot: Given | None = None
    reason: str = ""

    @model_validator(mode="before")
    @classmethod
    def _is_of_today(cls, said: Any) -> Any:
        if isinstance(said, dict):
            for old, now in _OF_BEFORE.items():
                if old in said or said.get("cannot") == old:
                    raise ValueError(now)
        return said

    @model_validator(mode="after")
    def _is_judged(self) -> ThesisRow:
        if self.between is None and self.cannot in (None, "input"):
            raise ValueError("expected a band, 'between', or a verdict that needs none, 'cannot'")
        if self.between is not None and not self.source:
            raise ValueError("expected the 'source' of the band")
        if self.between is not None and self.cannot is None and self.no_effect is None:
            raise ValueError("expected 'no_effect', what a simulator without the effect gives")
        if self.between is not None and self.cannot not in (None, "input"):
            raise ValueError(f"expected no band, 'between', where it is {self.cannot}")
        return self


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
    def band_text(self) -> str:
        """The band of the thesis, in the row's unit."""
        return "–" if self.row.between is None else "{:g} to {:g}".format(*self.row.between)

    @property
    def verdict_text(self) -> str:
        """The verdict with what it assumes and its reason."""
        by = f"by {', '.join(self.row.assumes)}" if self.verdict == "assumed" else ""
        said = "; ".join(filter(None, (by, self.row.reason)))
        return f"{self.verdict}: {said}" if said else self.verdict


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
    if row.between is None:
        assert row.cannot is not None  # the row's own check
        return row.cannot
    if isnan(ours):
        return "not measured"
    low, high = row.between
    if not low <= ours <= high:
        return "contradicted"
    if row.cannot is not None:
        return row.cannot
    assert row.no_effect is not None  # the row's own check
    if low <= row.no_effect <= high:
        return "consistent with no effect"
    return "assumed" if row.assumes else "predicted"
