"""A robot is known to be stopped by an echo of what was written after it was last driven."""

from __future__ import annotations

import pytest

from pirate_sm.robot.backends.serial.link.recovery import StopConfirmation

DRIVE, STOP = (7, 1), (7, 0)


@pytest.fixture
def stopped() -> StopConfirmation:
    return StopConfirmation((1,))


def test_what_was_never_driven_is_stopped(stopped: StopConfirmation) -> None:
    stopped.wrote(1, STOP)

    assert stopped.confirmed


def test_what_was_driven_is_stopped_by_the_echo_and_not_by_the_writing(
    stopped: StopConfirmation,
) -> None:
    stopped.wrote(1, DRIVE)
    stopped.wrote(2, STOP)
    assert not stopped.confirmed

    stopped.echoed(2, STOP)
    assert stopped.confirmed


def test_the_late_echo_of_an_older_stop_confirms_nothing(stopped: StopConfirmation) -> None:
    stopped.wrote(1, STOP)
    stopped.wrote(2, DRIVE)
    stopped.echoed(1, STOP)

    assert not stopped.confirmed


def test_a_stop_that_arrived_damaged_is_none(stopped: StopConfirmation) -> None:
    stopped.wrote(1, DRIVE)
    stopped.wrote(2, STOP)
    stopped.echoed(2, DRIVE)

    assert not stopped.confirmed
