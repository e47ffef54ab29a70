from __future__ import annotations

from math import inf

import pytest

from pirate_sm.core.errors import BackendError
from pirate_sm.core.events import SignalReport, SubmitResult
from pirate_sm.robot.backends.trace import TraceBackend, Verdicts


def test_every_array_is_accepted_at_the_moment_it_is_submitted() -> None:
    trace = TraceBackend()
    trace.advance(3.5)
    trace.submit(1, (0.0,))
    trace.submit(2, (1.0,))

    assert trace.advance(100.0) == (
        3.5,
        (SubmitResult(1, "accepted"), SubmitResult(2, "accepted")),
    )


def test_time_jumps_as_far_as_it_may() -> None:
    assert TraceBackend().advance(86_400.0) == (86_400.0, ())


def test_a_wait_for_nothing_is_told_instead_of_lasting_for_ever() -> None:
    with pytest.raises(BackendError, match="waits forever"):
        TraceBackend().advance(inf)


def test_arrays_wait_for_what_a_script_decides_in_their_order() -> None:
    verdicts = Verdicts(scripted=True)
    trace = TraceBackend(verdicts)
    trace.submit(1, (0.0,))
    trace.submit(2, (1.0,))

    assert trace.advance(1.0) == (1.0, ())
    verdicts.decide("rejected", "so it is")
    assert trace.advance(2.0) == (1.0, (SubmitResult(1, "rejected", "so it is"),))
    assert trace.advance(2.0) == (2.0, ())
    verdicts.release()
    assert trace.advance(3.0) == (2.0, (SubmitResult(2, "accepted"),))


def test_an_array_that_is_sent_again_has_one_fate() -> None:
    verdicts = Verdicts(scripted=True)
    trace = TraceBackend(verdicts)
    trace.submit(1, (0.0,))
    trace.submit(1, (0.0,))
    verdicts.release()

    assert trace.advance(1.0) == (0.0, (SubmitResult(1, "accepted"),))


def test_what_a_script_shows_at_the_start_is_known_when_it_is_open() -> None:
    report = SignalReport((("way", 1.0),))

    assert TraceBackend(known=(report,)).open() == (report,)
