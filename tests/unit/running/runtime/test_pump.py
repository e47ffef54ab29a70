"""One step at a time: what a driver of its own can rely on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf
from pathlib import Path

import pytest

from pirate_sm.core.effects import CommandStatus, Effect, Ended, Setpoints
from pirate_sm.core.engine import Engine, EngineState
from pirate_sm.core.events import Event, OperatorCommand
from pirate_sm.core.loading import LoadedMission, load_mission
from pirate_sm.robot.backends.trace import TraceBackend
from pirate_sm.running.runtime.pump import BackendRaisedError, Pump
from pirate_sm.running.runtime.scripted_events import TriggerScript

ROOT = Path(__file__).parents[4]


@pytest.fixture(scope="module")
def loaded() -> LoadedMission:
    return load_mission(ROOT / "tests/robots/newt/patrol.yaml")


class Told:
    """Keeps what a pump tells."""

    def __init__(self) -> None:
        self.effects: list[tuple[float, Effect]] = []

    def __call__(self, effects: Sequence[Effect], now_s: float) -> None:
        self.effects += [(now_s, effect) for effect in effects]

    def of(self, kind: type) -> list[Effect]:
        return [effect for _, effect in self.effects if isinstance(effect, kind)]


@pytest.fixture
def told() -> Told:
    return Told()


@pytest.fixture
def pump(loaded: LoadedMission, told: Told) -> Pump:
    engine = Engine(loaded.robot, loaded.program, nominal=True)
    companions = [TriggerScript(loaded.program)]
    return Pump(engine, TraceBackend(), companions=companions, tell=told)


def test_nothing_happens_between_steps_and_steps_lead_to_the_end(pump: Pump, told: Told) -> None:
    pump.start()
    before = len(told.effects), pump.now_s
    assert (len(told.effects), pump.now_s) == before

    steps = 0
    while pump.ended is None:
        pump.take(*pump.wait())
        steps += 1

    assert steps > 10
    assert told.of(Ended) == [pump.ended]
    assert [at_s for at_s, _ in told.effects] == sorted(at_s for at_s, _ in told.effects)


def test_time_stops_where_the_driver_says(pump: Pump) -> None:
    pump.start(paused=True)
    while pump.now_s < 1.25:
        pump.take(*pump.wait(1.25))

    assert pump.now_s == 1.25


def test_events_of_the_driver_are_taken_between_steps(pump: Pump, told: Told) -> None:
    pump.start(paused=True)
    pump.give(OperatorCommand("HoldNose"))
    while pump.now_s < 5.0:
        pump.take(*pump.wait(5.0))

    statuses = [each.status for each in told.of(CommandStatus) if isinstance(each, CommandStatus)]
    assert statuses == ["sent", "accepted", "done"]


def test_an_abort_ends_through_the_engines_safe_stop(pump: Pump, told: Told) -> None:
    pump.start()
    pump.take(*pump.wait())
    pump.abort("enough")
    while pump.ended is None:
        pump.take(*pump.wait())

    assert (pump.ended.outcome, pump.ended.message) == ("interrupted", "enough")
    assert pump.open, "whoever drives it closes it"


def test_the_last_resort_sends_the_safe_array_closes_and_never_raises(
    pump: Pump, loaded: LoadedMission
) -> None:
    pump.start()
    pump._backend.close()

    *before, ended = pump.abandon(Ended("fault", "a bug"))

    assert [type(each) for each in before] == [Setpoints]
    assert isinstance(ended, Ended)
    assert "the safe array could not be sent: the trace is closed" in ended.message
    assert not pump.open


def test_what_a_backend_raises_comes_as_one_error_with_its_cause(
    pump: Pump, monkeypatch: pytest.MonkeyPatch
) -> None:
    def gone(until_s: float) -> tuple[float, Sequence[Event]]:
        raise OSError("gone")

    pump.start()
    monkeypatch.setattr(pump._backend, "advance", gone)

    with pytest.raises(BackendRaisedError) as caught:
        pump.wait()
    assert isinstance(caught.value.__cause__, OSError)


def test_a_companion_that_follows_reads_the_state_of_the_moment(loaded: LoadedMission) -> None:
    class Follower:
        due_s = inf
        listening = False

        def __init__(self) -> None:
            self.seen: list[EngineState | None] = []

        def follow(self, engine: Engine, state: Callable[[], EngineState | None]) -> None:
            self.state = state

        def react(self, effects: Sequence[Effect], now_s: float) -> None:
            self.seen.append(self.state())

        def speak(self, now_s: float) -> Sequence[Event]:
            return ()

    follower = Follower()
    engine = Engine(loaded.robot, loaded.program, nominal=True)
    pump = Pump(engine, TraceBackend(), companions=[follower])
    assert follower.state() is None
    pump.start()

    assert follower.seen[-1] is pump.state
