from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pirate_sm.core import effects as fx
from pirate_sm.core import events as ev
from pirate_sm.running.runtime.loop import MissionRun


class Engine:
    """Counts what it has seen, ends after a second."""

    def start(
        self,
        now_s: float = 0.0,
        seen: Any = (),
        *,
        body: Any = None,
        paused: bool = False,
        resumed: Any = None,
    ) -> tuple[int, tuple[fx.Effect, ...]]:
        return 0, (fx.WakeAt(1.0),)

    def step(self, state: int, event: Any, now: float) -> tuple[int, tuple[fx.Effect, ...]]:
        ended = (fx.Ended("succeeded", "", ""),) if isinstance(event, ev.Tick) else ()
        return state + 1, ended


class Backend:
    name = "fake"
    completion = "measured"
    real_time = False

    def open(self) -> Sequence[ev.Event]:
        return ()

    def advance(self, until_s: float) -> tuple[float, Sequence[ev.Event]]:
        return until_s, ()

    def close(self) -> None:
        pass


class Onlooker:
    listening = False

    def __init__(self) -> None:
        self.due_s = 0.25
        self.seen: list[tuple[float, int]] = []

    def react(self, effects: Sequence[fx.Effect], now_s: float) -> None:
        pass

    def look(self, state: Any, now_s: float) -> Sequence[fx.Log]:
        self.seen.append((now_s, state))
        return (fx.Log("warning", "look"),) if now_s == 0.5 else ()

    def speak(self, now_s: float) -> Sequence[ev.Event]:
        self.due_s = now_s + 0.25
        return (ev.DetectorWord("near", 1.0),)


class Notes:
    def __init__(self) -> None:
        self.effects: list[fx.Effect] = []

    def see(self, effects: Sequence[fx.Effect], now_s: float) -> None:
        self.effects += effects


def test_an_onlooker_sees_the_state_each_time_before_it_speaks_and_its_logs_are_reported() -> None:
    onlooker, notes = Onlooker(), Notes()
    MissionRun(
        Engine(),
        Backend(),
        companions=[onlooker],
        observers=[notes],  # type: ignore[arg-type]
    ).execute()
    assert onlooker.seen[:3] == [(0.25, 0), (0.5, 1), (0.75, 2)]
    assert [each for each in notes.effects if isinstance(each, fx.Log)] == [
        fx.Log("warning", "look")
    ]
