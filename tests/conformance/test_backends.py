"""What every backend must do, whatever is behind it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from math import inf
from typing import get_args

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pirate_sm.backends.protocol import Backend, Completion
from pirate_sm.engine.engine import Engine
from pirate_sm.errors import BackendError
from pirate_sm.loading.mission import load_mission
from pirate_sm.model.events import Event, SubmitResult
from pirate_sm.runtime.companions import TriggerScript
from pirate_sm.runtime.loop import MissionRun

from .candidates import CANDIDATES, CLAMPING, NEWT, STILL, Candidate, LateBackend

MOST_CALLS = 10_000
SEND_AT_ONCE = {"trace", "late"}
"""Backends on which an array is never still to be sent."""


@pytest.fixture(params=CANDIDATES, scope="module")
def candidate(request: pytest.FixtureRequest) -> Candidate:
    return CANDIDATES[request.param]


@pytest.fixture
def backend(candidate: Candidate) -> Backend:
    return candidate.make(0)


def run_until(backend: Backend, until_s: float) -> list[tuple[float, Event]]:
    """Everything that is said up to this time, however often one must ask."""
    told: list[tuple[float, Event]] = []
    for _ in range(MOST_CALLS):
        now_s, events = backend.advance(until_s)
        assert now_s <= until_s
        told += [(now_s, event) for event in events]
        if now_s >= until_s and not events:
            return told
    raise AssertionError(f"{until_s} s are never reached")


def results(told: Sequence[tuple[float, Event]]) -> Counter[int]:
    return Counter(event.setpoint_id for _, event in told if isinstance(event, SubmitResult))


def test_it_says_what_it_is(backend: Backend) -> None:
    assert backend.name
    assert backend.completion in get_args(Completion)
    assert backend.real_time in (True, False)


def test_nothing_moves_before_the_first_array(candidate: Candidate, backend: Backend) -> None:
    backend.open()
    before = candidate.places(backend)
    told = run_until(backend, 3.0)

    assert results(told) == {}
    for (x0, y0), (x1, y1) in zip(before, candidate.places(backend), strict=True):
        assert (x1, y1) == (pytest.approx(x0, abs=1e-4), pytest.approx(y0, abs=1e-4))


def test_an_array_meets_exactly_one_fate(backend: Backend) -> None:
    backend.open()
    told = []
    for number in range(1, 6):
        backend.submit(number, CLAMPING)
        told += run_until(backend, number * 2.0)

    assert results(told) == dict.fromkeys(range(1, 6), 1)


def test_arrays_in_quick_succession_meet_one_fate_each_and_the_last_is_not_superseded(
    backend: Backend,
) -> None:
    backend.open()
    for number in range(1, 4):
        backend.submit(number, CLAMPING if number % 2 else STILL)
    told = run_until(backend, 3.0)

    fates = {e.setpoint_id: e.status for _, e in told if isinstance(e, SubmitResult)}
    assert results(told) == {1: 1, 2: 1, 3: 1}
    assert fates[3] != "superseded"


def test_a_newer_array_supersedes_one_that_has_not_been_sent(backend: Backend) -> None:
    backend.open()
    backend.submit(1, CLAMPING)
    backend.submit(2, STILL)
    told = run_until(backend, 3.0)

    first = "accepted" if backend.name in SEND_AT_ONCE else "superseded"
    assert [(e.setpoint_id, e.status) for _, e in told if isinstance(e, SubmitResult)] == [
        (1, first),
        (2, "accepted"),
    ]


def test_of_a_stream_each_array_meets_one_fate_and_none_is_accepted_after_a_newer_one(
    backend: Backend,
) -> None:
    backend.open()
    told = []
    for number in range(1, 41):
        backend.submit(number, CLAMPING if number % 2 else STILL)
        told += run_until(backend, number * 0.016)
    told += run_until(backend, 3.0)

    fates = [(e.setpoint_id, e.status) for _, e in told if isinstance(e, SubmitResult)]
    accepted = [number for number, status in fates if status == "accepted"]
    assert results(told) == dict.fromkeys(range(1, 41), 1)
    assert accepted == sorted(accepted)
    assert accepted[-1] == 40


def test_the_same_array_may_be_submitted_again(backend: Backend) -> None:
    backend.open()
    backend.submit(1, CLAMPING)
    told = run_until(backend, 2.0)
    backend.submit(1, CLAMPING)
    told += run_until(backend, 4.0)

    assert results(told) == {1: 2}


def test_a_result_comes_even_if_one_asks_without_a_limit(backend: Backend) -> None:
    backend.open()
    backend.submit(1, CLAMPING)
    for _ in range(MOST_CALLS):
        now_s, events = backend.advance(inf)
        if any(isinstance(event, SubmitResult) for event in events):
            return
    raise AssertionError(f"no result by {now_s} s")


@settings(max_examples=15)
@given(
    steps=st.lists(st.floats(0.0, 0.5), min_size=1, max_size=12),
    submits=st.sets(st.integers(0, 11)),
)
def test_time_neither_goes_back_nor_past_what_was_asked(
    candidate: Candidate, steps: list[float], submits: set[int]
) -> None:
    backend = candidate.make(0)
    backend.open()
    now_s = until_s = 0.0
    for number, step_s in enumerate(steps):
        if number in submits:
            backend.submit(number + 1, CLAMPING)
        until_s += step_s
        reached_s, _ = backend.advance(until_s)
        assert now_s <= reached_s <= until_s
        now_s = reached_s


def test_time_asked_for_that_has_passed_already_stands_still(backend: Backend) -> None:
    backend.open()
    run_until(backend, 1.0)

    now_s, events = backend.advance(0.5)

    assert (now_s, list(events)) == (1.0, [])


def test_equal_seeds_give_equal_events(candidate: Candidate) -> None:
    told = []
    for _ in range(2):
        backend = candidate.make(7)
        opened = list(backend.open())
        backend.submit(1, CLAMPING)
        first = run_until(backend, 2.0)
        backend.submit(2, STILL)
        told.append((opened, first, run_until(backend, 4.0)))

    assert repr(told[0]) == repr(told[1])


def test_it_may_be_closed_at_any_time_and_more_than_once(candidate: Candidate) -> None:
    unopened = candidate.make(0)
    unopened.close()
    backend = candidate.make(0)
    backend.open()
    backend.submit(1, CLAMPING)
    backend.close()
    backend.close()


def test_a_closed_one_takes_nothing_more_and_can_be_closed_again(backend: Backend) -> None:
    backend.open()
    backend.close()
    with pytest.raises(BackendError):
        backend.submit(1, STILL)
    backend.close()


def test_a_mission_runs_on_it_to_its_end(candidate: Candidate) -> None:
    backend = candidate.make(0)
    loaded = load_mission(NEWT / "take_hold.yaml", pipe=str(NEWT / "elbow.yaml"))
    engine = Engine(loaded.robot, loaded.program, nominal=backend.completion == "nominal")

    result = MissionRun(engine, backend, companions=[TriggerScript(loaded.program)]).execute()

    assert (result.ended.outcome, result.exit_code) == ("succeeded", 0)


@pytest.mark.parametrize("delay_s", [0.0, 0.05, 1.9, 10.0])
def test_a_slow_answer_delays_a_mission_and_does_not_break_it(delay_s: float) -> None:
    loaded = load_mission(NEWT / "take_hold.yaml")
    backend = LateBackend(delay_s, lose_every=1_000)
    engine = Engine(loaded.robot, loaded.program, nominal=True)

    result = MissionRun(engine, backend, companions=[TriggerScript(loaded.program)]).execute()

    assert result.ended.outcome == "succeeded"
    # Two commands; the fate of the safe array is awaited for 2 s at most.
    assert result.now_s == pytest.approx(2 * (2.0 + delay_s) + min(delay_s, 2.0))


def test_a_wire_that_loses_every_echo_ends_as_a_fault_of_the_link() -> None:
    loaded = load_mission(NEWT / "take_hold.yaml")
    engine = Engine(loaded.robot, loaded.program, nominal=True)

    result = MissionRun(engine, LateBackend(lose_every=1)).execute()

    assert (result.ended.outcome, result.exit_code) == ("fault", 3)
    assert "link.no_echo" in result.ended.message
