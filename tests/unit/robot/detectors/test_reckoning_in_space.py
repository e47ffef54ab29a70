"""Dead reckoning in round pipes: bends in any plane, a turned roll joint, walls that correct it."""

from __future__ import annotations

from dataclasses import replace
from math import asin, cos, isnan, nan, pi, radians, remainder, sin
from random import Random

import pytest

from pirate_sm.core import library
from pirate_sm.core._geometry.network import Elbow, Mitre, Reducer, Straight, planar
from pirate_sm.core.geometry import Frame, Route, dot
from pirate_sm.core.loading import load_robot
from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.sensing import WHOLE
from pirate_sm.lab.mapping.axes import axis_at, plane_of, wheel_at
from pirate_sm.lab.mapping.bend_angles import reached
from pirate_sm.robot.detectors.dead_reckoning import Felt, Reckoned, Reckoner

FRONT, REAR = 0, 1
BORE_M, WHEEL_M = 0.120, 0.024
LEAN = asin((BORE_M - 2 * WHEEL_M) / 0.090)
OBLIQUE = asin((BORE_M - 2 * WHEEL_M) / 0.098)
IN_REAR, IN_FRONT = frozenset({REAR}), frozenset({FRONT})
LOOSE: frozenset[int] = frozenset()


@pytest.fixture(scope="module")
def robot() -> RobotSpec:
    return load_robot(library.find_robot("pirate_ii")).normal


def numbers_of(robot: RobotSpec, **changed: float) -> list[float]:
    """The rear lies along its leg, the front's first link leans to the wall of one at 90 deg."""
    signals = {
        "gamma_3": -(LEAN + OBLIQUE),
        "gamma_4": 2 * LEAN,
        "gamma_2": radians(-10),
        "gamma_1": OBLIQUE + radians(10) - pi / 2 - LEAN,
        "rear_diameter": BORE_M,
        "front_diameter": 0.109,
        "phi": 0.0,
        "odometry": 0.0,
    } | changed
    numbers = [nan] * len(robot.vocabulary.numbers)
    for name, value in signals.items():
        if name.endswith("_diameter"):
            part = FRONT if name.startswith("front") else REAR
            numbers[robot.body.parts[part].diameter] = value
        else:
            numbers[robot.vocabulary.numbers.index(name)] = value
    return numbers


def clamped(robot: RobotSpec, **changed: float) -> list[float]:
    """Both parts lie along one leg."""
    along = {
        "gamma_1": -2 * LEAN,
        "gamma_2": LEAN + OBLIQUE,
        "front_diameter": BORE_M,
    }
    return numbers_of(robot, **(along | changed))


def route_of(*segments, up=(0.0, 0.0, -1.0)) -> Route:
    network = planar(BORE_M, segments, section="round")
    return Route(type(network)(network.runs, network.routes, up))


def bend(roll_deg: float = 0.0, angle_deg: float = 90.0) -> Route:
    mitre = Mitre(radians(angle_deg), radians(roll_deg))
    return route_of(Straight(1.0), mitre, Straight(1.0))


def reckoner(robot: RobotSpec, route: Route) -> Reckoner:
    return Reckoner(robot.body, route, robot.odometry)


def away_m(robot: RobotSpec) -> float:
    """How far before the bend the middle of the rear's wheels is in the posture of numbers_of."""
    axis = axis_at(robot.body, numbers_of(robot), REAR)
    assert axis is not None
    seen = reached(robot.body, numbers_of(robot), axis, FRONT, 1, BORE_M)
    assert seen is not None
    return seen.away_m


@pytest.mark.parametrize("seed", range(40))
def test_it_agrees_with_the_kinematics_of_the_chain(robot: RobotSpec, seed: int) -> None:
    """A chain with random joints is carried into a random route by its axis alone."""
    chance = Random(seed)
    fittings = [
        Mitre(chance.uniform(0.5, 1.5), chance.uniform(-pi, pi)),
        Elbow(chance.uniform(0.5, 1.5), chance.uniform(0.15, 0.3), chance.uniform(-pi, pi)),
    ]
    route = route_of(Straight(1.0), chance.choice(fittings), Straight(1.0))
    joints = {name: chance.uniform(-1.2, 1.2) for name in ("gamma_1", "gamma_2", "phi")}
    # A diameter that the pipe does not have: the part is not held to the walls.
    numbers = numbers_of(robot, **joints, rear_diameter=0.2)
    roll_rad, middle_m = chance.uniform(-pi, pi), chance.uniform(0.3, 0.9)
    numbers_at = list(numbers)
    numbers_at[robot.body.parts[REAR].diameter] = BORE_M
    axis = axis_at(robot.body, numbers_at, REAR)
    assert axis is not None
    held = route.frame_at(middle_m).rolled(roll_rad)
    points = [
        Frame(wheel_at(robot.body, numbers, wheel), *axis[1:]).carried(axis, held).origin
        for wheel in range(6)
    ]
    looking = reckoner(robot, route)
    begun = looking.begin(0.5, numbers, IN_REAR, roll_rad)
    spot = begun.spots[REAR]._replace(middle_m=middle_m, roll_rad=roll_rad)
    found = looking.look(begun._replace(spots={REAR: spot}), numbers, IN_REAR)
    for one, other in zip(found.chain.points, points, strict=True):
        assert one == pytest.approx(other, abs=1e-9)
    assert found.places_m == pytest.approx([route.arc_of(point) for point in points])
    front = Frame((0.0, 0.0, 0.0), *plane_of(robot.body, numbers, FRONT)[1:]).carried(axis, held)
    assert abs(dot(front.normal, found.chain.front.normal)) == pytest.approx(1.0)


