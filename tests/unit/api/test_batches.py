from __future__ import annotations

import numpy as np
import pytest

import pirate_sm
from benchmarks.batch import course_of, replayed
from pirate_sm.running.wiring import Order, load


@pytest.mark.thorough
@pytest.mark.parametrize("mission", ["take_bend", "take_elbow"])
@pytest.mark.parametrize("fidelity", ["usual", "fast"])
def test_robots_with_the_setpoints_of_a_mission_end_where_it_has_ended(
    mission: str, fidelity: str
) -> None:
    order = Order(mission, fidelity=fidelity)  # type: ignore[arg-type]
    loaded = load(order)
    course = course_of(loaded, order)

    robots = replayed(loaded, course, order, 3, 2).batch

    assert (robots.quantities == course.quantities).all()


def test_each_seed_is_a_robot_of_its_own() -> None:
    jitter = {"start_jitter_m": 0.02, "friction_jitter": 0.2}
    some = pirate_sm.batch("take_elbow", seeds=[3, 3, 4], **jitter)  # type: ignore[arg-type]
    some.advance(10)

    assert len(some) == 3
    assert (some.counts[0] == some.counts[1]).all()
    assert (some.values("arc")[0] != some.values("arc")[2]).all()


def test_robots_stand_where_the_mission_begins() -> None:
    some = pirate_sm.batch("take_elbow", seeds=[5])
    some.advance(100)

    assert np.abs(some.values("press")[0]).max() > 1.0  # it holds itself, clamped


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(pirate_sm.UsageError, match="trace simulates no robot"):
        pirate_sm.batch("take_elbow", seeds=[1], backend="trace")
    with pytest.raises(pirate_sm.UsageError, match="one robot at least"):
        pirate_sm.batch("take_elbow", seeds=[])
    with pytest.raises(pirate_sm.UsageError, match="threads: expected a whole number from 1 on"):
        pirate_sm.batch("take_elbow", seeds=[1], threads=0)
