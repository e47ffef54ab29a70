from __future__ import annotations

import signal
from collections.abc import Callable, Sequence
from itertools import pairwise
from math import inf
from typing import Any

import pytest

from pirate_sm.core import effects as fx
from pirate_sm.core import events as ev
from pirate_sm.core.errors import BackendError
from pirate_sm.running.runtime.ending import BY_SIGNAL, Stop, StopRequests
from pirate_sm.running.runtime.loop import MissionRun

SAFE = (0.0, 0.5)
MOVING = (1.0, 0.5)
CTRL_C = Stop("interrupted by Ctrl-C", 130)


class FakeEngine:
    """Sends one array, then wakes every second; ends after `lasting` or as told.

    Its state is what it has seen: the list of (now, event).
    """

    def __init__(self, lasting: float = inf, react: Callable[[Any, float], tuple] | None = None):
        self.lasting = lasting
        self.react = react or (lambda event, now: ())
        self.seen: list[tuple[float, Any]] = []
        self.aborting: ev.Abort | None = None

    def start(
        self,
        now_s: float = 0.0,
        seen: Any = (),
        *,
        body: Any = None,
        paused: bool = False,
        resumed: Any = None,
    ) -> tuple[Any, tuple[fx.Effect, ...]]:
        return "state", (fx.Setpoints(1, MOVING), fx.WakeAt(now_s + 1.0))

    def step(self, state: Any, event: Any, now: float) -> tuple[Any, tuple[fx.Effect, ...]]:
        self.seen.append((now, event))
        if isinstance(event, ev.Abort):
            self.aborting = event
            return state, (fx.Setpoints(2, SAFE), fx.WakeAt(now + 2.0))
        if self.aborting and isinstance(event, ev.SubmitResult | ev.Tick):
            return state, (fx.Ended("interrupted", self.aborting.reason),)
        own = self.react(event, now)
        if now >= self.lasting:
            return state, (*own, fx.Ended("succeeded", "as planned", "done"))
        if isinstance(event, ev.Tick):
            return state, (*own, fx.WakeAt(now + 1.0))
        return state, own

    def safe_values(self, state: Any) -> tuple[float, ...]:
        return SAFE


class FakeBackend:
    """Accepts at once and says nothing else; `hooks` run before each advance."""

    name = "fake"
    completion = "measured"
    real_time = False

    def __init__(self, before_advance: Callable[[float], None] = lambda now: None):
        self.before_advance = before_advance
        self.now = 0.0
        self.submitted: list[tuple[int, tuple[float, ...]]] = []
        self.pending: list[ev.Event] = []
        self.closed = 0

    def open(self) -> Sequence[ev.Event]:
        return ()

    def submit(self, setpoint_id: int, values: tuple[float, ...]) -> None:
        self.submitted.append((setpoint_id, values))
        self.pending.append(ev.SubmitResult(setpoint_id, "accepted"))

    def advance(self, until_s: float) -> tuple[float, Sequence[ev.Event]]:
        self.before_advance(self.now)
        if self.pending:
            events, self.pending = self.pending, []
            return self.now, events
        self.now = min(until_s, self.now + 100.0)
        return self.now, ()

    def close(self) -> None:
        self.closed += 1


class Notes:
    def __init__(self) -> None:
        self.effects: list[fx.Effect] = []

    def see(self, effects: Sequence[fx.Effect], now_s: float) -> None:
        self.effects += effects


class FakeClock:
    def __init__(self, on_sleep: Callable[[float], None] = lambda now: None):
        self.time = 1000.0
        self.on_sleep = on_sleep

    def now(self) -> float:
        return self.time

    def sleep(self, seconds: float) -> None:
        self.time += seconds
        self.on_sleep(self.time)


def run(engine: FakeEngine, backend: FakeBackend, **options: Any):
    return MissionRun(engine, backend, **options).execute()  # type: ignore[arg-type]


def test_effects_go_to_the_backend_and_its_events_to_the_engine() -> None:
    engine, backend, notes = FakeEngine(lasting=3.0), FakeBackend(), Notes()

    result = run(engine, backend, observers=[notes])

    assert backend.submitted == [(1, MOVING)]
    assert engine.seen == [
        (0.0, ev.SubmitResult(1, "accepted")),
        (1.0, ev.Tick()),
        (2.0, ev.Tick()),
        (3.0, ev.Tick()),
    ]
    assert (result.exit_code, result.now_s, backend.closed) == (0, 3.0, 1)
    assert notes.effects[0] == fx.Setpoints(1, MOVING)
    assert notes.effects[-1] == fx.Ended("succeeded", "as planned", "done")


