"""Drives the console as a person would, in a time that only the test lets pass."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, replace
from functools import cache, partial
from math import inf
from pathlib import Path
from threading import Condition
from typing import Any

from textual.pilot import Pilot
from textual.widgets import OptionList
from textual.worker import WorkerCancelled, WorkerFailed

from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import Wait
from pirate_sm.core.robot import states_of
from pirate_sm.running.runtime.pump import Resuming
from pirate_sm.running.wiring import Order, Prepared, load, prepare
from pirate_sm.views.console.app import Console
from pirate_sm.views.console.availability import look_at_entries
from pirate_sm.views.console.missions import without_mission
from pirate_sm.views.console.session import Keep, OperatorSession, unkept
from pirate_sm.views.showing.snapshot import Snapshot

ROOT = Path(__file__).parents[2]
WALL_S = 30.0
"""Nothing here takes so long; a test that hangs says so."""

STORY_S = 2 * WALL_S
"""No story of an operator takes so long."""


class HandClock:
    """A clock of which the test turns the hand: a sleeper wakes when it has come so far."""

    def __init__(self) -> None:
        self._changed = Condition()
        self._now = 0.0
        self._limit = 0.0
        self._until = -inf
        self._free = False

    def now(self) -> float:
        return self._now

    def sleep(self, seconds: float) -> None:
        with self._changed:
            self._until = self._now + seconds
            self._changed.notify_all()
            self._changed.wait_for(lambda: self._free or self._until <= self._limit)
            self._now, self._until = max(self._now, self._until), -inf

    def run(self, seconds: float, over: Callable[[], bool]) -> None:
        """So much time has passed, and the sleeper waits for more; or it is over."""
        with self._changed:
            self._limit += seconds
            self._changed.notify_all()
            for _ in range(int(WALL_S / 0.05)):
                if self._changed.wait_for(lambda: self._until > self._limit, 0.05) or over():
                    return
        raise AssertionError("the run neither sleeps nor is it over")

    def free(self) -> None:
        """Nobody is held back any more."""
        with self._changed:
            self._free = True
            self._changed.notify_all()


@dataclass
class Operator:
    """Somebody at the console."""

    app: Console
    pilot: Pilot[None]
    clock: HandClock
    session: OperatorSession

    @property
    def latest(self) -> Snapshot:
        return self.session.latest

    @property
    def states(self) -> tuple[str, ...]:
        assert self.latest.state is not None
        return states_of(self.latest.scene.robot, self.latest.state.robot)

    @property
    def values(self) -> tuple[float, ...]:
        assert self.latest.state is not None
        return self.latest.state.robot.values

    @property
    def waits(self) -> bool:
        """Whether the mission waits for something."""
        state, program = self.latest.state, self.latest.scene.loaded.program
        assert state is not None
        return state.mission.begun and isinstance(program.instructions[state.mission.pc], Wait)

    def wheels_stand(self) -> bool:
        return all(self.values[slot] == 0 for slot in self.latest.scene.robot.safe_zero)

    def wait(self, seconds: float) -> None:
        """Time passes."""
        self.clock.run(seconds, lambda: self.latest.over)

    async def look(self) -> None:
        """The console shows what there is; what it does on the side is done."""
        if not self.app.is_running:
            return
        self.app.show()
        while running := [each for each in self.app.workers if each.is_running]:
            # A newer look at the same thing has replaced it, or the console says what it lacks.
            with suppress(WorkerCancelled, WorkerFailed):
                await running[0].wait()
        await self.pilot.pause()
        self.app.show_words(self.latest)
        await self.pilot.pause()

    def until(self, what: Callable[[], Any], at_most_s: float = 60.0) -> None:
        """It has come to be so."""
        for _ in range(round(at_most_s / 0.1)):
            if what():
                return
            self.wait(0.1)
        raise AssertionError(f"not within {at_most_s:g} s; told: {self.told()[-8:]}")

    async def press(self, *keys: str) -> None:
        """The keys are pressed, and the engine has heard of it."""
        await self.pilot.press(*keys)
        self.wait(0.1)

    async def command(self, name: str) -> None:
        """The command is given by its key, and done."""
        await self.press(self.app.letters[name])
        self.until(lambda: self.latest.state and self.latest.state.robot.motion is None)
        self.wait(0.1)

    async def choose(self, name: str) -> None:
        """The line of the list is chosen with the keyboard."""
        listed = self.app.screen.query_one(OptionList)
        options = [option.id for option in listed.options]
        found = next(n for n, each in enumerate(options) if each and Path(each).stem == name)
        listed.highlighted = found
        await self.press("enter")
        await self.look()
        self.wait(0.2)
        await self.look()

    def told(self) -> list[str]:
        return [f"{each.line.topic} {each.line.text}" for each in self.latest.story.recent]


_ENTRIES: dict[tuple[object, ...], Any] = {}


def ask_once(function: Callable[..., Any], *arguments: Any) -> Any:
    """Ask the check, but only once where a mission can start from a given state of the robot.

    Most stories begin with the same mission and robot, and the answer takes a second.
    """
    if function is not look_at_entries:
        return function(*arguments)
    loaded, body = arguments
    key = (*loaded.files.items(), *loaded.parameters.items(), loaded.pipe_name, body)
    if key not in _ENTRIES:
        _ENTRIES[key] = function(*arguments)
    return _ENTRIES[key]


QUICK = partial(Console, ask_check=ask_once)


@asynccontextmanager
async def operator(
    prepared: Prepared | None = None,
    *,
    size: tuple[int, int] = (160, 48),
    order: Order | None = None,
    console: Callable[..., Console] = QUICK,
    keep: Keep = unkept,
    resuming: Resuming | None = None,
    then: LoadedMission | None = None,
) -> AsyncIterator[Operator]:
    """The console is open, the robot stands; afterwards it is in its safe state."""
    clock = HandClock()
    session = OperatorSession(
        prepared or by_hand(order), clock=clock, keep=keep, resuming=resuming, then=then
    )
    # It shows what there is when the operator looks. Frames in the time of the wall would keep
    # the process busy, and the pilot waits after every key until the process is idle.
    app = console(session, frames_per_s=0)
    app.late_after_s = inf  # nor does a busy machine take its keys for old ones
    app.read_after_s = 0.0  # this operator reads as fast as the dialog is drawn
    # Notifications expire by the time of the wall, too: none does before the story is over.
    notify = app.notify
    app.notify = lambda *told, **how: notify(*told, **{**how, "timeout": STORY_S})
    try:
        async with app.run_test(size=size, notifications=True) as pilot:
            someone = Operator(app, pilot, clock, session)
            someone.until(lambda: someone.latest.state is not None)
            someone.until(lambda: someone.latest.over or someone.latest.state.look is None)
            yield someone
            if app.is_running:
                app.screen._compositor.render_strips()  # what is on it last can be drawn
            clock.free()
            session.quit()
    finally:
        clock.free()
        session.quit()
        assert session.join(WALL_S)
    assert not app.faults


@cache
def mission(name: str) -> LoadedMission:
    return load(Order(name))


def by_hand(order: Order | None = None) -> Prepared:
    order = order or Order("by_hand")
    return prepare(order, without_mission(order))


def with_mission(name: str, backend: str = "sim", **options: Any) -> Prepared:
    order = Order(name, backend=backend, **options)
    return prepare(order, load(order) if options else mission(name))


def played(story: Callable[[], Coroutine[Any, Any, None]]) -> None:
    """The story has been played to its end."""
    asyncio.run(asyncio.wait_for(story(), STORY_S))


def confirming(prepared: Prepared, question: str) -> Prepared:
    return replace(prepared, confirmation=question)
