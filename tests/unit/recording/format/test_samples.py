"""Samples come back from a recording with the digits that viewers are shown."""

from __future__ import annotations

import json
from math import inf, nan

import jsonschema
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.recording.format.samples import (
    SCHEMA,
    Placed,
    decode_samples,
    encode_samples,
    rounded,
    sample_text,
)

NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
PLACED = st.builds(
    Placed, NUMBERS, st.booleans(), st.lists(st.tuples(NUMBERS, NUMBERS), max_size=6)
)


@given(st.lists(PLACED, max_size=4))
def test_samples_come_back_rounded(samples: list[Placed]) -> None:
    written = json.loads(encode_samples([sample_text(*each) for each in samples]))

    jsonschema.validate(written, SCHEMA)
    expected = [each._replace(wheels=rounded(each.wheels)) for each in samples]
    assert list(decode_samples(written)) == expected


@given(st.lists(st.tuples(NUMBERS, NUMBERS), min_size=1))
def test_rounding_twice_changes_nothing(wheels: list[tuple[float, float]]) -> None:
    once = rounded(wheels)

    assert rounded(once) == once
    for (x, _), (near, _) in zip(wheels, once, strict=True):
        assert abs(near - x) <= 1e-8 * abs(x) + 5e-324


def test_a_place_that_is_no_number_is_unknown() -> None:
    for wrong in (nan, inf, -inf):
        text = sample_text(1.5, True, [(0.0, 1.0), (wrong, 2.0)])

        (placed,) = decode_samples(json.loads(encode_samples([text])))

        assert placed == Placed(1.5, True, ())