@pytest.mark.parametrize("roll_deg", [0.0, 90.0, -135.0])
def test_the_front_reaches_round_a_bend_in_the_plane_of_its_roll(robot, roll_deg) -> None:
    looking, at_m = reckoner(robot, bend(roll_deg)), 1.0 - away_m(robot)
    begun = looking.begin(0.8, numbers_of(robot), IN_REAR, radians(roll_deg))
    there = begun.spots[REAR]._replace(middle_m=at_m)
    found = looking.look(begun._replace(spots={REAR: there}), numbers_of(robot), IN_REAR)
    assert found.spots[REAR].middle_m == pytest.approx(at_m)
    assert found.places_m[0] > 1.05
    # The second wheel stands across the leg behind the bend.
    assert found.places_m[0] - found.places_m[3] > 0.2
    assert looking.roll_of(found, FRONT) == pytest.approx(radians(roll_deg))


@pytest.mark.parametrize("turned_deg", [90.0, -90.0, 35.0])
def test_a_part_that_clamps_has_the_roll_that_the_roll_joint_gave_it(robot, turned_deg) -> None:
    looking, turned = reckoner(robot, bend()), radians(turned_deg)
    begun = looking.begin(0.8, clamped(robot), IN_REAR)
    handed = looking.look(begun, clamped(robot, phi=turned), IN_REAR)
    both = looking.look(handed, clamped(robot, phi=turned), IN_REAR | IN_FRONT)
    # The plane of the rear half leans: the link with the roll joint stands obliquely in the leg.
    assert both.spots[FRONT].roll_rad == pytest.approx(turned, abs=radians(25))
    front = looking.look(both, clamped(robot, phi=turned), IN_FRONT)
    back = looking.look(front, clamped(robot, phi=0.0), IN_FRONT)
    assert looking.roll_of(back, REAR) == pytest.approx(back.spots[FRONT].roll_rad, abs=1e-6)


def corrected_m(robot: RobotSpec, off_m: float, route: Route | None = None, **changed) -> float:
    """How far the rear is off after a look before which it was off by ``off_m``."""
    looking, at_m = reckoner(robot, route or bend()), 1.0 - away_m(robot)
    numbers = numbers_of(robot, **changed)
    begun = looking.begin(0.8, numbers_of(robot), IN_REAR)
    there = begun.spots[REAR]._replace(middle_m=at_m + off_m)
    found = looking.look(begun._replace(spots={REAR: there}), numbers, IN_REAR)
    return found.spots[REAR].middle_m - at_m


@pytest.mark.parametrize("off_m", [-0.03, -0.015, 0.0, 0.015, 0.03])
def test_the_walls_of_a_bend_correct_an_error(robot: RobotSpec, off_m: float) -> None:
    assert corrected_m(robot, off_m) == pytest.approx(0.0, abs=0.006)


@pytest.mark.parametrize(
    ("off_m", "changed"),
    [
        (0.08, {}),
        (-0.08, {}),
        (0.02, {"phi": radians(20)}),
        (0.02, {"phi": nan}),
        (0.02, {"rear_diameter": 0.110}),
        (0.02, {"rear_diameter": nan}),
        (0.02, {"gamma_1": -2 * LEAN, "gamma_2": LEAN + OBLIQUE}),  # not bent
    ],
)
def test_what_does_not_fit_the_walls_changes_nothing(robot, off_m, changed) -> None:
    route = bend() if len(changed) < 2 else route_of(Straight(3.0))
    assert corrected_m(robot, off_m, route, **changed) == pytest.approx(off_m, abs=1e-9)


def test_what_has_been_rolled_since_the_walls_were_right_may_be_slip(robot: RobotSpec) -> None:
    looking, at_m = reckoner(robot, bend()), 1.0 - away_m(robot)
    begun = looking.begin(0.8, numbers_of(robot), IN_REAR)
    there = begun.spots[REAR]._replace(middle_m=at_m)
    slipped = numbers_of(robot, odometry=0.08)
    found = looking.look(begun._replace(spots={REAR: there}), slipped, IN_REAR)
    assert found.spots[REAR].middle_m == pytest.approx(at_m, abs=0.006)


