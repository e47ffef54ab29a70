"""Runs one mission from start to end: paced, observed, and stopped by signals.

Every run ends in the safe state. The mission's own end and a first signal go through the engine,
which waits for the result of the safe array. A second signal and any exception go through
:meth:`Pump.abandon`, which sends the safe array once and closes the backend.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from math import inf
from typing import Protocol

from pirate_sm.core.companion import Companion
from pirate_sm.core.effects import Effect, Ended, Fault
from pirate_sm.core.engine import Engine, EngineState
from pirate_sm.core.errors import DetectorError, ExitCode
from pirate_sm.core.events import BuiltInFault
from pirate_sm.robot.backends.protocol import Backend
from pirate_sm.running.runtime.ending import Result, Stop, StopRequests, exit_code
from pirate_sm.running.runtime.pump import (
    PULSE_S,
    BackendRaisedError,
    Observer,
    Pump,
    Resuming,
    Tap,
    Watcher,
    described,
)

# --- the pace -------------------------------------------------------------------------------------


SLICE_S = 0.004
"""Longest sleep, so that a request to stop, from any thread, waits no longer than this."""

FORGIVEN_LAG_S = 0.5
"""A run this far behind (a suspended process, a slow machine) does not catch up."""


class Pacer:
    """Holds a run to ``factor`` mission seconds per second of the wall clock; infinite: no waiting.

    It begins now, at mission time ``mission_s``.
    """

    def __init__(self, factor: float, clock: Clock, mission_s: float = 0.0) -> None:
        self._wanted = factor
        self._factor = factor
        self._clock = clock
        self._wall_s = clock.now()
        self._mission_s = mission_s

    @property
    def waits(self) -> bool:
        """Whether mission time is held back at all."""
        return self._factor != inf

    def limit(self, factor: float, mission_s: float) -> None:
        """Run at ``factor`` from this mission time on, or at the user's factor if that is lower."""
        factor = min(factor, self._wanted)
        if factor != self._factor:
            self._factor = factor
            self._anchor(mission_s)

    def release(self) -> None:
        """Do not hold mission time back any more."""
        self._wanted = self._factor = inf

    def wait_until(self, mission_s: float, cut_short: Callable[[], bool]) -> None:
        """Wait until the wall clock has reached this mission time or ``cut_short`` returns true.

        ``cut_short`` is called before every slice of sleep, so it may do small work too.
        """
        due_s = self._wall_s + (mission_s - self._mission_s) / self._factor
        while (left_s := due_s - self._clock.now()) > 0:
            if cut_short():
                return
            self._clock.sleep(min(left_s, SLICE_S))
        if left_s < -FORGIVEN_LAG_S:
            self._anchor(mission_s)

    def _anchor(self, mission_s: float) -> None:
        self._wall_s = self._clock.now()
        self._mission_s = mission_s


class Clock(Protocol):
    """Measures seconds from an arbitrary start, and waits."""

    def now(self) -> float:
        """Return the time in s; it never goes back."""

    def sleep(self, seconds: float) -> None:
        """Wait this many seconds; a signal handler may run meanwhile."""


class WallClock:
    """The monotonic clock of this machine, which changes of the date do not affect."""

    # Class attributes, to save a call: the loop reads the time at every frame.
    now = staticmethod(time.perf_counter)
    sleep = staticmethod(time.sleep)


# --- the loop -------------------------------------------------------------------------------------


BACKEND_FAILED = BuiltInFault.BACKEND_FAILED.code


class _Insisted(Exception):  # noqa: N818 - not an error
    """A second signal asks for an immediate stop."""


def raised_by_part(failure: BaseException) -> BaseException | None:
    """Return what a backend or a detector has raised, from what its pump raises."""
    return failure.__cause__ if isinstance(failure, BackendRaisedError) else failure


