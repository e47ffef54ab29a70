"""Runs missions one after the other on one open backend, in a separate thread, and ends them."""

from __future__ import annotations

import os
import signal
import sys
import termios
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import replace
from math import inf, isnan
from threading import Thread
from typing import Any

from pirate_sm.core.companion import CompanionBase, entered
from pirate_sm.core.effects import Effect, Ended, Log
from pirate_sm.core.engine import EngineState
from pirate_sm.core.errors import ExitCode
from pirate_sm.core.events import Answer, Event, GoTo
from pirate_sm.core.loading import LoadedMission
from pirate_sm.running.runtime.ending import BY_SIGNAL, Result, Stop, StopRequests
from pirate_sm.running.runtime.loop import Clock, MissionRun, WallClock
from pirate_sm.running.runtime.pump import Resuming
from pirate_sm.running.runtime.scripted_events import Answered, FirstChoice, LoopWatch
from pirate_sm.running.wiring import Prepared, again
from pirate_sm.running.wiring.run_recorder import Kept
from pirate_sm.views.console.driving import RUN_OVER, Giver, HandDriving, SaidPlace
from pirate_sm.views.showing.effect_lines import EffectLine
from pirate_sm.views.showing.snapshot import (
    Memory,
    MissionScene,
    Snapshot,
    Trends,
    scene_of,
    snapshot_of,
)

# --- between the threads ------------------------------------------------------------------------


QUIET = frozenset({"another mission was chosen", "the console was left"})
"""Ends that the operator has requested by other means than a stop; they need no banner."""

HELD_S = 1.0
"""After this long without a new snapshot the newest one is not taken for the present any more."""

LOOK_EVERY_S = 0.02
"""The longest delay of an operator's event to the engine."""


class RunBridge(CompanionBase):
    """An observer, watcher and companion of the runs of one session, one after the other.

    Attributes:
        asked: Number of the operator's events in the current run.
    """

    def __init__(self, scene: MissionScene, prepared: Prepared, clock: Clock) -> None:
        self._clock = clock
        self._scene = scene
        self._prepared = prepared
        self._memory = Memory(scene.robot, nominal=scene.engine.nominal, quiet=QUIET)
        self._waiting: deque[Event] = deque()
        self._run: MissionRun | None = None
        self._due_s = 0.0
        self._trends = Trends()
        self._over = False
        self._before_m = 0.0
        self.asked = 0
        self._newest = self._snapshot(0.0)
        self._made_s = clock.now()

    # --- from the console's thread ------------------------------------------------------------

    @property
    def latest(self) -> Snapshot:
        """The newest snapshot; it says how old it is if the run does not make newer ones."""
        newest, held_s = self._newest, self._clock.now() - self._made_s
        if newest.over or newest.state is None or held_s < HELD_S:
            return newest
        return replace(newest, held_s=held_s)

    def queue(self, event: Event) -> None:
        """Queue an event for the engine at the next turn of the loop."""
        self._waiting.append(event)

    # --- from the run's thread ----------------------------------------------------------------

    def begin(self, scene: MissionScene, prepared: Prepared, run: MissionRun) -> None:
        """Follow another run; the log keeps its earlier lines."""
        self._waiting.clear()
        came_m = self._snapshot(self.latest.now_s).odometry_m
        self._before_m += 0.0 if isnan(came_m) else came_m
        same = scene.loaded.documents == self._scene.loaded.documents
        self._memory.begin(scene.robot, same_mission=same)
        self._scene, self._prepared, self._run = scene, prepared, run
        self._due_s, self.asked = -inf, 0
        for notice in prepared.notices:
            self._memory.tell(EffectLine("console", notice), self.latest.now_s)

    def end(self, now_s: float) -> None:
        """Note that the last run is over."""
        self._over = True
        self._renew(now_s)

    @property
    def due_s(self) -> float:
        """When it is due: immediately after a request of the operator."""
        return -inf if self._waiting else self._due_s

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Make a new snapshot; return a log line for each answer of the operator."""
        self._due_s = now_s + LOOK_EVERY_S
        self._trends.look(self._scene, state, now_s)
        self._renew(now_s)
        return [
            Answered("info", f"answered '{event.choice}' (operator)")
            for event in tuple(self._waiting)
            if isinstance(event, Answer)
        ]

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the operator's events."""
        said = []
        while self._waiting:
            said.append(self._waiting.popleft())
        self.asked += len(said)
        return said

    def see(self, effects: Sequence[Effect], now_s: float) -> None:
        """Note the effects for the log and the history of the run."""
        self._memory.see(effects, now_s)

    def pulse(self, now_s: float) -> None:
        """Make a new snapshot, also while mission time is stopped."""
        self._renew(now_s)

    def _renew(self, now_s: float) -> None:
        self._newest, self._made_s = self._snapshot(now_s), self._clock.now()

    def _snapshot(self, now_s: float) -> Snapshot:
        state = self._run.state if self._run is not None else None
        what = self._scene, self._prepared, state, now_s, self._memory.story, self._trends
        return snapshot_of(*what, over=self._over, before_m=self._before_m)


