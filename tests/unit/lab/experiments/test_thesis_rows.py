from math import isnan, nan
from typing import Any

import pytest

from pirate_sm.lab.experiments.setups import ComparedRow, ThesisRow, compared


def row(**more: Any) -> ThesisRow:
    return ThesisRow(of="1", what="way", place="6-4", thesis="80 cm", ours="way", unit="cm", **more)


def judged(ours_m: float, **more: Any) -> ComparedRow:
    return next(compared([row(**more)], {"way": ours_m}))


@pytest.mark.parametrize(
    ("ours_m", "verdict"),
    [(0.8, "reproduced"), (1.0, "shape only"), (2.0, "not reproduced"), (nan, "not reproduced")],
)
def test_a_value_is_judged_in_the_unit_of_its_row(ours_m: float, verdict: str) -> None:
    assert judged(ours_m, between=(70, 90), shape=(50, 120)).verdict == verdict


def test_what_cannot_be_judged_keeps_its_verdict_and_its_reason() -> None:
    found = judged(0.8, cannot="impossible", reason="a length is not negative")

    assert found.verdict_text == "impossible: a length is not negative"
    assert found.ours_text == "80 cm"


def test_a_row_without_a_value_of_ours_is_not_shown() -> None:
    assert list(compared([row(between=(0, 1))], {"other": 1.0})) == []


def test_a_row_that_needs_no_value_is_shown() -> None:
    claim = ThesisRow(of="1", what="x", place="y", thesis="z", cannot="impossible")

    (found,) = compared([claim], {})

    assert isnan(found.ours)
    assert found.ours_text == "–"
