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
