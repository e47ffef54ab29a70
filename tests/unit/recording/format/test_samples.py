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
    places_sample,
    rounded,
)

NUMBERS = st.floats(-1e3, 1e3)
WHEELS = st.lists(st.tuples(NUMBERS, NUMBERS), max_size=6)
PLACED = st.builds(Placed, NUMBERS, st.booleans(), WHEELS)


@given(st.lists(PLACED, min_size=1, max_size=4))
def test_samples_come_back_rounded(samples: list[Placed]) -> None:
    written = json.loads(encode_samples([places_sample(*each) for each in samples]))

    jsonschema.validate(written, SCHEMA)
    expected = [each._replace(wheels=rounded(each.wheels)) for each in samples]
    assert list(decode_samples(written)) == expected


@given(WHEELS)
def test_rounding_twice_changes_nothing(wheels: list[tuple[float, float]]) -> None:
    once = rounded(wheels)

    assert rounded(once) == once
    for (x, _), (near, _) in zip(wheels, once, strict=True):
        assert abs(near - x) <= 1e-8 * abs(x) + 5e-324


def test_a_place_that_is_no_number_is_unknown() -> None:
    for wrong in (nan, inf, -inf):
        sample = places_sample(1.5, True, [(0.0, 1.0), (wrong, 2.0)])

        (placed,) = decode_samples(json.loads(encode_samples([sample])))

        assert placed == Placed(1.5, True, ())
