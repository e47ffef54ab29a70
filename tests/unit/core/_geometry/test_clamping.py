from __future__ import annotations

from math import cos, inf, radians

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core._geometry.chain import height_m, press_n, span_m


@given(st.floats(0.01, 1.0), st.floats(-3.0, 3.0))
def test_height_and_span_of_a_v_are_the_sides_of_its_leg(leg: float, apex: float) -> None:
    height = height_m(leg, apex)

    assert height >= 0.0
    assert span_m(leg, height) == pytest.approx(leg * cos(apex / 2), abs=1e-7)


def test_a_link_that_is_too_short_spans_nothing() -> None:
    assert span_m(0.05, 0.06) == 0.0


def test_a_v_presses_by_its_torque_over_its_half_length() -> None:
    height = height_m(0.1, radians(60))

    assert height == pytest.approx(0.05)
    # Equation 3-3: tau / (l cos 30 deg), once, twice and once.
    assert press_n(1.0, 0.1, height) == pytest.approx(4 / (0.1 * 0.8660254))


def test_a_v_that_stands_upright_presses_without_limit() -> None:
    assert press_n(1.0, 0.1, 0.1) == inf
