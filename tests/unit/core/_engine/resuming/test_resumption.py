"""With what a mission goes on after a crash."""

from __future__ import annotations

from dataclasses import replace
from math import isnan

import pytest
from driving import BOTH_CLAMPED, IDLE

from pirate_sm.core._engine.resuming.hypotheses import hypotheses
from pirate_sm.core._engine.resuming.resumption import Resumption, resumption
from pirate_sm.core._engine.state import Counted
from pirate_sm.core._engine.unwatched import DarkWay

WIDTH_M = 0.05
OPEN = DarkWay(0.1, 0.5, False, "")
EXACT = DarkWay(0.2, 0.2, True, "")


@pytest.fixture
def driver(drive):
    """A robot of which the width of the bound, and what its mission counts and claims, is known."""
    driver = drive(IDLE, states=BOTH_CLAMPED)
    driver.run(0.5)
    last = driver.state
    distance = last.sensing.distance._replace(width_m=WIDTH_M)
    sensing = last.sensing._replace(distance=distance)
    mission = last.mission._replace(
        counts_from=Counted(1.0, 0.1, 2.0),
        claim=Counted(3.0, 0.2, 4.0),
        origin=tuple(float(at) for at in range(len(sensing.numbers))),
    )
    driver.state = last._replace(sensing=sensing, mission=mission)
    return driver


def resumed(driver, way: DarkWay, robot=None, **mission) -> Resumption:
    last = driver.state._replace(mission=driver.state.mission._replace(**mission))
    program = driver.engine.program
    body = hypotheses(driver.robot, program, last)[0]
    found = resumption(robot or driver.robot, program, last, driver.now, body, way)
    assert isinstance(found, Resumption)
    return found


def test_the_bound_of_the_distance_grows_by_half_of_what_the_way_may_be(driver):
    found = resumed(driver, OPEN)

    assert found.distance.width_m == pytest.approx(WIDTH_M + 0.2)
    assert resumed(driver, EXACT).distance.width_m == WIDTH_M


def test_what_the_mission_counts_and_claims_goes_on(driver):
    found = resumed(driver, EXACT)

    assert found.counts_from == Counted(1.0, 0.1, 2.0)
    assert found.claim == Counted(3.0, 0.2, 4.0)


@pytest.mark.parametrize(
    ("pressed", "paused"),
    [({}, False), ({"paused_s": 0.3}, True), ({"pause_wanted": True}, True)],
)
def test_a_pause_stays_whether_it_has_begun_or_was_only_asked_for(driver, pressed, paused):
    assert resumed(driver, EXACT, **pressed).paused == paused


@pytest.mark.parametrize("odometry", [0, 1, None])
def test_a_way_that_is_not_known_leaves_the_position_open(driver, odometry):
    robot = driver.robot if odometry is None else replace(driver.robot, odometry=odometry)

    assert resumed(driver, OPEN, robot).adrift
    assert not resumed(driver, EXACT, robot).adrift


def test_a_robot_without_odometry_has_no_position_to_lose(driver):
    assert not resumed(driver, OPEN, replace(driver.robot, odometry=-1)).adrift


def test_only_counters_that_were_seen_to_count_on_count_on(driver):
    first, *others = (wheel.angle for wheel in driver.robot.wheels)
    odometry = driver.robot.odometry

    origin = resumed(driver, EXACT._replace(seen=frozenset({first}))).entry.origin

    assert (origin[first], origin[odometry]) == (first, odometry)
    assert all(isnan(origin[at]) for at in others)
    assert isnan(resumed(driver, OPEN).entry.origin[odometry])