def test_nothing_is_given_to_the_engine_after_the_end() -> None:
    engine, backend = FakeEngine(lasting=0.0), FakeBackend()
    backend.pending = [ev.DetectorWord("a", 1.0), ev.DetectorWord("b", 1.0)]

    run(engine, backend)

    assert engine.seen == [(0.0, ev.DetectorWord("a", 1.0))]


@pytest.mark.parametrize("number", list(BY_SIGNAL))
def test_a_request_to_stop_goes_through_the_engines_safe_stop(number: int) -> None:
    requests = StopRequests()
    stop = BY_SIGNAL[number]
    engine = FakeEngine()
    backend = FakeBackend(lambda now: requests.ask(stop) if now >= 5.0 else None)

    result = run(engine, backend, requests=requests)

    assert backend.submitted[-1] == (2, SAFE)
    assert (5.0, ev.Abort(stop.reason)) in engine.seen or (
        6.0,
        ev.Abort(stop.reason),
    ) in engine.seen
    assert (result.ended.outcome, result.exit_code) == ("interrupted", stop.exit_code)


def test_who_insists_has_the_safe_array_sent_without_the_engine() -> None:
    requests, notes = StopRequests(), Notes()
    engine = FakeEngine()

    def twice(now: float) -> None:
        if now >= 5.0:
            requests.ask(CTRL_C)
            requests.insist()

    backend = FakeBackend(twice)

    result = run(engine, backend, requests=requests, observers=[notes])

    assert not any(isinstance(event, ev.Abort) for _, event in engine.seen)
    assert backend.submitted[-1] == (2, SAFE)
    assert backend.closed == 1
    assert (result.ended.outcome, result.exit_code) == ("interrupted", 130)
    assert notes.effects[-2:] == [fx.Setpoints(2, SAFE), result.ended]


@pytest.mark.parametrize("error", [BackendError("the cable is out"), ZeroDivisionError("oops")])
def test_a_backend_that_breaks_ends_in_the_safe_array_and_code_3(error: Exception) -> None:
    notes = Notes()

    def breaks(now: float) -> None:
        if now >= 3.0:
            raise error

    backend = FakeBackend(breaks)

    result = run(FakeEngine(), backend, observers=[notes])

    assert backend.submitted[-1] == (2, SAFE)
    assert backend.closed == 1
    assert (result.ended.outcome, result.exit_code, result.error) == ("fault", 3, error)
    assert str(error) in result.ended.message
    fault, _, _ = notes.effects[-3:]
    assert isinstance(fault, fx.Fault)
    assert fault.code == "backend.failed"


def test_a_backend_that_takes_nothing_any_more_still_ends_the_run() -> None:
    class Deaf(FakeBackend):
        def submit(self, setpoint_id: int, values: tuple[float, ...]) -> None:
            raise BackendError("the port is gone")

    backend, notes = Deaf(), Notes()

    result = run(FakeEngine(), backend, observers=[notes])

    assert result.exit_code == 3
    assert "the safe array could not be sent: the port is gone" in result.ended.message
    assert notes.effects[0] == fx.Setpoints(1, MOVING)  # what was tried is told


def test_a_backend_that_cannot_be_opened_is_sent_nothing() -> None:
    class Shut(FakeBackend):
        def open(self) -> Sequence[ev.Event]:
            raise BackendError("no such port")

    backend = Shut()

    result = run(FakeEngine(), backend)

    assert (result.exit_code, backend.submitted, backend.closed) == (3, [], 1)


def test_a_run_that_was_told_to_end_while_it_was_opened_says_so() -> None:
    requests = StopRequests()

    class Hanging(FakeBackend):
        def open(self) -> Sequence[ev.Event]:
            requests.ask(BY_SIGNAL[signal.SIGTERM])
            raise BackendError("the port does not answer")

    result = run(FakeEngine(), Hanging(), requests=requests)

    assert (result.ended.outcome, result.exit_code) == ("interrupted", 143)
    assert result.ended.message.startswith("asked to terminate (SIGTERM); the ")
    assert result.ended.message.endswith("the port does not answer")


