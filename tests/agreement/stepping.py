"""Runs of missions in the simulator, with every frame through the engine or without."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import cast

from benchmarks.gliding import Stepping, Taken
from pirate_sm.core.companion import entered
from pirate_sm.core.effects import Effect, WakeAt
from pirate_sm.core.events import Abort, Event, InSpace, Trail
from pirate_sm.core.sensing import Glide
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.running.wiring import Order, load, prepare
from pirate_sm.simulation.backend import SimulatorBackend


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
    """Notes every effect, with the time and the engine's state after it.

    While boards are listened to without the engine, it has no state of that time.
    """

    run: MissionRun

    def __init__(self) -> None:
        self.lines: list[str] = []

    def see(self, effects: Sequence[Effect], now_s: float) -> None:
        heard = all(isinstance(each, WakeAt) for each in effects)
        self.lines.append(f"{now_s!r} {effects!r} {'' if heard else self.run.state!r}")


class Kept:
    """Keeps every input and output of the engine; those of a block one by one."""

    stepwise = False
    due_s = inf

    def __init__(self) -> None:
        self.steps: list[str] = []
        self.blocks = 0

    def start(self, seen: object, now_s: float, effects: object, _: object = None) -> None:
        self.steps.append(f"{now_s!r} {seen!r} {effects!r}")

    def take(self, event: Event, now_s: float, effects: Sequence[Effect]) -> None:
        self.steps.append(f"{now_s!r} {event!r} {tuple(effects)!r}")

    def take_glide(self, glide: Glide) -> None:
        self.blocks += 1
        for now_s, event, effects in glide.in_order():
            self.take(event, now_s, effects)

    def abandon(self, now_s: float, effects: object) -> None:
        self.steps.append(f"{now_s!r} {effects!r}")


class Places(Kept):
    """Keeps where the robot is at each step."""

    backend: SimulatorBackend

    def __init__(self) -> None:
        super().__init__()
        self.places: list[tuple[float, object, InSpace]] = []
        self._trail: Trail | None = None

    def take(self, event: Event, now_s: float, effects: Sequence[Effect]) -> None:
        stood = None if self._trail is None else self._trail.at(now_s)
        if stood is None:
            self.places.append((now_s, self.backend.robot.wheels, self.backend.robot.in_space))
        else:
            self.places.append((now_s, stood.wheels, stood.space))

    def take_glide(self, glide: Glide) -> None:
        self._trail = glide.trail
        super().take_glide(glide)


def course(
    order: Order, *, glides: bool, after_s: float = inf, tap: Kept | None = None
) -> tuple[list[str], int]:
    """The effects of a run with all states, the truth at its end, and how many frames glided."""
    prepared = prepare(order, load(order))
    backend = prepared.backend if glides else Stepping(prepared.backend)
    taken = Taken(prepared.backend)
    if isinstance(tap, Places):
        tap.backend = cast(SimulatorBackend, prepared.backend)
    noted = Noted()
    companions = (*prepared.companions, FirstChoice(), Stop(after_s))
    noted.run = MissionRun(
        prepared.engine, backend, observers=[noted], companions=companions, tap=tap
    )
    with entered(prepared.companions):
        result = noted.run.execute()
    noted.lines.append(f"{result!r} {noted.run.state!r} {prepared.backend.truth!r}")  # type: ignore[attr-defined]
    return noted.lines, taken.frames


def assert_the_same(order: Order, after_s: float = inf) -> int:
    """Both ways lead to the same effects, states and truth; return how many frames glided."""
    glided, taken = course(order, glides=True, after_s=after_s)
    stepped, none = course(order, glides=False, after_s=after_s)
    for number, (one, other) in enumerate(zip(glided, stepped, strict=False)):
        assert one == other, f"{order}: effect {number}\n{one[:400]}\n{other[:400]}"
    assert len(glided) == len(stepped)
    assert none == 0
    return taken
