"""Runs of missions in the simulator, with every frame through the engine or without."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

from pirate_sm.backends.protocol import Backend, Completion
from pirate_sm.companion import entered
from pirate_sm.engine.gliding.glided import Glide
from pirate_sm.model.effects import Effect
from pirate_sm.model.events import Abort, Event
from pirate_sm.runtime.first_choice import FirstChoice
from pirate_sm.runtime.loop import MissionRun
from pirate_sm.wiring import Order, load, prepare


class Stepping:
    """A backend that cannot glide, so that every frame goes through the engine."""

    def __init__(self, backend: Backend) -> None:
        self._backend = backend
        self.name, self.real_time = backend.name, backend.real_time
        self.completion: Completion = backend.completion

    def open(self) -> Sequence[Event]:
        return self._backend.open()

    def submit(self, setpoint_id: int, values: tuple[float, ...]) -> None:
        self._backend.submit(setpoint_id, values)

    def advance(self, until_s: float) -> tuple[float, Sequence[Event]]:
        return self._backend.advance(until_s)

    def close(self) -> None:
        self._backend.close()


class Stop:
    """Ends a mission that takes too long."""

    listening = False

    def __init__(self, after_s: float) -> None:
        self.due_s = after_s

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        pass

    def speak(self, now_s: float) -> Sequence[Event]:
        self.due_s = inf
        return (Abort("long enough"),)


class Noted:
    """Notes every effect, with the time and the engine's state after it."""

    run: MissionRun

    def __init__(self) -> None:
        self.lines: list[str] = []

    def see(self, effects: Sequence[Effect], now_s: float) -> None:
        self.lines.append(f"{now_s!r} {effects!r} {self.run.state!r}")


def course(order: Order, *, glides: bool, after_s: float = inf) -> tuple[list[str], int]:
    """The effects of a run with all states, the truth at its end, and how many frames glided."""
    prepared = prepare(order, load(order))
    backend = prepared.backend if glides else Stepping(prepared.backend)
    taken = Taken(prepared.backend)
    noted = Noted()
    companions = (*prepared.companions, FirstChoice(), Stop(after_s))
    noted.run = MissionRun(prepared.engine, backend, observers=[noted], companions=companions)
    with entered(prepared.companions):
        result = noted.run.execute()
    noted.lines.append(f"{result!r} {noted.run.state!r} {prepared.backend.truth!r}")  # type: ignore[attr-defined]
    return noted.lines, taken.frames


class Taken:
    """Counts the frames that a simulator takes for the engine."""

    def __init__(self, backend: Backend) -> None:
        self.frames = 0
        self._glide = backend.glide  # type: ignore[attr-defined]
        backend.glide = self._count  # type: ignore[attr-defined]

    def _count(self, *given: object) -> Glide | None:
        passed: Glide | None = self._glide(*given)
        self.frames += len(passed.frames) if passed is not None else 0
        return passed


def assert_the_same(order: Order, after_s: float = inf) -> int:
    """Both ways lead to the same effects, states and truth; return how many frames glided."""
    glided, taken = course(order, glides=True, after_s=after_s)
    stepped, none = course(order, glides=False, after_s=after_s)
    for number, (one, other) in enumerate(zip(glided, stepped, strict=False)):
        assert one == other, f"{order}: effect {number}\n{one[:400]}\n{other[:400]}"
    assert len(glided) == len(stepped)
    assert none == 0
    return taken
