"""A wheel sinks into a mouth until it touches its edge or the wall of the branch."""

from __future__ import annotations

from math import radians, sin, sqrt

import pytest

from pirate_sm.checking.pipe.bend_rules import sink_m

RUN, WHEEL = 0.060, 0.024


def test_a_wheel_falls_into_a_mouth_that_is_wider_than_itself() -> None:
    assert sink_m(RUN, 0.025, WHEEL, 0.0) == pytest.approx(2 * WHEEL)
    assert sink_m(RUN, RUN, WHEEL, 0.0) == pytest.approx(2 * WHEEL)


def test_a_narrower_mouth_holds_it_by_its_edge() -> None:
    # over a slit as long as the mouth; its edge across the run lies lower
    for branch in (0.010, 0.015, 0.020):
        expected = WHEEL - sqrt(WHEEL**2 - branch**2)
        assert 0.0 < sink_m(RUN, branch, WHEEL, 0.0) <= expected + 1e-9


@pytest.mark.parametrize("aside_deg", [45, 60, 75])
def test_the_wall_of_the_branch_holds_it_at_the_side(aside_deg: float) -> None:
    aside = radians(aside_deg)
    expected = (RUN - WHEEL) / sin(aside) - (RUN - WHEEL)

    assert sink_m(RUN, RUN, WHEEL, aside) == pytest.approx(expected, abs=6e-4)
    assert sink_m(RUN, RUN, WHEEL, -aside) == sink_m(RUN, RUN, WHEEL, aside)


@pytest.mark.parametrize(("branch", "aside_deg"), [(RUN, 90), (0.04, 45), (0.02, 25), (RUN, 180)])
def test_beside_the_mouth_it_stays_on_the_wall(branch: float, aside_deg: float) -> None:
    assert sink_m(RUN, branch, WHEEL, radians(aside_deg)) == 0.0
