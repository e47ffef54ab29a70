"""Dead reckoning is corrected at known bends, and only by what fits them."""

from __future__ import annotations

from math import asin, nan, pi, radians

import pytest

from pirate_sm.detectors.dead_reckoning import Reckoned, Spot
from pirate_sm.detectors.known_bends import KnownBends
from pirate_sm.detectors.leg_meetings import reached
from pirate_sm.engine.sensing.part_axes import axis_at
from pirate_sm.geometry.network import Mitre, Straight, planar
from pirate_sm.geometry.route import Route
from pirate_sm.loading import library
from pirate_sm.loading.robot import load_robot

FRONT, REAR = 0, 1
LEAN = asin((0.120 - 0.048) / 0.090)
OBLIQUE = asin((0.120 - 0.048) / 0.098)


@pytest.fixture(scope="module")
def robot():
    return load_robot(library.find_robot("pirate_ii")).normal


def numbers_of(robot, **changed: float) -> list[float]:
    """The rear lies along its leg, the front's first link leans to the wall of one at 90 deg."""
    signals = {
        "gamma_3": -(LEAN + OBLIQUE),
        "gamma_4": 2 * LEAN,
        "gamma_2": radians(-50),
        "gamma_1": OBLIQUE + radians(50) - pi / 2 - LEAN,
        "rear_diameter": 0.120,
        "front_diameter": 0.109,
        "phi": 0.0,
    } | changed
    numbers = [nan] * len(robot.vocabulary.numbers)
    for name, value in signals.items():
        names = robot.vocabulary.numbers
        if name.endswith("_diameter"):
            part = FRONT if name.startswith("front") else REAR
            numbers[robot.body.parts[part].diameter] = value
        else:
            numbers[names.index(name)] = value
    return numbers


def route_of(angle_deg: float = 90.0) -> Route:
    return Route(planar(0.120, (Straight(1.0), Mitre(radians(angle_deg)), Straight(1.0))))


def reckoned(route: Route, **spots: float) -> Reckoned:
    parts = {"front": FRONT, "rear": REAR}
    found = {parts[name]: Spot(at, route.piece_at(at)) for name, at in spots.items()}
    return Reckoned((), (), 0.0, REAR, found)


def corrected(robot, off_m: float, angle_deg: float = 90.0, **changed: float) -> float | None:
    """The place of the rear after a correction, against the true one; None without one."""
    body, route, numbers = robot.body, route_of(angle_deg), numbers_of(robot, **changed)
    axis = axis_at(body, numbers, REAR)
    assert axis is not None
    seen = reached(body, numbers, axis, FRONT, 1, 0.120)
    true_m = 1.0 - (seen.away_m if seen else 0.1)
    before = reckoned(route, rear=true_m + off_m)
    after = reckoned(route, rear=true_m + off_m, front=true_m + 0.2)
    found = KnownBends(body, route).corrected(before, after, numbers)
    return None if found is None else found.spots[REAR].middle_m - true_m


def test_the_bend_that_is_seen_is_one_of_90_deg(robot) -> None:
    axis = axis_at(robot.body, numbers_of(robot), REAR)
    assert axis is not None
    seen = reached(robot.body, numbers_of(robot), axis, FRONT, 1, 0.120)
    assert seen is not None
    assert seen.angle_rad == pytest.approx(pi / 2, abs=1e-6)
    assert seen.towards_rad == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("off_m", [0.0, 0.03, -0.05])
def test_an_error_up_to_half_a_link_is_corrected(robot, off_m: float) -> None:
    assert corrected(robot, off_m) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("off_m", "angle_deg", "changed"),
    [
        (0.08, 90, {}),
        (-0.08, 90, {}),
        (0.03, 60, {}),
        (0.03, 90, {"phi": radians(20)}),
        (0.03, 90, {"phi": nan}),
        (0.03, 90, {"rear_diameter": 0.110}),
        (0.03, 90, {"rear_diameter": nan}),
        (0.03, 90, {"gamma_1": -2 * LEAN, "gamma_2": LEAN + OBLIQUE}),
        (0.03, 90, {"gamma_1": nan}),
    ],
)
def test_what_does_not_fit_the_bend_changes_nothing(robot, off_m, angle_deg, changed) -> None:
    if changed.get("rear_diameter", 0.120) != 0.120:
        body, route = robot.body, route_of()
        before, after = reckoned(route, rear=0.9), reckoned(route, rear=0.9, front=1.1)
        numbers = numbers_of(robot, **changed)
        assert KnownBends(body, route).corrected(before, after, numbers) is None
        return
    assert corrected(robot, off_m, angle_deg, **changed) is None


def test_without_a_part_that_clamps_nothing_changes(robot) -> None:
    route = route_of()
    both = reckoned(route, rear=0.9, front=1.1)
    assert KnownBends(robot.body, route).corrected(both, both, numbers_of(robot)) is None
