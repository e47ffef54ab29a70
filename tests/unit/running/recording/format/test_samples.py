"""Samples come back from a recording with the digits that viewers are shown."""

from __future__ import annotations

import json
from math import inf, nan

import jsonschema
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core.events import InSpace
from pirate_sm.running.recording.format.engine_topics import (
    SAMPLES_SCHEMA,
    Placed,
    decode_samples,
    encode_samples,
    places_sample,
    rounded,
)

NUMBERS = st.floats(-1e3, 1e3)
ROLLS = [(0.0, 0.5, 0.5), (0.1, 0.6, 0.5)]
WHEELS = st.lists(st.tuples(NUMBERS, NUMBERS), max_size=6)


@st.composite
def placed(draw: st.DrawFn) -> Placed:
    wheels = draw(WHEELS)
    if not wheels or draw(st.booleans()):
        rolls_rad = draw(st.just(()) | st.sampled_from(ROLLS) | st.tuples(*[NUMBERS] * 3))
        return Placed(draw(NUMBERS), draw(st.booleans()), wheels, None, rolls_rad)
    z_m = draw(st.tuples(*[NUMBERS] * len(wheels)))
    space = InSpace(z_m, draw(st.tuples(NUMBERS, NUMBERS, NUMBERS)))
    return Placed(draw(NUMBERS), draw(st.booleans()), wheels, space)


def shown(each: Placed) -> Placed:
    space = each.space and InSpace(*(tuple(float(f"{x:.9g}") for x in v) for v in each.space))
    rolls_rad = tuple(float(f"{x:.9g}") for x in each.rolls_rad)
    return each._replace(wheels=rounded(each.wheels), space=space, rolls_rad=rolls_rad)


@given(st.lists(placed(), min_size=1, max_size=4))
def test_samples_come_back_rounded(samples: list[Placed]) -> None:
    written = json.loads(encode_samples([places_sample(*each) for each in samples]))

    jsonschema.validate(written, SAMPLES_SCHEMA)
    assert list(decode_samples(written)) == [shown(each) for each in samples]


def test_rolls_that_stay_are_written_once() -> None:
    same = [places_sample(at_s, True, [(0.0, at_s)], None, ROLLS[0]) for at_s in (0.0, 0.1, 0.2)]
    turned = places_sample(0.3, True, [(0.0, 0.3)], None, ROLLS[1])

    assert json.loads(encode_samples(same))["rolls_rad"] == [[*ROLLS[0]]]
    assert len(json.loads(encode_samples([*same, turned]))["rolls_rad"]) == 4


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
