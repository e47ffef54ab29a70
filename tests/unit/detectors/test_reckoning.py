from __future__ import annotations

from itertools import pairwise
from math import asin, nan, radians, sqrt

import pytest

from pirate_sm.detectors.reckoning import Chain, Reckoned, Reckoner
from pirate_sm.detectors.route import Route
from pirate_sm.model.pipe import Mitre, Pipe, Straight

LINK, ASIDE = 0.1, 0.035
ODOMETER, FIRST, SECOND, THIRD, FOURTH = range(5)
# Six wheels in two parts; each part is a V with the joint at its middle wheel.
CHAIN = Chain(
    (LINK,) * 5,
    (-1, FIRST, SECOND, THIRD, FOURTH, -1),
    (ASIDE, -ASIDE, ASIDE, -ASIDE, ASIDE, -ASIDE),
    ((0, 1, 2), (3, 4, 5)),
)
PIPE = Pipe(
    diameter=0.12,
    segments=(Straight(straight=1.0), Mitre(mitre=radians(90)), Straight(straight=1.0)),
)
LEAN = asin(2 * ASIDE / LINK)  # of a link that reaches from wall to wall
SHORT = sqrt(LINK**2 - (2 * ASIDE) ** 2)
NOTHING: frozenset[int] = frozenset()
FRONT, REAR, BOTH = frozenset({0}), frozenset({1}), frozenset({0, 1})
ZIGZAG = (-2 * LEAN, 2 * LEAN, -2 * LEAN, 2 * LEAN)


@pytest.fixture
def reckoner() -> Reckoner:
    return Reckoner(CHAIN, Route(PIPE), ODOMETER)


def numbers(odometer: float = 0.0, angles: tuple[float, ...] = (0.0,) * 4) -> tuple[float, ...]:
    return (odometer, *angles)


def lengths(reckoned: Reckoned) -> list[float]:
    return [ahead - behind for ahead, behind in pairwise(reckoned.places_m)]


def test_a_straight_robot_begins_with_its_first_wheel_at_the_place(reckoner: Reckoner) -> None:
    begun = reckoner.begin(0.7, numbers())
    assert begun.places_m == pytest.approx((0.7, 0.6, 0.5, 0.4, 0.3, 0.2))


def test_a_clamped_robot_is_shorter_and_begins_there_too(reckoner: Reckoner) -> None:
    begun = reckoner.begin(0.7, numbers(angles=ZIGZAG), BOTH)
    assert begun.places_m[0] == pytest.approx(0.7)
    assert lengths(begun) == pytest.approx([SHORT] * 5)


def test_what_was_rolled_before_the_joints_spoke_counts(reckoner: Reckoner) -> None:
    assert reckoner.begin(0.7, numbers(0.05)).places_m[0] == pytest.approx(0.75)


def test_what_is_rolled_moves_every_wheel(reckoner: Reckoner) -> None:
    begun = reckoner.begin(0.7, numbers(angles=ZIGZAG), BOTH)
    moved = reckoner.look(begun, numbers(0.12, ZIGZAG), BOTH)
    back = reckoner.look(moved, numbers(-0.05, ZIGZAG), BOTH)
    assert moved.places_m == pytest.approx([place + 0.12 for place in begun.places_m])
    assert back.places_m == pytest.approx([place - 0.05 for place in begun.places_m])


def test_a_clamped_part_stays_while_the_other_folds(reckoner: Reckoner) -> None:
    folded = (-2 * LEAN, LEAN, 0.0, 0.0)
    begun = reckoner.begin(0.7, numbers(angles=folded), FRONT)
    both = reckoner.look(begun, numbers(angles=ZIGZAG), FRONT)
    assert both.places_m[:3] == pytest.approx(begun.places_m[:3], abs=1e-6)
    assert both.places_m[5] > begun.places_m[5] + 0.05


def test_the_anchor_is_handed_over_without_a_leap(reckoner: Reckoner) -> None:
    begun = reckoner.begin(0.7, numbers(angles=ZIGZAG), FRONT)
    handed = reckoner.look(begun, numbers(angles=ZIGZAG), REAR)
    assert handed.anchor == 1
    assert handed.places_m == pytest.approx(begun.places_m)


def test_the_front_bends_into_the_far_leg(reckoner: Reckoner) -> None:
    begun = reckoner.begin(0.9, numbers(angles=ZIGZAG), REAR)
    rolled = 1.0 - LINK + 2 * SHORT - 0.9
    # The second link lies along the axis, the first one stands on it, towards side A.
    bent = (-radians(90), LEAN, -2 * LEAN, 2 * LEAN)
    reached = reckoner.look(begun, numbers(rolled, bent), REAR)
    assert reached.points[1] == pytest.approx((1.0, ASIDE))
    assert reached.places_m[0] == pytest.approx(1.0 + ASIDE + LINK)
    assert reached.places_m[3:] == pytest.approx([at + rolled for at in begun.places_m[3:]])


def test_the_places_follow_the_axis_round_the_corner(reckoner: Reckoner) -> None:
    begun = reckoner.begin(0.95, numbers(angles=ZIGZAG), FRONT)
    passed = reckoner.look(begun, numbers(0.4, ZIGZAG), FRONT)
    assert passed.leg.arc_m == pytest.approx(1.0)
    assert passed.places_m[0] == pytest.approx(1.35)


def test_a_silent_joint_is_where_it_was_and_a_silent_odometer_too(reckoner: Reckoner) -> None:
    begun = reckoner.begin(0.7, numbers(0.0, ZIGZAG), BOTH)
    silent = reckoner.look(begun, (nan, *(nan,) * 4), BOTH)
    assert silent.places_m == pytest.approx(begun.places_m)
    assert silent.odometer_m == 0.0
