from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.errors import UsageError
from pirate_sm.simulation.geometry import GRAVITY_M_S2, Mitre, Pipe, PipeShape, Straight

RADIUS = 0.06


def one_bend(angle_deg: float, **more: float) -> Pipe:
    parts = (Straight(1.0), Mitre(math.radians(angle_deg)), Straight(2.0))
    return Pipe(PipeShape(2 * RADIUS, parts, **more))


def test_a_positive_mitre_has_its_inner_corner_on_side_a() -> None:
    pipe = one_bend(90)
    assert pipe.wall_a[1] == pytest.approx((1.0 - RADIUS, RADIUS))
    assert pipe.wall_b[1] == pytest.approx((1.0 + RADIUS, -RADIUS))
    assert pipe.wall_a[2] == pytest.approx((1.0 - RADIUS, 2.0))


def test_a_negative_mitre_is_the_mirror_image() -> None:
    right, left = one_bend(60), one_bend(-60)
    for (x, y), mirrored in zip(left.wall_b, right.wall_a, strict=True):
        assert (x, -y) == pytest.approx(mirrored)


@given(st.floats(-119, 119).filter(lambda angle: abs(angle) > 1))
def test_walls_are_as_far_from_the_centre_line_everywhere(angle_deg: float) -> None:
    pipe = one_bend(angle_deg)
    for number, leg in enumerate(pipe.legs):
        tx, ty = leg.direction
        for wall, side in ((pipe.wall_a, 1), (pipe.wall_b, -1)):
            for x, y in wall[number : number + 2]:
                across = (y - leg.start[1]) * tx - (x - leg.start[0]) * ty
                assert across == pytest.approx(side * RADIUS)


def test_arc_length_goes_through_the_crossing() -> None:
    pipe = one_bend(90)
    assert pipe.crossings_m == (1.0,)
    assert pipe.length_m == 3.0
    assert pipe.point(1.5) == pytest.approx((1.0, 0.5))
    assert pipe.point(1.5, 0.01) == pytest.approx((0.99, 0.5))


def test_straights_in_a_row_are_one() -> None:
    pipe = Pipe(PipeShape(0.1, (Straight(0.5), Straight(0.7))))
    assert len(pipe.legs) == 1
    assert pipe.length_m == pytest.approx(1.2)


@pytest.mark.parametrize(
    ("tilt", "uphill", "first", "second"),
    [
        (0, 90, (0, 0, 1), (0, 0, 1)),
        (90, 0, (-1, 0, 0), (0, 1, 0)),  # the first leg goes up
        (90, 90, (0, -1, 0), (-1, 0, 0)),  # the far leg goes up
        (30, 90, (0, -0.5, math.cos(math.pi / 6)), (-0.5, 0, math.cos(math.pi / 6))),
    ],
)
def test_gravity_points_down_whatever_way_the_leg_goes(
    tilt: float, uphill: float, first: tuple[float, ...], second: tuple[float, ...]
) -> None:
    pipe = one_bend(90, tilt_rad=math.radians(tilt), uphill_rad=math.radians(uphill))
    for leg, expected in zip(pipe.legs, (first, second), strict=True):
        assert [g / GRAVITY_M_S2 for g in leg.gravity] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ((Straight(0.05), Mitre(1.5), Straight(1.0)), "straight 1 is 50 mm long"),
        ((Straight(1.0), Mitre(1.5), Mitre(1.5), Straight(1.0)), "straight 2 is 0 mm long"),
        ((Straight(1.0), Mitre(2.5), Straight(1.0)), "mitre 1"),
        ((Straight(1.0), Mitre(0.0), Straight(1.0)), "mitre 1"),
    ],
)
def test_a_pipe_that_cannot_be_built_is_refused(
    parts: tuple[Straight | Mitre, ...], words: str
) -> None:
    with pytest.raises(UsageError, match=words):
        Pipe(PipeShape(0.12, parts))
