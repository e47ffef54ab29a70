from __future__ import annotations

from math import inf

import pytest

from pirate_sm.backends.trace import TraceBackend
from pirate_sm.errors import BackendError
from pirate_sm.model.events import SubmitResult


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
    with pytest.raises(BackendError, match="waits for ever"):
        TraceBackend().advance(inf)