def test_a_fault_of_ours_ends_in_the_safe_array_and_code_4() -> None:
    def breaks(event: Any, now: float) -> tuple:
        return (1 / 0,) if now >= 2.0 else ()

    backend = FakeBackend()

    result = run(FakeEngine(react=breaks), backend)

    assert backend.submitted[-1] == (2, SAFE)
    assert (result.ended.outcome, result.exit_code) == ("fault", 4)
    assert isinstance(result.error, ZeroDivisionError)


def test_an_engine_that_never_lets_time_pass_is_found_out() -> None:
    class Restless(FakeEngine):
        def step(self, state: Any, event: Any, now: float) -> tuple[Any, tuple]:
            return state, (fx.WakeAt(now),)

    result = run(Restless(), FakeBackend())

    assert result.exit_code == 4
    assert "stands still" in result.ended.message


def test_a_run_that_nobody_reads_any_more_stops() -> None:
    class Pipe(Notes):
        def see(self, effects: Sequence[fx.Effect], now_s: float) -> None:
            if now_s >= 2.0:
                raise BrokenPipeError(32, "Broken pipe")

    backend = FakeBackend()

    result = run(FakeEngine(), backend, observers=[Pipe()])

    assert backend.submitted[-1] == (2, SAFE)
    assert (result.ended.outcome, result.exit_code) == ("interrupted", 141)


def test_a_robots_fault_is_the_missions_failure_and_a_links_is_not() -> None:
    def faulty(code: str) -> Callable[[Any, float], tuple]:
        return lambda event, now: (
            fx.Fault("wheel.dead", "one", "continue"),
            fx.Fault(code, "why", "stop"),
            fx.Fault("robot.later", "in the safe stop", "stop"),
            fx.Ended("fault", "why"),
        )

    codes = {
        code: run(FakeEngine(react=faulty(code)), FakeBackend()).exit_code
        for code in ("robot.stuck", "link.lost", "backend.failed")
    }

    assert codes == {"robot.stuck": 1, "link.lost": 3, "backend.failed": 3}


def test_mission_time_is_held_to_a_multiple_of_the_walls() -> None:
    clock = FakeClock()

    run(FakeEngine(lasting=8.0), FakeBackend(), clock=clock, factor=4.0)

    assert clock.time - 1000.0 == pytest.approx(2.0)


def test_a_real_time_backend_is_not_held_back() -> None:
    clock, backend = FakeClock(), FakeBackend()
    backend.real_time = True

    run(FakeEngine(lasting=8.0), backend, clock=clock, factor=4.0)

    assert clock.time == 1000.0


def test_a_suspended_process_does_not_hurry_afterwards() -> None:
    slept: list[float] = []

    def suspend(now: float) -> None:
        slept.append(now)
        if len(slept) == 10:
            clock.time += 3600.0

    clock = FakeClock(suspend)

    run(FakeEngine(lasting=20.0), FakeBackend(), clock=clock, factor=1.0)

    assert clock.time - 1000.0 - 3600.0 == pytest.approx(20.0, abs=1.1)


def test_a_signal_cuts_a_paced_sleep_short() -> None:
    requests = StopRequests()
    clock = FakeClock(lambda now: requests.ask(CTRL_C) if now > 1000.5 else None)
    engine = FakeEngine(lasting=1e6)
    engine.start = lambda now_s=0.0, seen=(), **options: (
        "s",
        (fx.Setpoints(1, MOVING), fx.WakeAt(3600.0)),
    )  # type: ignore[method-assign]

    result = run(engine, FakeBackend(), clock=clock, factor=1.0, requests=requests)

    assert result.exit_code == 130
    assert clock.time - 1000.5 < 0.005  # s of the wall


def test_watchers_look_on_at_a_rate_of_the_walls_clock_even_in_a_long_sleep() -> None:
    looks: list[float] = []

    class Watcher:
        def pulse(self, now_s: float) -> None:
            looks.append(clock.time)

    clock = FakeClock()

    run(FakeEngine(lasting=4.0), FakeBackend(), clock=clock, factor=1.0, watchers=[Watcher()])

    gaps = [late - early for early, late in pairwise(looks)]
    assert 40 <= len(looks) <= 90
    assert max(gaps) <= 0.1
