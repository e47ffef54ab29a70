"""Frames that the simulator takes for the engine change nothing that the engine would not change.

Every effect comes at the same time, with the same state of the engine to the last bit of every
signal, and the robot ends where it would have ended.
"""

from __future__ import annotations

from random import Random

import pytest

from agreement.missions import invent
from agreement.robots import NEWT, PIRATE
from agreement.stepping import Kept, assert_the_same, course
from pirate_sm.loading import library
from pirate_sm.loading.robot import load_robot
from pirate_sm.wiring import Order

QUICK = ("climb", "enter_2d", "enter_3d", "inspect", "mitre_bend", "take_bend")
SHIPPED = [path.stem for path in library.missions()]
DEFECTS = sorted(load_robot(library.find_robot("pirate_ii")).profile.simulation.defects)
DETECTORS = ("sim", "odometry")
SOMEWHERE = {"start_jitter_m": 0.02, "friction_jitter": 0.2, "diameter_jitter_m": 0.002}

pytestmark = pytest.mark.timeout(300)  # the first run compiles


def test_most_frames_are_taken_for_the_engine() -> None:
    taken = assert_the_same(Order("mitre_bend"))

    assert taken > 1600  # of 1860


def test_a_recording_of_blocks_has_every_step() -> None:
    glided, stepped, order = Kept(), Kept(), Order("mitre_bend")
    _, taken = course(order, glides=True, tap=glided)
    course(order, glides=False, tap=stepped)

    assert taken > 1600
    assert 0 < glided.blocks < 300
    assert glided.steps == stepped.steps


def test_a_tap_that_looks_at_every_step_sees_every_step() -> None:
    tap = Kept()
    tap.stepwise = True

    assert course(Order("enter_2d"), glides=True, tap=tap)[1] == 0


@pytest.mark.parametrize("mission", [
    pytest.param(name, marks=() if name in QUICK else pytest.mark.slow) for name in SHIPPED
])  # fmt: skip
def test_shipped_missions(mission: str) -> None:
    assert_the_same(Order(mission))


@pytest.mark.parametrize("detector", DETECTORS)
@pytest.mark.parametrize("seed", [
    *range(1, 3), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(3, 13))
])  # fmt: skip
def test_robots_that_start_somewhere(seed: int, detector: str) -> None:
    mission = ("mitre_bend", "take_bend")[seed % 2]
    assert_the_same(Order(mission, seed=seed, detector=detector, **SOMEWHERE))


@pytest.mark.parametrize("detector", DETECTORS)
@pytest.mark.parametrize("defect", DEFECTS)
@pytest.mark.slow
def test_robots_with_a_defect(defect: str, detector: str) -> None:
    assert_the_same(Order("mitre_bend", seed=3, defects=(defect,), detector=detector))


def test_robots_with_two_defects() -> None:
    lot = Random(5)
    for seed in range(3):
        defects = tuple(lot.sample(DEFECTS, 2))
        assert_the_same(Order("mitre_bend", seed=seed, defects=defects), after_s=12.0)


@pytest.mark.parametrize("defect", ["wheels_3_4_dead", "gamma_2_stiff", "gamma_2_sticks"])
def test_defects_of_motors_and_of_values_let_frames_be_taken(defect: str) -> None:
    order = Order("climb", defects=(defect,))

    assert assert_the_same(order, after_s=8.0) > 200


@pytest.mark.parametrize("first", [
    0, *(pytest.param(first, marks=pytest.mark.slow) for first in range(10, 100, 10))
])  # fmt: skip
def test_missions_that_nobody_wrote(first: int) -> None:
    for seed in range(first, first + 10):
        invented = invent(seed, ("pirate", "newt", "made"))
        pipe = "mitre_90" if invented.words.path == PIRATE else str(NEWT / "elbow.yaml")
        order = Order(str(invented.write()), pipe=pipe, seed=seed, **SOMEWHERE)
        assert_the_same(order, after_s=6.0)
