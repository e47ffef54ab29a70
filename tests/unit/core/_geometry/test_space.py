from __future__ import annotations

from math import hypot, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core._geometry.space import DRAWING, Frame, dot

ANGLES = st.floats(-2 * pi, 2 * pi)
STEPS = st.lists(st.tuples(st.sampled_from(["turned", "rolled", "moved"]), ANGLES), max_size=12)


def after(steps: list[tuple[str, float]]) -> Frame:
    frame = DRAWING
    for how, value in steps:
        frame = getattr(frame, how)(value)
    return frame


@given(STEPS)
def test_a_frame_stays_orthonormal_and_right_handed(steps: list[tuple[str, float]]) -> None:
    _, ahead, side, normal = after(steps)

    for one in (ahead, side, normal):
        assert hypot(*one) == pytest.approx(1.0)
    assert [dot(ahead, side), dot(side, normal), dot(normal, ahead)] == pytest.approx([0.0] * 3)
    cross = (
        ahead[1] * side[2] - ahead[2] * side[1],
        ahead[2] * side[0] - ahead[0] * side[2],
        ahead[0] * side[1] - ahead[1] * side[0],
    )
    assert cross == pytest.approx(normal)


@given(STEPS, ANGLES)
def test_turning_and_rolling_back_undo_each_other(
    steps: list[tuple[str, float]], angle: float
) -> None:
    frame = after(steps)

    for again in (frame.turned(angle).turned(-angle), frame.rolled(angle).rolled(-angle)):
        for one, other in zip(again, frame, strict=True):
            assert one == pytest.approx(other, abs=1e-9)


def test_a_quarter_turn_leads_towards_side_a() -> None:
    assert DRAWING.turned(pi / 2).ahead == pytest.approx((0.0, 1.0, 0.0))


def test_a_quarter_roll_brings_side_a_up_where_the_normal_points_down() -> None:
    assert DRAWING.rolled(pi / 2).side == pytest.approx((0.0, 0.0, -1.0))


def test_a_point_lies_ahead_and_to_side_a() -> None:
    frame = DRAWING.moved(2.0).turned(pi / 2)

    assert frame.point(0.5, 0.1) == pytest.approx((1.9, 0.5, 0.0))
