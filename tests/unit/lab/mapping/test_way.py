"""The way of a robot whose parts do not agree on it."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from pirate_sm.core import library
from pirate_sm.core.loading import load_robot
from pirate_sm.lab.mapping.places import Way


@pytest.fixture
def way() -> Way:
    return Way(load_robot(library.find_robot("pirate_ii")).normal)


def look(at_s: float, front_m: float, rear_m: float):
    """A look at which the odometers of the two parts have counted this."""

    def travelled(_, wheels):
        return front_m if 0 in wheels else rear_m

    return SimpleNamespace(at_s=at_s, travelled=travelled)


def test_of_two_parts_the_one_counts_that_has_rolled_less(way: Way) -> None:
    way.until(look(0.0, 0.0, 0.0), [0, 1], {})
    for step in range(1, 101):  # first the front slips, then the rear
        front_m = 0.011 * min(step, 50) + 0.010 * max(step - 50, 0)
        rear_m = 0.010 * min(step, 50) + 0.012 * max(step - 50, 0)
        found = way.until(look(0.1 * step, front_m, rear_m), [0, 1], {})[0]
    assert found == pytest.approx(1.0, abs=0.01)


def test_backward_the_same_holds(way: Way) -> None:
    way.until(look(0.0, 0.0, 0.0), [0, 1], {})
    for step in range(1, 51):
        found = way.until(look(0.1 * step, -0.011 * step, -0.010 * step), [0, 1], {})[0]
    assert found == pytest.approx(-0.5, abs=0.01)


def test_a_part_that_does_not_hold_does_not_count(way: Way) -> None:
    way.until(look(0.0, 0.0, 0.0), [1], {})
    for step in range(1, 51):
        found = way.until(look(0.1 * step, 0.0, 0.010 * step), [1], {})[1]
    assert found == pytest.approx(0.5)


def test_a_part_that_the_joints_push_ahead_travels_farther(way: Way) -> None:
    way.until(look(0.0, 0.0, 0.0), [0, 1], {0: 0.0, 1: -0.20})
    for step in range(1, 51):  # as in a pipe that narrows: the robot grows longer by 40 mm
        apart_m = 0.20 + 0.0008 * step
        places_m = {0: 0.0, 1: -apart_m}
        found = way.until(look(0.1 * step, 0.0108 * step, 0.010 * step), [0, 1], places_m)
    assert found == pytest.approx([0.54, 0.50], abs=0.001)


def test_small_differences_do_not_add_up(way: Way) -> None:
    way.until(look(0.0, 0.0, 0.0), [0, 1], {})
    for step in range(1, 1001):
        wrong_m = 0.002 * (step % 2)
        found = way.until(look(0.1 * step, 0.01 * step + wrong_m, 0.01 * step), [0, 1], {})
    assert found == pytest.approx([10.0, 10.0], abs=0.003)


def test_in_a_bend_both_sides_count_alike() -> None:
    way = Way(load_robot(library.find_robot("pirate_ii")).normal)

    def at(step: int):
        # Wheel 2 rolls on the inner side, wheels 1 and 3 on the outer one.
        ways_m = {(1,): 0.008 * step, (0, 2): 0.012 * step, (0, 1, 2): 0.012 * step}
        return SimpleNamespace(at_s=0.1 * step, travelled=lambda _, w: ways_m.get(w, 0.0))

    for step in range(51):
        around = way.until(at(step), [0], {}, bent=[0])
    assert around[0] == pytest.approx(0.5)
