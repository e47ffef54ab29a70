"""When something is due in a silence, something comes of it."""

from __future__ import annotations

import pytest

from pirate_sm.backends.serial.recovery import Outage, Recovery
from pirate_sm.model.events import FaultReport, SensorFrame

WITHIN_S = 8.0


@pytest.fixture
def recovery() -> Recovery:
    return Recovery(brief_s=0.75, within_s=WITHIN_S, advice="")


def fallen_silent_again(reported: bool) -> Outage:
    """A controller that spoke for a moment, was seen by its boards or not, and is silent again."""
    outage = Outage(heard_s=0.0, since_s=0.4, sign_s=0.0)
    outage.return_(1.0, {3}, safe_needed=True)
    if reported:
        outage.report(SensorFrame(3, (1.0,)))
    outage.sign_s = 2.0
    outage.relapse()
    return outage


@pytest.mark.parametrize(
    ("reported", "due_s", "message"),
    [
        (False, 1.0 + WITHIN_S, "none of its boards reports any more"),
        (True, 2.0 + WITHIN_S, "has been silent for 10.0 s"),
    ],
)
def test_a_controller_that_falls_silent_again_is_given_up_when_that_is_due_and_not_before(
    recovery: Recovery, reported: bool, due_s: float, message: str
) -> None:
    outage = fallen_silent_again(reported)

    assert recovery.due_s(outage) == due_s
    assert recovery.verdict(outage, due_s - 0.01, stopped=True) is None
    fault = recovery.verdict(outage, due_s, stopped=True)
    assert isinstance(fault, FaultReport)
    assert message in fault.message


def test_a_controller_that_comes_and_goes_is_given_up_in_the_end(recovery: Recovery) -> None:
    outage, now = Outage(heard_s=0.0, since_s=0.5, sign_s=0.0), 1.0
    while recovery.verdict(outage, now, stopped=True) is None:
        assert now <= 0.5 + 3 * WITHIN_S, "it may come and go for ever"
        outage.return_(now, {3}, safe_needed=True)
        outage.report(SensorFrame(3, (1.0,)))
        outage.sign_s = now
        outage.relapse()
        now += 0.5

    assert now == recovery.due_s(outage) == 0.5 + 3 * WITHIN_S
    fault = recovery.verdict(outage, now, stopped=True)
    assert fault is not None
    assert (fault.code, "has been silent for 24.5 s" in fault.message) == ("link.silent", True)


def test_boards_that_reported_before_a_relapse_do_not_hide_that_none_reports_after_it(
    recovery: Recovery,
) -> None:
    outage = fallen_silent_again(reported=True)
    outage.return_(4.0, {3, 5}, safe_needed=True)
    outage.confirm(4.5)

    assert outage.missing == {3, 5}
    assert outage.dumb
    assert recovery.due_s(outage) == 1.0 + WITHIN_S
    assert recovery.verdict(outage, 0.99 + WITHIN_S, stopped=True) is None
    fault = recovery.verdict(outage, 1.0 + WITHIN_S, stopped=True)
    assert fault is not None
    assert "none of its boards reports any more" in fault.message


def test_a_relapse_asks_for_the_safe_array_again(recovery: Recovery) -> None:
    outage = fallen_silent_again(reported=True)
    outage.confirm(2.5)  # an echo of before, which says nothing now
    assert not outage.stopped
    assert not recovery.wants_safe(outage, 3.0)

    outage.return_(4.0, {3}, safe_needed=True)
    assert recovery.wants_safe(outage, 4.0)
    outage.wrote_s = 4.0
    assert not recovery.wants_safe(outage, 4.05)
    assert recovery.wants_safe(outage, 4.1)
    outage.confirm(4.2)
    assert not recovery.wants_safe(outage, 5.0)
    outage.relapse()
    outage.return_(6.0, {3}, safe_needed=True)
    assert recovery.wants_safe(outage, 6.0)
