from __future__ import annotations

import math

import pytest

from pirate_sm.backends.simulator.geometry import Pipe
from pirate_sm.errors import UsageError
from pirate_sm.geometry.network import Mitre, Segment, Straight, planar
from pirate_sm.geometry.space import GRAVITY_M_S2

RADIUS = 0.06


def one_bend(angle_deg: float, **more: float) -> Pipe:
    parts = (Straight(1.0), Mitre(math.radians(angle_deg)), Straight(2.0))
    return Pipe(planar(2 * RADIUS, parts, **more))


def test_a_point_is_that_of_the_drawing() -> None:
    pipe = one_bend(90)
    assert pipe.point(1.5) == pytest.approx((1.0, 0.5))
    assert pipe.point(1.5, 0.01) == pytest.approx((0.99, 0.5))


def test_the_kernel_takes_a_row_for_each_piece_and_two_for_its_walls() -> None:
    pipe = one_bend(90)
    assert pipe.leg_array[1, :6] == pytest.approx((1.0, 0.0, 0.0, 1.0, 2.0, 1.0))
    # Side A of the first piece: start, tangent, length, normal into the pipe; the inner corner at
    # its end, the next tangent, and the bisector into the pipe.
    half = math.sqrt(0.5)
    assert pipe.wall_array[0] == pytest.approx(
        (0.0, RADIUS, 1.0, 0.0, 1.0 - RADIUS, 0.0, -1.0, 1.0, 0.0, 1.0, half, -half)
    )
    assert pipe.wall_array[1, 7] == 0.0, "the corner on side B is the outer one"


def test_straights_in_a_row_are_one() -> None:
    pipe = Pipe(planar(0.1, (Straight(0.5), Straight(0.7))))
    assert len(pipe.leg_array) == 1
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
    for row, expected in zip(pipe.leg_array, (first, second), strict=True):
        assert row[6:] / GRAVITY_M_S2 == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ((Straight(0.05), Mitre(1.5), Straight(1.0)), "straight 1 is 50 mm long"),
        ((Straight(1.0), Mitre(1.5), Mitre(1.5), Straight(1.0)), "straight 2 is 0 mm long"),
        ((Straight(1.0), Mitre(2.5), Straight(1.0)), "mitre 1"),
        ((Straight(1.0), Mitre(0.0), Straight(1.0)), "mitre 1"),
    ],
)
def test_a_pipe_that_cannot_be_built_is_refused(parts: tuple[Segment, ...], words: str) -> None:
    with pytest.raises(UsageError, match=words):
        Pipe(planar(0.12, parts))