class MissionRun:
    """Runs one mission on one backend."""

    def __init__(
        self,
        engine: Engine,
        backend: Backend,
        *,
        observers: Sequence[Observer] = (),
        watchers: Sequence[Watcher] = (),
        companions: Sequence[Companion] = (),
        tap: Tap | None = None,
        requests: StopRequests | None = None,
        clock: Clock | None = None,
        factor: float = inf,
        after: MissionRun | None = None,
        resuming: Resuming | None = None,
        paused: bool = False,
        breakpoints: tuple[str, ...] = (),
        keep_open: bool = False,
    ) -> None:
        """Prepare a run without beginning it.

        Args:
            engine: The engine.
            backend: The backend.
            observers: Receive every effect.
            watchers: Are called at intervals of the wall clock.
            companions: Can give the engine events.
            tap: Receives every input and output of the engine.
            requests: Holds requests to stop.
            clock: The wall clock.
            factor: Mission seconds per second of the wall clock; infinite: as fast as possible. A
                backend in real time is never delayed.
            after: The run before it on this backend, which has left it open: the robot keeps its
                configuration, and time continues.
            resuming: What an interrupted mission resumes with, on a backend that is open.
            paused: Whether the operator controls the robot first.
            breakpoints: Places of the instructions before which the mission pauses.
            keep_open: Whether the backend stays open when the engine itself has ended the run.
        """
        self._pump: Pump = Pump(
            engine,
            backend,
            companions=companions,
            tell=self._tell,
            tap=tap,
            after=after._pump if after is not None else None,
            resuming=resuming,
        )
        self._name = backend.name
        self._observers = list(observers)
        self._watchers = list(watchers)
        self._requests = requests or StopRequests()
        self._clock = clock or WallClock()
        factor = inf if backend.real_time else factor
        self._pacer = Pacer(factor, self._clock, self.now_s)
        self._pulse_s = self._clock.now()
        self._output_lost = False
        self._paused, self._breakpoints = paused, breakpoints
        self._keep_open = keep_open

    @property
    def state(self) -> EngineState | None:
        """The engine's present state; None before it began."""
        return self._pump.state

    @property
    def now_s(self) -> float:
        """Mission time, s."""
        return self._pump.now_s

    @property
    def open(self) -> bool:
        """Whether the backend can still be used."""
        return self._pump.open

    def execute(self) -> Result:
        """Run the mission to its end; leave the robot in its safe state.

        Returns:
            How it ended, also after an exception or a signal.
        """
        kept = False
        try:
            self._pump.start(paused=self._paused, breakpoints=self._breakpoints)
            ended = self._go_on()
            kept = self._keep_open
        except (BackendRaisedError, DetectorError) as failure:
            error = raised_by_part(failure)
            if isinstance(error, DetectorError):
                return self._abandon(Ended("fault", str(error)), ExitCode.BACKEND, error)
            message = f"the {self._name} backend failed: {described(error)}"
            stop = self._requests.stop
            if self.state is None and stop is not None:  # asked to stop while it was being opened
                ended = Ended("interrupted", f"{stop.reason}; {message}")
                return self._abandon(ended, stop.exit_code, error)
            fault = Fault(BACKEND_FAILED, message, "stop")
            return self._abandon(Ended("fault", message), ExitCode.BACKEND, error, fault)
        except (_Insisted, KeyboardInterrupt):
            stop = self._requests.stop
            twice = " twice" if self._requests.urgent else ""
            ended = Ended("interrupted", f"interrupted{twice}, stopped immediately")
            return self._abandon(ended, stop.exit_code if stop else ExitCode.INTERRUPTED)
        except Exception as error:
            message = f"an internal error: {described(error)}"
            return self._abandon(Ended("fault", message), ExitCode.BUG, error)
        except BaseException:
            self._abandon(Ended("interrupted", "this program was asked to exit"), ExitCode.BUG)
            raise
        finally:
            if not kept:
                self._pump.close()
        code = exit_code(ended, self._pump.fault, self._requests.stop, self._output_lost)
        return Result(ended, code, self.now_s)

    def _go_on(self) -> Ended:
        """Run until the end and return it."""
        pump, requests, pacer = self._pump, self._requests, self._pacer
        wall_s, watched = self._clock.now, bool(self._watchers)
        listening = False
        while pump.ended is None:
            if requests.stop is not None:
                self._heed_stop()
                if pump.ended is not None:
                    break  # nothing had to be sent
            if pump.listening != listening:
                listening = pump.listening
                pacer.limit(1.0 if listening else inf, pump.now_s)
            if not pacer.waits:
                pump.glide()
            now_s, events = pump.wait()
            if pacer.waits:
                pacer.wait_until(now_s, self._look_up)
            pump.take(now_s, events)
            if watched and wall_s() >= self._pulse_s:
                self._pulse()
        return pump.ended

    def _tell(self, effects: Sequence[Effect], now_s: float) -> None:
        for observer in tuple(self._observers):
            try:
                observer.see(effects, now_s)
            except OSError as error:
                self._observers.remove(observer)
                self._lose_output(error)

    def _lose_output(self, error: OSError) -> None:
        """Ask the run to stop, because its output cannot be written any more."""
        self._output_lost = True
        self._requests.ask(
            Stop(f"the output cannot be written: {error.strerror}", ExitCode.OUTPUT_LOST)
        )

    def _pulse(self) -> None:
        self._pulse_s = self._clock.now() + PULSE_S
        for watcher in tuple(self._watchers):
            try:
                watcher.pulse(self.now_s)
            except OSError as error:
                self._watchers.remove(watcher)
                self._lose_output(error)

    def _look_up(self) -> bool:
        """Keep the view up to date; return whether the pacer must stop waiting."""
        if self._watchers and self._clock.now() >= self._pulse_s:
            self._pulse()
        return self._requests.stop is not None

    def _heed_stop(self) -> None:
        """Make the engine begin the safe stop, without pacing."""
        if self._requests.urgent:
            raise _Insisted
        stop = self._requests.stop
        if stop is not None and not self._pump.aborting:
            self._pacer.release()
            self._pump.abort(stop.reason)

    def _abandon(
        self, ended: Ended, code: int, error: BaseException | None = None, *before: Effect
    ) -> Result:
        """Send the safe array past the engine, report it, and return how the run ended."""
        effects = self._pump.abandon(ended, *before)
        for observer in self._observers:
            try:
                observer.see(effects, self.now_s)
            except Exception:
                continue  # an observer may have caused the exception
        return Result(self._pump.ended or ended, code, self.now_s, error)
