from math import isnan, nan
from typing import Any

import pytest
from pydantic import ValidationError

from pirate_sm.lab.experiments.thesis_rows import FAILED, ComparedRow, ThesisRow, compared

BAND: dict[str, Any] = {"between": (70, 90), "source": "printed", "no_effect": 0}


def row(**more: Any) -> ThesisRow:
    return ThesisRow(of="1", what="way", place="6-4", thesis="80 cm", ours="way", unit="cm", **more)


def judged(ours_m: float, **more: Any) -> ComparedRow:
    return next(compared([row(**more)], {"way": ours_m}))


@pytest.mark.parametrize(
    ("ours_m", "verdict"),
    [(0.8, "predicted"), (1.0, "contradicted"), (0.0, "contradicted"), (nan, "not measured")],
)
def test_a_value_is_judged_in_the_unit_of_its_row(ours_m: float, verdict: str) -> None:
    assert judged(ours_m, **BAND).verdict == verdict


def test_a_band_that_a_simulator_without_the_effect_passes_shows_nothing() -> None:
    assert judged(0.8, **BAND | {"no_effect": 90}).verdict == "consistent with no effect"
    assert judged(1.0, **BAND | {"no_effect": 90}).verdict == "contradicted"


def test_what_depends_on_an_assumed_number_is_no_prediction_and_names_it() -> None:
    assert judged(0.8, **BAND, assumes=["wall.step"], reason="ours").verdict == "assumed"
    assert judged(0.8, **BAND, assumes=["wall.step"], reason="ours").verdict_text == (
        "assumed: by wall.step; ours"
    )
    assert judged(0.8, **BAND, assumes=["wall.step"], cannot="input").verdict == "input"
    assert judged(1.0, **BAND, assumes=["wall.step"]).verdict == "contradicted"


def test_what_was_put_in_is_no_prediction_but_must_be_read_back() -> None:
    assert judged(0.8, **BAND, cannot="input").verdict == "input"
    assert judged(1.0, **BAND, cannot="input").verdict == "contradicted"


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({}, "expected a band"),
        ({"cannot": "input"}, "expected a band"),
        ({"between": (70, 90)}, "expected the 'source'"),
        ({"between": (70, 90), "source": "printed"}, "expected 'no_effect'"),
        ({**BAND, "cannot": "impossible"}, "expected no band"),
        ({"shape": (70, 90)}, "write its limits as 'between'"),
        ({"cannot": "not reproducible"}, "or 'cannot: not modelled'"),
    ],
)
def test_a_row_has_a_band_with_its_source_or_a_verdict_that_needs_none(
    more: dict[str, Any], said: str
) -> None:
    with pytest.raises(ValidationError, match=said):
        row(**more)


def test_what_cannot_be_judged_keeps_its_verdict_and_its_reason() -> None:
    found = judged(0.8, cannot="impossible", reason="a length is not negative")

    assert found.verdict_text == "impossible: a length is not negative"
    assert (found.ours_text, found.band_text) == ("80 cm", "–")


def test_a_row_without_a_value_of_ours_is_not_shown() -> None:
    assert list(compared([row(**BAND)], {"other": 1.0})) == []


def test_a_row_that_needs_no_value_is_shown() -> None:
    claim = ThesisRow(of="1", what="x", place="y", thesis="z", cannot="impossible")

    (found,) = compared([claim], {})

    assert isnan(found.ours)
    assert found.ours_text == "–"


def test_a_band_without_a_value_of_ours_is_not_measured() -> None:
    (found,) = compared([ThesisRow(of="1", what="x", place="y", thesis="z", **BAND)], {})

    assert found.verdict == "not measured"
    assert found.verdict in FAILED
