"""Runs a mission as the command line does, without its words, and keeps what happened."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import inf
from pathlib import Path
from typing import Any

import pytest

from pirate_sm.core.effects import Effect, Ended, Setpoints, StateChange, TriggerFired
from pirate_sm.core.engine import EngineState
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.running.wiring import Order, Prepared, prepare

ROOT = Path(__file__).resolve().parents[2]


@dataclass
class Record:
    """What happened in a run, in order."""

    prepared: Prepared
    effects: list[Effect] = field(default_factory=list)
    state: EngineState | None = None

    def see(self, effects: Sequence[Effect], now_s: float) -> None:
        self.effects += effects

    def of(self, kind: type) -> list[Any]:
        return [effect for effect in self.effects if isinstance(effect, kind)]

    @property
    def ended(self) -> Ended:
        return self.of(Ended)[-1]

    @property
    def states(self) -> list[tuple[str, ...]]:
        return [change.states for change in self.of(StateChange)]

    @property
    def fired(self) -> list[str]:
        return [fired.trigger for fired in self.of(TriggerFired)]

    @property
    def last_setpoints(self) -> dict[str, float]:
        names = [slot.name for slot in self.prepared.loaded.robot.slots]
        return dict(zip(names, self.of(Setpoints)[-1].values, strict=True))


@pytest.fixture
def run() -> Callable[..., Record]:
    """Runs a mission; keywords are those of `Order`. Nobody sits at the keyboard."""

    def run_it(mission: str | Path, **order: Any) -> Record:
        prepared = prepare(Order(str(mission), **order))
        record = Record(prepared)
        mission_run = MissionRun(
            prepared.engine,
            prepared.backend,
            observers=[record],
            companions=[*prepared.companions, FirstChoice()],
            factor=inf,
        )
        mission_run.execute()
        record.state = mission_run.state
        return record

    return run_it
