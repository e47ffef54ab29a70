"""The joints of a route as detectors count them."""

from __future__ import annotations

from math import pi, radians, sqrt, tan

import pytest

from pirate_sm.geometry.joints import Bend, Joint, bend_at

DIAMETER_M = 0.12


def elbow(turn_deg: float, behind_m: float) -> Joint:
    return Joint("elbow", 1.5, behind_m, behind_m, radians(turn_deg))


@pytest.mark.parametrize("kind", ["mitre", "tee", "reducer"])
def test_where_walls_meet_at_once_there_is_no_reach(kind: str) -> None:
    joint = Joint(kind, 1.5, 0.06, 0.06, pi / 2)  # type: ignore[arg-type]

    assert bend_at(joint, DIAMETER_M) == Bend(1.5, 0.0)


@pytest.mark.parametrize(
    ("turn_deg", "walls_m"),
    [(30, 0.06 * tan(pi / 12)), (60, 0.06 / sqrt(3)), (90, 0.06), (120, 0.06), (180, 0.06)],
)
def test_the_reach_of_an_elbow_lacks_the_wall_that_a_mitre_takes_of_a_right_angle_at_most(
    turn_deg: float, walls_m: float
) -> None:
    found = bend_at(elbow(turn_deg, behind_m=0.2), DIAMETER_M)

    assert found.crossing_m == 1.5
    assert found.reach_m == pytest.approx(0.2 - walls_m)


def test_a_narrow_elbow_has_no_reach() -> None:
    assert bend_at(elbow(90, behind_m=0.05), DIAMETER_M) == Bend(1.5, 0.0)
