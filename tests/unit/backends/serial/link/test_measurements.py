"""What becomes of readings."""

from __future__ import annotations

import pytest

from pirate_sm.backends.serial.link.measurements import Measurements
from pirate_sm.rosserial.state_messages import StateReading


@pytest.fixture
def measurements() -> Measurements:
    return Measurements({3: 2})


def test_readings_of_the_robots_boards_are_not_strange(measurements: Measurements) -> None:
    measurements.take(StateReading(3, 0, (1.0,)))
    measurements.take(StateReading(3, -1, (1.0, 2.0)))

    assert measurements.strange == 0


@pytest.mark.parametrize(
    "reading",
    [StateReading(4, 0, (1.0,)), StateReading(3, 2, (1.0,)), StateReading(3, -1, (1.0,))],
    ids=["another board", "another channel", "too few channels"],
)
def test_a_reading_that_the_robot_cannot_have_made_is_counted_and_makes_no_frame(
    measurements: Measurements, reading: StateReading
) -> None:
    assert measurements.take(reading) is None
    assert measurements.strange == 1
