"""What becomes of readings."""

from __future__ import annotations

import math

import pytest

from pirate_sm.core.events import SensorFrame
from pirate_sm.robot.backends.serial.link.exchange import Measurements
from pirate_sm.robot.rosserial.messages import StateReading


@pytest.fixture
def measurements() -> Measurements:
    return Measurements({3: 2})


def frames(measurements: Measurements, *readings: tuple[int, float]) -> list[SensorFrame | None]:
    """What each reading of a channel of board 3 completes."""
    return [measurements.take(StateReading(3, channel, (value,))) for channel, value in readings]


def test_a_message_of_a_whole_board_is_its_frame_without_what_follows(
    measurements: Measurements,
) -> None:
    for values in ((1.0, 2.0), (1.0, 2.0, 3.0)):
        assert measurements.take(StateReading(3, -1, values)) == SensorFrame(3, (1.0, 2.0))
    assert measurements.strange == 0


def test_a_board_is_reported_once_all_its_values_have_come_in_each_round(
    measurements: Measurements,
) -> None:
    found = frames(measurements, (0, 1.0), (1, 2.0), (0, 3.0), (1, 4.0))

    assert found == [None, SensorFrame(3, (1.0, 2.0)), None, SensorFrame(3, (3.0, 4.0))]
    assert measurements.strange == 0


def test_in_place_of_a_lost_value_the_one_before_is_reported_when_the_next_round_begins(
    measurements: Measurements,
) -> None:
    frames(measurements, (0, 1.0), (1, 2.0))

    found = frames(measurements, (0, 3.0), (0, 5.0), (1, 6.0), (0, 7.0))

    assert found == [None, SensorFrame(3, (3.0, 2.0)), SensorFrame(3, (5.0, 6.0)), None]


def test_the_next_round_is_whole_only_with_all_of_its_own_values() -> None:
    measurements = Measurements({3: 3})

    found = frames(measurements, (0, 1.0), (1, 2.0), (0, 3.0), (1, 4.0), (2, 5.0))

    assert [frame is not None for frame in found] == [False, False, True, False, True]
    assert found[-1] == SensorFrame(3, (3.0, 4.0, 5.0))


def test_a_value_that_never_came_is_unknown(measurements: Measurements) -> None:
    _, frame = frames(measurements, (1, 1.0), (1, 2.0))

    assert frame is not None
    assert math.isnan(frame.values[0])
    assert frame.values[1] == 1.0


@pytest.mark.parametrize(
    "reading",
    [StateReading(4, 0, (1.0,)), StateReading(3, 2, (1.0,)), StateReading(3, -1, (1.0,))],
    ids=["another board", "another channel", "too few channels"],
)
def test_a_reading_that_the_robot_cannot_have_made_is_counted_and_makes_no_frame(
    measurements: Measurements, reading: StateReading
) -> None:
    assert measurements.take(reading) is None
    assert measurements.take(reading) is None
    assert measurements.strange == 2