def test_the_inertial_unit_gives_the_roll_in_a_flat_leg(robot: RobotSpec) -> None:
    looking = reckoner(robot, bend())
    begun = looking.begin(0.8, clamped(robot), IN_REAR)
    felt = looking.look(begun, clamped(robot), IN_REAR, Felt(REAR, radians(20)))
    other = looking.look(begun, clamped(robot), IN_REAR, Felt(FRONT, radians(20)))
    unknown = looking.look(felt, clamped(robot), IN_REAR, Felt(REAR, nan))
    assert felt.spots[REAR].roll_rad == pytest.approx(radians(20))
    assert other.spots[REAR].roll_rad == 0.0
    assert unknown.spots[REAR].roll_rad == pytest.approx(radians(20))
    over = looking.look(begun, clamped(robot), IN_REAR, Felt(REAR, radians(200)))
    assert over.spots[REAR].roll_rad == pytest.approx(radians(-160))


def test_the_roll_that_is_felt_is_against_the_horizontal(robot: RobotSpec) -> None:
    """The frame of this pipe has its side up, so a robot of roll 0 feels a quarter turn."""
    looking = reckoner(robot, route_of(Straight(2.0), up=(0.0, 1.0, 0.0)))
    begun = looking.begin(0.8, clamped(robot), IN_REAR)
    felt = looking.look(begun, clamped(robot), IN_REAR, Felt(REAR, radians(20)))
    assert felt.spots[REAR].roll_rad == pytest.approx(radians(20 - 90))


def test_and_not_in_a_steep_one(robot: RobotSpec) -> None:
    steep = route_of(Straight(2.0), up=(cos(radians(20)), 0.0, -sin(radians(20))))
    looking = reckoner(robot, steep)
    begun = looking.begin(0.8, clamped(robot), IN_REAR)
    felt = looking.look(begun, clamped(robot), IN_REAR, Felt(REAR, radians(20)))
    assert felt.spots[REAR].roll_rad == 0.0


def let_go(robot: RobotSpec, looking: Reckoner, first_wheel_m: float) -> Reckoned:
    begun = looking.begin(first_wheel_m, clamped(robot), IN_REAR)
    return looking.look(looking.look(begun, clamped(robot), LOOSE), clamped(robot), IN_REAR)


def test_a_robot_that_has_let_go_is_known_in_its_straight_only(robot: RobotSpec) -> None:
    looking = reckoner(robot, bend())
    inside, across = let_go(robot, looking, 0.7), let_go(robot, looking, 0.98)
    assert isnan(inside.spots[REAR].roll_rad)
    assert not any(map(isnan, inside.places_m))
    assert isnan(looking.roll_of(inside, REAR))
    assert {round(z, 9) for _, _, z in inside.chain.points} == {0.0}, "it is drawn with roll 0"
    # Its shape is not held against walls that nobody knows the roll of.
    held = looking.look(inside, clamped(robot), IN_REAR)
    assert (held.shape, held.checked_m) == ("unknown", 0.0)
    assert [isnan(place) for place in across.places_m] == [True] + [False] * 5
    felt = looking.look(across, clamped(robot), IN_REAR, Felt(REAR, 0.0))
    assert not any(map(isnan, felt.places_m))


def test_a_robot_that_begins_loose_has_the_roll_of_the_file(robot: RobotSpec) -> None:
    looking = reckoner(robot, bend())
    begun = looking.begin(0.7, clamped(robot), LOOSE, radians(30))
    assert begun.anchor == WHOLE
    held = looking.look(begun, clamped(robot), IN_REAR)
    assert remainder(held.spots[REAR].roll_rad - radians(30), 2 * pi) == pytest.approx(
        0.0, abs=1e-6
    )


def test_an_unknown_roll_joint_leaves_the_part_that_holds(robot: RobotSpec) -> None:
    looking = reckoner(robot, bend())
    begun = looking.begin(0.7, clamped(robot), IN_REAR)
    blind = looking.look(begun, clamped(robot, phi=nan), IN_REAR)
    assert [isnan(place) for place in blind.places_m] == [True, True, False, False, False, False]
    assert looking.unknown(clamped(robot, phi=nan)) == [robot.body.roll]
    # Both parts hold: each gives the places and the plane of its own.
    turned = clamped(robot, phi=radians(50))
    both = looking.look(looking.look(begun, turned, IN_REAR), turned, IN_REAR | IN_FRONT)
    filled = looking.look(both, clamped(robot, phi=nan), IN_REAR | IN_FRONT)
    assert filled.places_m == pytest.approx(both.places_m, abs=0.01)
    assert dot(filled.chain.front.normal, both.chain.front.normal) > 0.8
    assert dot(filled.chain.rear.normal, both.chain.rear.normal) > 0.99
    assert dot(filled.chain.front.normal, both.chain.rear.normal) < 0.8