# --- leaving ------------------------------------------------------------------------------------


LEAVE_WITHIN_S = 1.7
"""How long leaving may take once the operator has gone and the robot is safe. With the time to
notice it, 2 s."""

SAFE_WITHIN_S = 5.0
"""The safe stop, which takes 0.1 s, may take so long on a busy machine."""

_LOOK_EVERY_S = 0.05

_GONE = frozenset(BY_SIGNAL.values()) - {BY_SIGNAL[signal.SIGINT]}
"""Requests after which nobody waits for the process to end by itself. Ctrl-C is an operator's."""

_RESTORED = "\x1b[<u\x1b[?1000l\x1b[?1003l\x1b[?1006l\x1b[?2004l\x1b[?1004l\x1b[?1049l\x1b[?25h"
"""Ends what the console asks of a terminal: its keys, mouse, paste, focus and second screen."""


class LeaveRequests(StopRequests):
    """Requests to leave; signals make them too.

    Attributes:
        gone: The first request made without an operator at the terminal; None without one.
    """

    def __init__(self) -> None:
        super().__init__()
        self.gone: Stop | None = None

    def ask(self, stop: Stop) -> None:
        """Ask to leave; the first reason counts."""
        super().ask(stop)
        if self.gone is None and stop in _GONE:
            self.gone = stop

    @property
    def safe(self) -> bool:
        """Whether no robot needs this process any more; here there is none."""
        return True


class Quitting(LeaveRequests):
    """Requests that end the session with its present run.

    Args:
        unreachable: Returns whether nothing comes from the robot.

    Attributes:
        stopped: Whether the robot has been brought to its safe state after a request.
    """

    def __init__(self, unreachable: Callable[[], bool] = lambda: False) -> None:
        super().__init__()
        self.run = StopRequests()
        self.stopped = False
        self._unreachable = unreachable

    @property
    def safe(self) -> bool:
        """Whether the robot is at rest, or only its guardian can still stop it."""
        return self.stopped or self._unreachable()

    def begin(self) -> StopRequests:
        """Return the requests of the next run, with a stop if the session was asked to stop."""
        self.run = StopRequests()
        if self.stop is not None:
            self.run.ask(self.stop)
        return self.run

    def ask(self, stop: Stop) -> None:
        """End the current run through the engine's safe stop; no run follows."""
        super().ask(stop)
        self.run.ask(stop)

    def insist(self) -> None:
        """End it immediately, with the safe array sent past the engine."""
        super().insist()
        self.run.insist()


