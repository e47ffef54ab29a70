from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import asin, isnan, nan, radians, sin, sqrt

import pytest

from pirate_sm.core._engine.sensing.body_spec import Vee
from pirate_sm.core._model.pipe_runs import Mitre
from pirate_sm.core.models import Pipe, Straight
from pirate_sm.core.sensing import BodySpec
from pirate_sm.robot.detectors.dead_reckoning import Felt, Reckoned, Reckoner

LINK, ASIDE = 0.1, 0.035
FIRST, SECOND, THIRD, FOURTH, ODOMETER = range(5)
# Six wheels in two parts; each part is a V with the joint at its middle wheel.
BODY = BodySpec(
    lengths_m=(LINK,) * 5,
    joints=(-1, FIRST, SECOND, THIRD, FOURTH, -1),
    sides=(1, -1, 1, -1, 1, -1),
    parts=(Vee((0, 1, 2), FIRST, -1, 2.0), Vee((3, 4, 5), FOURTH, -1, 2.0)),
    wheel_radius_m=0.025,
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
    return Reckoner(BODY, PIPE.route(), ODOMETER)


def numbers(odometer: float = 0.0, angles: tuple[float, ...] = (0.0,) * 4) -> tuple[float, ...]:
    return (*angles, odometer)


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


def test_an_odometer_that_is_silent_from_the_beginning_has_counted_nothing(
    reckoner: Reckoner,
) -> None:
    begun = reckoner.begin(0.7, numbers(nan, ZIGZAG), BOTH, 1.0)
    assert (begun.places_m[0], begun.odometer_m) == (pytest.approx(0.7), 0.0)
    # Between bars every part lies in their plane, whatever roll it is given.
    assert [z for _, _, z in begun.chain.points] == [0.0] * 6
    felt = reckoner.look(begun, numbers(nan, ZIGZAG), BOTH, Felt(0, 0.5))
    assert felt.spots[0].roll_rad == 0.0


@pytest.mark.parametrize(("odometer", "counted_m"), [(-1, 0.0), (0, 0.03)])
def test_the_odometer_may_be_the_first_of_the_signals_or_none(
    odometer: int, counted_m: float
) -> None:
    begun = Reckoner(BODY, PIPE.route(), odometer).begin(0.7, (0.03,) * 5, BOTH)
    assert begun.odometer_m == counted_m


def test_joints_are_known_by_their_places_among_the_signals(reckoner: Reckoner) -> None:
    assert reckoner.unknown(numbers(nan, ZIGZAG)) == []
    assert reckoner.unknown(numbers(0.0, unknown(FIRST, FOURTH))) == [FIRST, FOURTH]


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


def test_the_anchor_stays_the_same_while_it_holds(reckoner: Reckoner) -> None:
    begun = reckoner.begin(0.7, numbers(angles=ZIGZAG), REAR)
    both = reckoner.look(begun, numbers(angles=ZIGZAG), BOTH)
    assert both.anchor == 1
    # The first anchor moves the other one, whose part slides as the joints between them turn.
    turned = (ZIGZAG[0], ZIGZAG[1] + 0.3, ZIGZAG[2] - 0.3, ZIGZAG[3])
    slid = reckoner.look(both, numbers(angles=turned), BOTH)
    assert slid.anchor == 1
    assert slid.spots[1].middle_m == pytest.approx(both.spots[1].middle_m)
    assert slid.spots[0].middle_m == pytest.approx(sum(slid.places_m[:3]) / 3)
    assert abs(slid.spots[0].middle_m - both.spots[0].middle_m) > 0.003


def test_a_robot_between_bars_that_lets_go_across_a_bend_is_known(reckoner: Reckoner) -> None:
    begun = reckoner.begin(1.1, numbers(angles=ZIGZAG), BOTH)
    loose = reckoner.look(begun, numbers(angles=ZIGZAG), NOTHING)
    assert not any(map(isnan, loose.places_m))


def test_where_two_anchors_give_a_place_the_first_one_counts(reckoner: Reckoner) -> None:
    """The joint at the fourth wheel is silent: each part gives the place of that wheel."""
    begun = reckoner.begin(0.7, numbers(angles=ZIGZAG), BOTH)
    off = begun.spots[1]._replace(middle_m=begun.spots[1].middle_m + 0.01)
    parted = begun._replace(spots={0: begun.spots[0], 1: off})
    blind = reckoner.look(parted, numbers(0.0, unknown(THIRD)), BOTH)
    moved_m = [now - was for now, was in zip(blind.places_m, begun.places_m, strict=True)]
    assert moved_m == pytest.approx([0.0] * 4 + [0.01] * 2, abs=1e-6)


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
    assert passed.spots[0].middle_m == pytest.approx(1.35 - SHORT)
    assert passed.places_m[0] == pytest.approx(1.35)


def test_a_silent_odometer_shows_what_it_showed(reckoner: Reckoner) -> None:
    begun = reckoner.begin(0.7, numbers(0.0, ZIGZAG), BOTH)
    silent = reckoner.look(begun, numbers(nan, ZIGZAG), BOTH)
    assert silent.places_m == pytest.approx(begun.places_m)
    assert silent.odometer_m == 0.0


def unknown(*joints: int) -> tuple[float, ...]:
    """The clamped robot's angles, some of which are unknown."""
    return tuple(nan if joint in joints else angle for joint, angle in enumerate(ZIGZAG, FIRST))


@pytest.mark.parametrize(
    ("held", "joint", "lost"),
    [
        # The front lies along the pipe by the joint inside it; what is behind rests on the rest.
        (FRONT, FIRST, {0, 1, 2, 3, 4, 5}),
        (FRONT, SECOND, {3, 4, 5}),
        (FRONT, THIRD, {4, 5}),
        (FRONT, FOURTH, {5}),
        (REAR, FIRST, {0}),
        (REAR, SECOND, {0, 1}),
        (REAR, THIRD, {0, 1, 2}),
        (REAR, FOURTH, {0, 1, 2, 3, 4, 5}),
        # With both parts clamped each gives the places of its own wheels.
        (BOTH, SECOND, set()),
        (BOTH, FIRST, {0}),
    ],
)
def test_the_place_of_a_wheel_is_unknown_where_a_joint_that_it_rests_on_is(
    reckoner: Reckoner, held: frozenset[int], joint: int, lost: set[int]
) -> None:
    begun = reckoner.begin(0.7, numbers(angles=ZIGZAG), held)
    blind = reckoner.look(begun, numbers(0.05, unknown(joint)), held)
    assert {wheel for wheel, place in enumerate(blind.places_m) if isnan(place)} == lost
    for wheel in set(range(6)) - lost:
        assert blind.places_m[wheel] == pytest.approx(begun.places_m[wheel] + 0.05, abs=1e-6)


def test_the_places_come_back_with_the_joint(reckoner: Reckoner) -> None:
    begun = reckoner.begin(0.7, numbers(angles=ZIGZAG), FRONT)
    blind = reckoner.look(begun, numbers(0.05, unknown(FIRST)), FRONT)
    again = reckoner.look(blind, numbers(0.06, ZIGZAG), FRONT)
    assert again.places_m == pytest.approx([place + 0.06 for place in begun.places_m])


def test_the_robot_is_lost_when_the_hold_passes_over_an_unknown_joint(reckoner: Reckoner) -> None:
    begun = reckoner.begin(0.7, numbers(angles=ZIGZAG), REAR)
    blind = reckoner.look(begun, numbers(0.0, unknown(SECOND)), REAR)
    handed = reckoner.look(blind, numbers(0.02, unknown(SECOND)), FRONT)
    assert handed.lost
    assert (handed.anchor, handed.odometer_m, handed.checked_m) == (0, 0.02, 0.02)
    assert len(handed.places_m) == len(handed.chain.points) == 6
    again = reckoner.look(handed, numbers(0.0, ZIGZAG), FRONT)
    assert again.lost
    assert all(map(isnan, again.places_m))


def test_the_hold_passes_over_an_unknown_joint_once_both_parts_have_been_placed(
    reckoner: Reckoner,
) -> None:
    begun = reckoner.begin(0.7, numbers(angles=ZIGZAG), REAR)
    both = reckoner.look(begun, numbers(0.0, ZIGZAG), BOTH)
    blind = reckoner.look(both, numbers(0.0, unknown(SECOND)), BOTH)
    handed = reckoner.look(blind, numbers(0.03, unknown(SECOND)), FRONT)
    assert handed.places_m[:3] == pytest.approx([place + 0.03 for place in begun.places_m[:3]])


MEASURED = replace(
    BODY, parts=(Vee((0, 1, 2), FIRST, 5, 2.0), Vee((3, 4, 5), FOURTH, 6, 2.0)), roll=-1
)
"""A robot that measures the diameters that its parts span, too."""


def spanning(odometer: float, angles: tuple[float, ...]) -> tuple[float, ...]:
    spans = (LINK * sin(abs(angles[apex]) / 2) + 0.05 for apex in (0, 3))
    return (*angles, odometer, *spans)


@pytest.mark.parametrize(
    ("off_deg", "held", "shape"),
    [
        ((0, 0, 0, 0), BOTH, "fits"),
        ((2, 0, 0, -2), BOTH, "fits"),
        ((0, 0, 0, 0), NOTHING, "unknown"),  # nobody knows where its axis is
        ((0, 0, 0, -20), NOTHING, "unknown"),
        ((13, 0, 0, 0), BOTH, "contradicts"),  # a zero has jumped: another diameter
        ((0, 0, 0, -20), BOTH, "contradicts"),
        ((0, 15, -9, 0), BOTH, "contradicts"),  # folded: the rear would be in the wall
        ((0, 0, -7, 0), BOTH, "contradicts"),  # two parts in one straight lie along one axis
    ],
)
def test_belief_the_shape_of_a_robot_that_has_passed_a_bend_fits_its_leg(off_deg, held, shape):
    angles = tuple(angle + radians(off) for angle, off in zip(ZIGZAG, off_deg, strict=True))
    reckoner = Reckoner(MEASURED, PIPE.route(), ODOMETER)
    begun = reckoner.begin(1.7, spanning(0.0, ZIGZAG), held)

    assert reckoner.look(begun, spanning(0.0, angles), held).shape == shape


def test_across_a_bend_the_shape_is_not_that_of_a_robot_that_has_passed_it():
    reckoner = Reckoner(MEASURED, PIPE.route(), ODOMETER)
    begun = reckoner.begin(1.7, spanning(0.0, ZIGZAG), BOTH)
    across = (ZIGZAG[0], ZIGZAG[1] - radians(90), *ZIGZAG[2:])

    assert reckoner.look(begun, spanning(0.0, across), BOTH).shape == "contradicts"


@pytest.mark.parametrize("off_deg", [6, -6, -10])
def test_belief_in_a_place_does_not_leap_to_a_corner_that_a_wrong_joint_fits(off_deg: float):
    """Its zero is off in the straight before the corner, where such a shape has no room."""
    angles = (ZIGZAG[0], ZIGZAG[1] + radians(off_deg), *ZIGZAG[2:])
    reckoner = Reckoner(MEASURED, PIPE.route(), ODOMETER)
    reckoned = reckoner.begin(0.7, spanning(0.0, ZIGZAG), REAR)
    begun_m = reckoned.spots[1].middle_m

    for rolled_m in [step * 0.01 for step in range(28)]:
        reckoned = reckoner.look(reckoned, spanning(rolled_m, angles), REAR)

        assert reckoned.spots[1].middle_m == pytest.approx(begun_m + rolled_m, abs=0.045)


def test_a_part_whose_v_shows_the_diameter_is_the_surer_anchor() -> None:
    reckoner = Reckoner(MEASURED, PIPE.route(), ODOMETER)
    begun = reckoner.begin(0.7, spanning(0.0, ZIGZAG), BOTH)
    assert begun.anchor == 0
    jumped = (ZIGZAG[0] + radians(13), *ZIGZAG[1:])
    assert reckoner.look(begun, spanning(0.0, jumped), BOTH).anchor == 1


@pytest.mark.parametrize(
    ("spans_m", "off_deg", "straight"),
    [
        ((0.12, 0.12), (0, 0, 0, 0), True),
        ((0.12, 0.10), (0, 0, 0, 0), False),
        ((0.10, 0.12), (0, 0, 0, 0), False),
        ((0.12, nan), (0, 0, 0, 0), False),
        ((0.1235, 0.1165), (0, 0, 4, 0), True),
        ((0.12, 0.12), (0, 0, 6, 0), False),
    ],
)
def test_parts_lie_along_one_axis_where_they_show_its_diameter_and_heading(
    spans_m: tuple[float, float], off_deg: tuple[float, ...], straight: bool
) -> None:
    reckoner = Reckoner(MEASURED, PIPE.route(), ODOMETER)
    spots = reckoner.begin(0.7, spanning(0.0, ZIGZAG), BOTH).spots
    angles = (angle + radians(off) for angle, off in zip(ZIGZAG, off_deg, strict=True))

    assert reckoner.straight((*angles, 0.0, *spans_m), spots) is straight


@pytest.mark.parametrize(("diameter", "lies"), [(0, True), (1, False), (-1, False)])
def test_a_part_lies_along_its_leg_where_it_measures_its_diameter(
    diameter: int, lies: bool
) -> None:
    vee = Vee((0, 1, 2), FIRST, diameter, 2.0)
    reckoner = Reckoner(replace(BODY, parts=(vee, vee)), PIPE.route(), ODOMETER)

    assert reckoner.lies((0.12, 0.1, 0.12), 0, 0.5) is lies


def test_nothing_is_said_of_a_shape_no_joint_of_which_is_known() -> None:
    reckoner = Reckoner(MEASURED, PIPE.route(), ODOMETER)
    begun = reckoner.begin(0.7, spanning(0.0, ZIGZAG), FRONT)
    silent = (*(nan,) * 4, 0.0, 0.12, 0.12)

    assert reckoner.look(begun, silent, FRONT).shape == "unknown"


def test_a_new_anchor_stands_where_its_joints_are_when_it_holds(reckoner: Reckoner) -> None:
    begun = reckoner.begin(0.7, numbers(angles=ZIGZAG), FRONT)
    turned = numbers(angles=(ZIGZAG[0], ZIGZAG[1] + 0.3, ZIGZAG[2] - 0.3, ZIGZAG[3]))
    often = reckoner.look(reckoner.look(begun, turned, FRONT), turned, REAR)

    seldom = reckoner.look(begun, turned, REAR)

    assert seldom.places_m == pytest.approx(often.places_m, abs=1e-9)
    assert seldom.spots[1].middle_m == pytest.approx(often.spots[1].middle_m, abs=1e-9)