@pytest.mark.parametrize(
    ("fitting", "first_m", "unknown"),
    [
        (Mitre(pi / 2), 0.93, []),
        (Mitre(pi / 2), 0.95, [0]),
        (Reducer(0.05, 0.11), 1.2, []),
        (Mitre(pi / 2), 1.6, []),
    ],
)
def test_what_is_beyond_a_turn_is_unknown_of_a_robot_of_unknown_roll(
    robot: RobotSpec, fitting, first_m: float, unknown: list[int]
) -> None:
    loose = let_go(robot, reckoner(robot, route_of(Straight(1.0), fitting, Straight(1.0))), first_m)
    assert [wheel for wheel, place in enumerate(loose.places_m) if isnan(place)] == unknown


def test_the_last_wheels_may_be_those_before_the_turn(robot: RobotSpec) -> None:
    looking = reckoner(robot, bend())
    length_m = 1.6 - looking.begin(1.6, clamped(robot), IN_REAR).places_m[-1]
    begun = looking.begin(1.05 + length_m, clamped(robot), IN_REAR)
    loose = looking.look(begun, clamped(robot), LOOSE)
    assert [isnan(place) for place in loose.places_m] == [False] * 5 + [True]


def test_a_robot_that_lets_go_while_a_joint_is_silent_is_lost(robot: RobotSpec) -> None:
    looking = reckoner(robot, bend())
    begun = looking.begin(0.7, clamped(robot), IN_REAR)
    silent = clamped(robot, gamma_2=nan)
    assert looking.look(looking.look(begun, silent, IN_REAR), silent, LOOSE).lost


def test_the_anchor_whose_roll_is_known_is_the_surer_one(robot: RobotSpec) -> None:
    looking, both = reckoner(robot, bend()), IN_REAR | IN_FRONT
    begun = looking.look(looking.begin(0.7, clamped(robot), IN_REAR), clamped(robot), both)
    assert begun.anchor == REAR
    rolled = {REAR: begun.spots[REAR]._replace(roll_rad=nan), FRONT: begun.spots[FRONT]}
    assert looking.look(begun._replace(spots=rolled), clamped(robot), both).anchor == FRONT


@pytest.mark.parametrize(
    ("phi_deg", "shape"), [(0, "fits"), (10, "fits"), (-10, "fits"), (11, "unknown")]
)
def test_a_part_that_is_turned_is_not_held_to_the_walls(robot, phi_deg: float, shape: str) -> None:
    looking = reckoner(robot, bend())
    begun = looking.begin(0.7, clamped(robot), IN_REAR)
    turned = looking.look(begun, clamped(robot, phi=radians(phi_deg)), IN_REAR)
    assert turned.shape == shape


def test_between_bars_nobody_asks_for_the_angle_of_the_roll_joint(robot: RobotSpec) -> None:
    looking = reckoner(robot, Route(planar(BORE_M, (Straight(3.0),))))
    for phi in (nan, 0.5):
        numbers = clamped(robot, phi=phi)
        assert looking.unknown(numbers) == []
        found = looking.look(looking.begin(0.8, numbers, IN_REAR), numbers, IN_REAR)
        assert not any(map(isnan, found.places_m))
        assert [z for _, _, z in found.chain.points] == [0.0] * 6
        assert found.shape == "fits"


def test_the_roll_joint_may_be_the_first_of_the_signals(robot: RobotSpec) -> None:
    roll = robot.body.roll
    swapped = tuple(roll if joint == 0 else joint for joint in robot.body.joints)
    looking = Reckoner(replace(robot.body, roll=0, joints=swapped), bend(), robot.odometry)
    numbers = clamped(robot, phi=nan)
    numbers[0], numbers[roll] = numbers[roll], numbers[0]
    begun = looking.begin(0.8, [0.0, *numbers[1:]], IN_REAR)
    assert looking.unknown(numbers) == [0]
    blind = looking.look(begun, numbers, IN_REAR)
    assert [isnan(place) for place in blind.places_m] == [True, True, False, False, False, False]


def test_a_robot_without_a_roll_joint_is_planar_in_a_round_pipe_too(robot: RobotSpec) -> None:
    body = replace(robot.body, roll=-1, roll_link=-1)
    numbers, looking = [*clamped(robot, phi=nan), 5.0], Reckoner(body, bend(), robot.odometry)
    found = looking.look(looking.begin(0.8, numbers, IN_REAR), numbers, IN_REAR)
    assert not any(map(isnan, found.places_m))
    assert found.chain.front == found.chain.rear
    assert found.shape == "fits"
