"""The joints of a route as detectors count them."""

from __future__ import annotations

from math import isnan, pi, radians, sqrt, tan

import pytest

from pirate_sm.core._geometry.network import (
    Elbow,
    Mitre,
    Network,
    NetworkRun,
    Reducer,
    Straight,
    Tee,
    planar,
)
from pirate_sm.core._geometry.route import Bend, Route, RouteJoint, bend_at

DIAMETER_M = 0.12


def elbow(turn_deg: float, behind_m: float) -> RouteJoint:
    return RouteJoint("elbow", 1.5, behind_m, behind_m, radians(turn_deg))


@pytest.mark.parametrize("kind", ["mitre", "tee", "reducer"])
def test_where_walls_meet_at_once_there_is_no_reach(kind: str) -> None:
    joint = RouteJoint(kind, 1.5, 0.06, 0.06, pi / 2)  # type: ignore[arg-type]

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


def test_a_route_may_begin_with_a_fitting() -> None:
    (joint,) = Route(planar(0.12, (Elbow(pi / 2, 0.2), Straight(1.0)))).joints

    half_m = 0.2 * pi / 4
    assert joint[:5] == pytest.approx(("elbow", half_m, half_m, half_m, pi / 2))


def test_a_sudden_step_between_two_runs_is_a_reducer_without_length() -> None:
    runs = {
        "wide": NetworkRun(0.12, (Straight(1.0),), ends="sleeve"),
        "narrow": NetworkRun(0.11, (Straight(1.0), Straight(0.5)), begins="sleeve"),
    }
    (joint,) = Route(Network(runs, {"all": ("wide", "narrow")})).joints

    assert joint[:5] == ("reducer", 1.0, 0.0, 0.0, 0.0)
    assert isnan(joint.towards_rad)


def test_a_tee_into_a_narrower_run_is_one_joint() -> None:
    runs = {
        "trunk": NetworkRun(0.12, (Straight(1.0),), ends="tee"),
        "on": NetworkRun(0.1, (Straight(1.0),), begins="tee.on"),
        "branch": NetworkRun(0.1, (Straight(1.0),), begins="tee.branch"),
    }
    network = Network(
        runs, {"on": ("trunk", "on"), "off": ("trunk", "branch")}, tees={"tee": Tee()}
    )
    (on,), (off,) = Route(network, "on").joints, Route(network, "off").joints

    assert on[:5] == pytest.approx(("tee", 1.0, 0.05, 0.06, 0.0))
    assert off[:5] == pytest.approx(("tee", 1.0, 0.05, 0.06, pi / 2))
    assert (on.junction, off.junction) == ("tee", "tee")


def test_a_reducer_reaches_from_its_beginning_to_its_end() -> None:
    parts = (Straight(1.0), Reducer(0.06, 0.1), Straight(1.0))
    (joint,) = Route(planar(0.12, parts)).joints

    assert joint[:5] == pytest.approx(("reducer", 1.0, 0.0, 0.06, 0.0))


@pytest.mark.parametrize(("turn", "towards"), [(1, 0.0), (-1, pi)])
def test_a_mitre_takes_as_much_wall_before_the_crossing_as_after_it(
    turn: int, towards: float
) -> None:
    parts = (Straight(1.0), Mitre(turn * pi / 3), Straight(0.5))
    (joint,) = Route(planar(0.12, parts)).joints

    taken_m = 0.06 * tan(pi / 6)
    assert joint[:5] == pytest.approx(("mitre", 1.0, taken_m, taken_m, pi / 3))
    assert abs(joint.towards_rad) == pytest.approx(towards)


def test_an_elbow_between_straights_is_named_by_its_middle() -> None:
    parts = (Straight(1.0), Elbow(pi / 2, 0.2, roll_rad=0.5), Straight(0.5))
    (joint,) = Route(planar(0.12, parts)).joints

    half_m = 0.2 * pi / 4
    assert joint[:6] == pytest.approx(("elbow", 1.0 + half_m, half_m, half_m, pi / 2, 0.5))


def test_a_tee_opens_towards_its_branch_wherever_the_route_goes() -> None:
    runs = {
        "trunk": NetworkRun(0.12, (Straight(1.0),), ends="tee"),
        "on": NetworkRun(0.12, (Straight(1.0),), begins="tee.on"),
        "branch": NetworkRun(0.12, (Straight(1.0),), begins="tee.branch"),
    }
    tees = {"tee": Tee(roll_rad=0.5)}
    network = Network(runs, {"on": ("trunk", "on"), "off": ("trunk", "branch")}, tees=tees)
    (on,), (off,) = Route(network, "on").joints, Route(network, "off").joints

    assert (on.turn_rad, off.turn_rad) == pytest.approx((0.0, pi / 2))
    assert (on.towards_rad, off.towards_rad) == pytest.approx((0.5, 0.5))
