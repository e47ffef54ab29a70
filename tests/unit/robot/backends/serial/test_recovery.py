"""When something is due in a silence, something comes of it."""

from __future__ import annotations

import pytest

from pirate_sm.core.events import FaultReport, SensorFrame
from pirate_sm.robot.backends.serial.link.recovery import Outage, Recovery

WITHIN_S = 8.0


@pytest.fixture
def recovery() -> Recovery:
    return Recovery(brief_s=0.75, within_s=WITHIN_S, advice="power it off")


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
        assert now <= 0.5 + 3 * WITHIN_S, "it may come and go forever"
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
    outage.wrote_s = 5.0
    outage.relapse()
    outage.return_(5.05, {3}, safe_needed=True)
    assert recovery.wants_safe(outage, 5.05)


def back(at_s: float = 1.0, *boards: int, safe_needed: bool = True, gone: str = "") -> Outage:
    """A controller that was silent until now; these boards have reported before."""
    outage = Outage(heard_s=0.5, since_s=0.9, sign_s=0.5, gone=gone)
    outage.return_(at_s, set(boards), safe_needed)
    return outage


def check(recovery: Recovery, outage: Outage, due_s: float) -> FaultReport:
    """Nothing is decided before it is due, and something when it is."""
    assert recovery.due_s(outage) == due_s
    assert recovery.verdict(outage, due_s - 0.01, stopped=True) is None
    fault = recovery.verdict(outage, due_s, stopped=True)
    assert fault is not None
    return fault


@pytest.mark.parametrize(
    ("outage", "awake_s", "brief"),
    [
        (Outage(0.0, 0.4, 0.0), 0.7, True),
        (Outage(0.0, 0.4, 0.0), 0.75, False),
        (Outage(0.0, 0.4, 0.0, gone="the cable is out"), 0.1, False),
        (Outage(0.0, 0.4, 0.0, anew=True), 0.1, False),
    ],
)
def test_a_short_silence_is_no_outage_unless_the_port_went_or_it_had_to_be_asked(
    recovery: Recovery, outage: Outage, awake_s: float, brief: bool
) -> None:
    assert recovery.is_brief(outage, awake_s) == brief


@pytest.mark.parametrize(
    ("gone", "code", "message"),
    [
        ("", "link.silent", "the robot's controller has been silent for 6.0 s, however often"),
        ("it went", "link.lost", "the link to the robot is lost: it went, and was not back 6.0 s"),
    ],
)
def test_a_silence_that_lasts_is_given_up(
    recovery: Recovery, gone: str, code: str, message: str
) -> None:
    outage = Outage(heard_s=7.0, since_s=7.4, sign_s=5.0, gone=gone)

    fault = check(recovery, outage, due_s=5.0 + WITHIN_S)

    assert fault.code == code
    assert fault.message.startswith(message)


def test_a_controller_that_does_not_confirm_the_safe_array_is_reported(recovery: Recovery) -> None:
    outage = back(1.5, 3)
    outage.report(SensorFrame(3, (1.0,)))
    outage.wrote_s = 2.0
    assert recovery.due_s(outage) == 2.1
    outage.wrote_s = 1.5 + WITHIN_S - 0.05

    fault = check(recovery, outage, due_s=1.5 + WITHIN_S)

    assert fault.code == "link.no_echo"
    assert "is back after 1.0 s of silence and does not confirm" in fault.message


@pytest.mark.parametrize(
    ("gone", "code", "message"),
    [
        ("", "firmware.reset", "said nothing for 1.0 s, it was reset or hung"),
        ("it went", "link.interrupted", "the link was away for 1.0 s (it went) and is back"),
    ],
)
def test_boards_have_a_second_after_the_safe_array_is_confirmed(
    recovery: Recovery, gone: str, code: str, message: str
) -> None:
    outage = back(1.5, 3, 5, gone=gone)
    outage.report(SensorFrame(5, (1.0,)))
    outage.confirm(2.0)
    outage.confirm(2.5)

    fault = check(recovery, outage, due_s=3.0)

    assert fault.code == code
    assert message in fault.message


def test_a_controller_whose_boards_all_report_is_back_at_once(recovery: Recovery) -> None:
    outage = back(1.5, 3)
    outage.report(SensorFrame(3, (1.0,)))
    assert recovery.verdict(outage, 1.6, stopped=True) is None
    outage.confirm(2.0)

    assert recovery.due_s(outage) < 0.0
    fault = recovery.verdict(outage, 2.0, stopped=True)
    assert fault is not None
    assert fault.code == "firmware.reset"


def test_where_nothing_was_sent_before_no_array_is_asked_for(recovery: Recovery) -> None:
    outage = back(1.5, safe_needed=False)

    assert not recovery.wants_safe(outage, 2.0)
    assert outage.safe_s == 1.5
    fault = recovery.verdict(outage, 1.5, stopped=False)
    assert fault is not None
    assert "nothing had been sent to it before" in fault.message


@pytest.mark.parametrize("stopped", [True, False])
def test_a_controller_without_boards_says_whether_it_is_stopped(
    recovery: Recovery, stopped: bool
) -> None:
    outage = back(1.5, 3)
    if stopped:
        outage.confirm(2.0)
    outage.wrote_s = 1.5 + WITHIN_S

    fault = check(recovery, outage, due_s=1.5 + WITHIN_S)

    assert fault.code == "link.silent"
    assert ("does not confirm the safe setpoints" in fault.message) != stopped
    assert fault.message.endswith(": power it off")


def test_the_silence_that_is_told_is_the_first(recovery: Recovery) -> None:
    outage = back(3.0, 3)
    outage.heard_s = 3.5
    outage.relapse()
    outage.return_(4.0, {3}, safe_needed=True)
    outage.report(SensorFrame(3, (1.0,)))
    outage.confirm(4.5)

    fault = recovery.verdict(outage, 4.5, stopped=True)

    assert outage.answered_s == 3.0
    assert fault is not None
    assert "said nothing for 2.5 s" in fault.message