class Watchdog:
    """Ends this process where leaving takes too long after the operator has gone.

    The safe stop is the first thing that leaving does, and the limit counts from its end. Where it
    takes too long itself, the guardian, which owns the port, continues without this process.

    Args:
        requests: The requests to leave.
        end: Ends the process with an exit code; called in a thread of its own.
        clock: The wall clock.
    """

    def __init__(
        self, requests: LeaveRequests, end: Callable[[int], object], clock: Clock | None = None
    ) -> None:
        self._requests, self._end = requests, end
        self._clock = clock or WallClock()

    def start(self) -> None:
        """Watch until the process ends."""
        Thread(target=self.watch, name="watchdog", daemon=True).start()

    def watch(self) -> None:
        """Wait until the operator has gone; end the process if it is still there after that."""
        while (gone := self._requests.gone) is None:
            self._clock.sleep(_LOOK_EVERY_S)
        give_up_s = self._clock.now() + SAFE_WITHIN_S
        while not self._requests.safe and self._clock.now() < give_up_s:
            self._clock.sleep(_LOOK_EVERY_S)
        self._clock.sleep(LEAVE_WITHIN_S)
        self._end(gone.exit_code)


def ender() -> Callable[[int], None]:
    """Return what ends this process immediately and leaves its terminal as it is now."""
    terminal = sys.stdin.fileno()
    before: list[Any] = termios.tcgetattr(terminal)
    words = f"{_RESTORED}the console has ended before everything was closed: look at the robot\n"

    def end(code: int) -> None:
        # A process in the background would be stopped here.
        signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGTTOU])
        with suppress(OSError, termios.error):
            termios.tcsetattr(terminal, termios.TCSANOW, before)
            # The terminal may take nothing, whatever `select` says: nothing must wait for it.
            again = os.open(os.ctermid(), os.O_WRONLY | os.O_NONBLOCK | os.O_NOCTTY)
            os.write(again, words.encode())
        os._exit(code)

    return end


# --- the session --------------------------------------------------------------------------------


BY_OPERATOR = Stop("stopped by the operator", 0)
CHANGED = Stop("another mission was chosen", 0)
LEFT = Stop("the console was left", 0)

_SHORT_S = 1.0
_MOST_SHORT = 3
"""After this many consecutive runs that a fault ended immediately, the session ends."""


Keep = Callable[[Prepared], AbstractContextManager[Kept]]


def unkept(prepared: Prepared) -> AbstractContextManager[Kept]:
    """Return the run without a recording."""
    return nullcontext(Kept(prepared))


