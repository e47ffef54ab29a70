"""Surroundings and defects need nothing of a physics but its protocol."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from pirate_sm.core._model.pipe import Blockage
from pirate_sm.core.loading import load_robot
from pirate_sm.core.models import Defect, Pipe, Straight
from pirate_sm.simulation.simulated_robot import SimulatedRobot

from .candidates import NEWT
from .obedient import ObedientPhysics

WHEEL_RADIUS_M = 0.02
FULL_SPEED_RAD_S = 5.0


def driven(seconds: float, *, defect: Defect | None = None, **pipe: object) -> SimulatedRobot:
    """The newt after it has driven ahead with all wheels at half speed."""
    profile = load_robot(NEWT).profile
    place = Pipe.model_validate(
        {"diameter": 0.095, "segments": (Straight(straight=3.0),), "start": {"at": 1.0}, **pipe}
    )
    defects = [(defect, np.random.default_rng(0))] if defect else []
    robot = SimulatedRobot(profile, place, ObedientPhysics, seed=0, more_defects=defects)
    wheels = {wheel.name: 0.5 * wheel.direction for wheel in profile.body.wheels}
    robot.set_values([wheels.get(slot.wheel or "", 0.0) for slot in profile.slots])
    turns = itertools.cycle(robot.turns(one_value=False))
    for cycle in range(round(seconds / profile.link.cycle)):
        robot.step(profile.link.cycle * (cycle + 1), next(turns))
        robot.meet_obstacles()
    return robot


def test_wheels_roll_without_slip() -> None:
    robot = driven(4.0)
    way_m = 4.0 * 0.5 * FULL_SPEED_RAD_S * WHEEL_RADIUS_M
    assert robot.truth.distance_m == pytest.approx(way_m)
    count = robot.electronics.counts[robot.electronics.rows["roll_a"]]
    assert count == pytest.approx(way_m / WHEEL_RADIUS_M / math.tau * 2000, abs=12)


def test_an_obstacle_stops_it() -> None:
    robot = driven(4.0, blockages=(Blockage(at=1.1, lasting=60.0),))
    assert robot.arcs_m[0] == pytest.approx(1.1 - WHEEL_RADIUS_M)


def test_a_robot_that_has_left_the_pipe_is_gone() -> None:
    assert driven(4.0, segments=(Straight(straight=1.05),), start={"at": 1.0}).gone is False
    assert driven(60.0, segments=(Straight(straight=1.05),), start={"at": 1.0}).gone


def test_a_dead_wheel_shows_nothing_and_drives_nothing() -> None:
    dead = Defect(kind="dead_wheel", description="", wheels=("left_fore",))
    robot = driven(4.0, defect=dead)
    assert robot.truth.distance_m == pytest.approx(0.75 * driven(4.0).truth.distance_m)
    assert robot.electronics.counts[robot.electronics.rows["roll_a"]] == 0.0


def test_a_reset_stops_it_and_sets_its_counters_to_zero() -> None:
    reset = Defect(kind="firmware_reset", description="", after=2.0)
    robot = driven(4.0, defect=reset)
    assert robot.truth.distance_m == pytest.approx(0.5 * driven(4.0).truth.distance_m, rel=0.02)
    assert robot.electronics.counts[robot.electronics.rows["roll_a"]] == 0.0
