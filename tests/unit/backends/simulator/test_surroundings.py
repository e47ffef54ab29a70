from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from pirate_sm.backends.simulator.geometry import Pipe
from pirate_sm.backends.simulator.surroundings import Surroundings, Vee, segment_of

from .conftest import DIAMETER_M, Driver, bend, straight


@pytest.mark.parametrize(
    ("first", "segment"), [(0.7, "Straight"), (1.2, "Joint"), (1.9, "Straight"), (2.5, "Out")]
)
def test_the_segment_is_where_the_robot_is(first: float, segment: str) -> None:
    arcs = [first - 0.1 * i for i in range(4)]
    assert segment_of(Pipe(bend()), arcs) == segment


def test_the_diameter_is_reported_once_a_part_is_clamped(place: Callable[..., Driver]) -> None:
    robot = place(straight(), clamped=0.0)
    surroundings = Surroundings({"front": Vee(1, 0.09, (0, 1, 2))}, 0.024)
    first = surroundings.look(robot.world, robot.world.values("arc"))
    assert first is not None
    assert first.segment == "Straight"
    assert math.isnan(first.diameter_m)
    assert surroundings.look(robot.world, robot.world.values("arc")) is None
    robot.clamp(1, 2, 3, 4)
    robot.run(7.0)
    report = surroundings.look(robot.world, robot.world.values("arc"))
    assert report is not None
    assert report.diameter_m == pytest.approx(DIAMETER_M, abs=2e-3)


def test_pitch_is_that_of_the_leg(place: Callable[..., Driver]) -> None:
    robot = place(bend(tilt_rad=math.radians(28)), at=1.8)
    report = Surroundings({}, 0.024).look(robot.world, robot.world.values("arc"))
    assert report is not None
    assert report.pitch_rad == pytest.approx(math.radians(28))