class OperatorSession:
    """The operations of the console. None of them blocks, except :meth:`join`.

    Args:
        prepared: The first mission, its engine, and the backend that stays open.
        factor: Mission seconds per second of the wall clock.
        clock: The wall clock.
        keep: Records each run.
        resuming: The state from which the first mission resumes; its backend is open.
        then: The mission of the second run; by default the first one again.

    Attributes:
        quitting: Requests to end the session.
        giver: Gives a series of commands that the operator has confirmed.
        driving: Stops what is driven by hand.
        result: How the last run ended; None before.
    """

    def __init__(
        self,
        prepared: Prepared,
        *,
        factor: float = 1.0,
        clock: Clock | None = None,
        keep: Keep = unkept,
        resuming: Resuming | None = None,
        then: LoadedMission | None = None,
    ) -> None:
        self.quitting = Quitting(lambda: bool(self.latest.link and self.latest.link.trouble))
        self.giver = Giver()
        self.result: Result | None = None
        self.prepared = prepared
        self._factor = factor
        self._clock = clock
        self._keep = keep
        self._resuming = resuming
        self._next = (then, False) if then is not None else None
        self._short = 0
        self._thread = Thread(target=self._work, name="run", daemon=True)
        self._bridge = RunBridge(scene_of(prepared), prepared, clock or WallClock())
        self.driving = HandDriving(lambda: self._bridge.latest, factor)
        if (place_m := prepared.order.start_at_m) is not None:
            self.driving.place = SaidPlace(place_m, 0.0)

    @property
    def latest(self) -> Snapshot:
        """The newest snapshot."""
        return self._bridge.latest

    def start(self) -> None:
        """Open the backend and begin the mission, paused."""
        self._thread.start()

    def join(self, within_s: float | None = None) -> bool:
        """Wait at most this long; return whether the robot is safe and the backend closed."""
        if self._thread.ident is not None:
            self._thread.join(within_s)
        return not self._thread.is_alive()

    def give_event(self, event: Event) -> None:
        """Give the engine the event soon; end a series of commands."""
        self.giver.stop()
        self._bridge.queue(event)

    def give(self, commands: Sequence[str], then: GoTo) -> None:
        """Give the commands one after the other, each when the last is done; then hand back.

        The series ends with a request to stop the run, and does not continue in the next run.
        """
        if self.quitting.run.stop is None:
            self.giver.give(commands, then)

    def stop(self, stop: Stop = BY_OPERATOR) -> None:
        """Bring the robot to its safe state now; its mission can be handed back afterwards."""
        self.quitting.run.ask(stop)

    def change(self, loaded: LoadedMission) -> None:
        """End the current mission in the safe state and begin the other one, paused.

        Raises:
            UsageError: The mission is for another robot.
        """
        again(self.prepared, loaded, other=True)
        self._next = loaded, True
        self.quitting.run.ask(CHANGED)

    def quit(self, stop: Stop = LEFT) -> None:
        """End the session, with the robot in its safe state."""
        self.quitting.ask(stop)

    # --- in its own thread --------------------------------------------------------------------

    def _work(self) -> None:
        try:
            with entered(self.prepared.companions):
                self._run_all()
        except Exception as error:
            message = f"an internal error: {type(error).__name__}: {error}"
            self.result = Result(Ended("fault", message), ExitCode.BUG, self.latest.now_s, error)
        finally:
            self.prepared.backend.close()
            self._bridge.end(self.latest.now_s)

    def _run_all(self) -> None:
        run: MissionRun | None = None
        while True:
            with self._keep(self.prepared) as kept:
                run = self._run(kept, run)
                series = self.giver.series
                self.result = run.execute()
                self.quitting.stopped = self.quitting.stop is not None
                asked = self._bridge.asked or self.giver.series is not series
                if not asked and self.result.ended.outcome == "interrupted":
                    kept.forget()
            stopped = self.quitting.stop is not None or not run.open
            if stopped or run.state is None or self._hopeless(self.result, run):
                return
            (loaded, other), self._next = self._next or (self.prepared.loaded, False), None
            self.prepared = again(self.prepared, loaded, other=other)

    def _run(self, kept: Kept, before: MissionRun | None) -> MissionRun:
        self.giver.stop(RUN_OVER)
        prepared = kept.prepared
        attended = [FirstChoice()] if prepared.attended else []
        # An operator may act where a trace alone would repeat itself.
        companions = [each for each in prepared.companions if not isinstance(each, LoopWatch)]
        people = self._bridge, self.driving, self.giver
        run = MissionRun(
            prepared.engine,
            prepared.backend,
            observers=[self._bridge],
            watchers=[self._bridge],
            companions=[*companions, *kept.companions, *attended, *people],
            tap=kept.tap,
            requests=self.quitting.begin(),
            clock=self._clock,
            factor=self._factor,
            after=before,
            resuming=self._resuming,
            paused=True,
            breakpoints=self._breakpoints(before),
            keep_open=True,
        )
        self._resuming = None
        self._began_s = run.now_s
        self._bridge.begin(scene_of(prepared), prepared, run)
        kept.follow(run)
        return run

    def _breakpoints(self, before: MissionRun | None) -> tuple[str, ...]:
        """Return those of the run before if it had the same mission, else those of the order."""
        state = before.state if before is not None else None
        latest = self._bridge.latest.scene.loaded
        if state is None or latest.documents != self.prepared.loaded.documents:
            return self.prepared.breakpoints
        return state.mission.breakpoints

    def _hopeless(self, result: Result, run: MissionRun) -> bool:
        """Return whether several runs have ended by a fault before any request of the operator."""
        short_s = _SHORT_S + self.prepared.loaded.robot.sight.within_s  # a start may be refused
        at_once = result.now_s < self._began_s + short_s and not self._bridge.asked
        self._short = self._short + 1 if at_once and result.ended.outcome == "fault" else 0
        return self._short >= _MOST_SHORT
