from __future__ import annotations

from math import cos, pi, radians, sin

import pytest

from pirate_sm.geometry.network import Mitre, Run, Straight, planar


@pytest.mark.parametrize("angle_deg", [90, -90])
def test_a_right_angle_takes_half_the_diameter_of_the_inner_wall(angle_deg: float) -> None:
    assert Mitre(radians(angle_deg)).taken_m(0.12) == pytest.approx(0.06)


def test_only_bends_take_something_of_the_straights_beside_them() -> None:
    run = Run(0.12, (Straight(1.0), Mitre(radians(60)), Straight(1.0)))

    assert run.taken_m == pytest.approx((0.0, 0.06 * 3**-0.5, 0.0))


@pytest.mark.parametrize(
    ("tilt", "uphill", "up"),
    [
        (0.0, pi / 2, (0.0, 0.0, -1.0)),
        (pi / 2, 0.0, (1.0, 0.0, 0.0)),
        (pi / 2, pi / 2, (0.0, 1.0, 0.0)),
        (radians(30), pi / 2, (0.0, sin(radians(30)), -cos(radians(30)))),
    ],
)
def test_up_follows_from_the_tilt_of_the_plane(
    tilt: float, uphill: float, up: tuple[float, float, float]
) -> None:
    assert planar(0.1, (Straight(1.0),), tilt, uphill).up == pytest.approx(up)
