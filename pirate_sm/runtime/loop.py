"""The loop: the backend's events go to the engine, the engine's effects to the backend.

Every way out leads through the safe state: the mission's own end and a first signal through the
engine, which waits for the safe array's fate; a second signal and anything that breaks through
:meth:`MissionRun._abandon`, which sends it once and closes.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import TYPE_CHECKING

from pirate_sm.errors import BackendError
from pirate_sm.model.effects import Effect, Ended, Fault, Setpoints, WakeAt
from pirate_sm.model.events import Abort, Event, SensorFrame, SignalReport, Tick
from pirate_sm.model.fault_codes import BuiltInFault
from pirate_sm.runtime.clock import Clock, WallClock
from pirate_sm.runtime.companions import Counting, Onlooker
from pirate_sm.runtime.observing import PULSE_S, Observer, Tap, Watcher
from pirate_sm.runtime.outcome import BACKEND, BUG, INTERRUPTED, Result, exit_code
from pirate_sm.runtime.pacing import Pacer
from pirate_sm.runtime.stopping import OUTPUT_LOST, Stop, StopRequests

if TYPE_CHECKING:
    from pirate_sm.backends.protocol import Backend
    from pirate_sm.engine.engine import Engine
    from pirate_sm.engine.state import EngineState
    from pirate_sm.runtime.companions import Companion

BACKEND_FAILED = BuiltInFault.BACKEND_FAILED.code
UNCONFIRMED = "the safe setpoints were not confirmed"

_MOST_IDLE_TURNS = 10_000
"""So many turns within ``_MOMENT_S`` of mission time only a fault of ours can explain."""

_MOMENT_S = 1e-4

_NUDGE_S = 1e-9
"""A deadline that rounding has put a hair later than ``wake_at`` said comes with this step."""


class _BackendRaisedError(Exception):
    """The backend has raised; the cause is what it raised."""


class _Insisted(Exception):  # noqa: N818 - not an error
    """A person has asked twice."""


class MissionRun:
    """One run of one mission on one backend.

    Attributes:
        state: The engine's state now; None before it began.
        now_s: Mission time now.
        ended: The last effect, once there is one.
    """

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
        paused: bool = False,
        keep_open: bool = False,
    ) -> None:
        """Nothing has begun.

        Args:
            engine: What decides.
            backend: What moves.
            observers: Who is told every effect.
            watchers: Who looks on in between.
            companions: Who speaks up.
            tap: Who keeps what the engine is given and gives back.
            requests: What may ask the run to stop.
            clock: The wall's.
            factor: Mission seconds per second of the wall; infinite: as fast as it goes. A
                backend that is itself in real time is never held back.
            after: The run that went before it on this backend and has left it open: the robot is
                as that run left it, and time goes on.
            paused: Whether the operator has the robot first.
            keep_open: Whether the backend is left open when the engine itself has ended the run.
        """
        self._engine = engine
        self._backend = backend
        self._observers = list(observers)
        self._watchers = list(watchers)
        self._companions = tuple(companions)
        self._tap = tap
        self._onlookers = tuple(c if isinstance(c, Onlooker) else None for c in companions)
        self._requests = requests or StopRequests()
        self._clock = clock or WallClock()
        self.state: EngineState | None = None
        self.now_s: float = after.now_s if after is not None else 0.0
        factor = inf if backend.real_time else factor
        self._pacer = Pacer(factor, self._clock, self.now_s)
        self.ended: Ended | None = None
        self._wake_s = inf
        self._until_s = inf
        self._pulse_s = self._clock.now()
        self._last_id = 0
        self._fault = ""
        self._kept_s = -inf
        self._idle_turns = 0
        self._aborting = False
        self._output_lost = False
        self._closed = False
        self._after = after
        self._paused = paused
        self._keep_open = keep_open
        self._heard: dict[int, SensorFrame] = {}
        if after is not None:
            self._last_id, self._heard = after._last_id, after._heard

    @property
    def open(self) -> bool:
        """Whether the backend can still be used."""
        return not self._closed

    def safe_values(self) -> tuple[float, ...] | None:
        """The safe array of this moment; None before anything is known."""
        return None if self.state is None else self._engine.safe_values(self.state)

    def seeking(self) -> frozenset[int]:
        """Slots that a position loop drives at this moment."""
        return frozenset() if self.state is None else self._engine.seeking(self.state)

    def execute(self) -> Result:
        """The mission has ended, the robot is in its safe state, the backend is closed or kept."""
        kept = False
        try:
            self._begin()
            self._go_on()
            kept = self._keep_open
        except _BackendRaisedError as failure:
            error = failure.__cause__
            message = f"the {self._backend.name} backend failed: {_told(error)}"
            stop = self._requests.stop
            if self.state is None and stop is not None:  # asked to end while it was being opened
                self._abandon(Ended("interrupted", f"{stop.reason}; {message}"))
                return self._result(stop.exit_code, error)
            self._abandon(Ended("fault", message), Fault(BACKEND_FAILED, message, "stop"))
            return self._result(BACKEND, error)
        except (_Insisted, KeyboardInterrupt):
            stop = self._requests.stop
            twice = " twice" if self._requests.urgent else ""
            self._abandon(Ended("interrupted", f"interrupted{twice}, stopped at once"))
            return self._result(stop.exit_code if stop else INTERRUPTED)
        except Exception as error:
            message = f"a fault in this program: {_told(error)}"
            self._abandon(Ended("fault", message))
            return self._result(BUG, error)
        except BaseException:
            self._abandon(Ended("interrupted", "this program was told to exit"))
            raise
        finally:
            if not kept:
                self._close()
        assert self.ended is not None  # _go_on returns when there is an end
        code = exit_code(self.ended, self._fault, self._requests.stop, self._output_lost)
        return self._result(code)

    def _begin(self) -> None:
        """The engine has started on an open backend."""
        before = self._after.state if self._after else None
        events: Sequence[Event] = tuple(self._heard.values())
        if before is None:
            try:
                events = self._backend.open()
            except Exception as error:
                raise _BackendRaisedError from error
        else:
            for companion in self._companions:
                if isinstance(companion, Counting):
                    companion.restart(self._engine.robot)
        body = before and before.robot._replace(flight=None, motion=None, loops=())
        seen = [event for event in events if isinstance(event, SensorFrame | SignalReport)]
        self._heard.update((each.board, each) for each in seen if isinstance(each, SensorFrame))
        self.state, effects = self._engine.start(self.now_s, seen, body=body, paused=self._paused)
        if self._tap is not None:
            self._tap.start(seen, self.now_s, effects, body=body, paused=self._paused)
        self._perform(effects)
        for event in events:
            if not isinstance(event, SensorFrame | SignalReport):
                self._give(event)

    def _go_on(self) -> None:
        """The run has come to its end."""
        advance, requests, pacer = self._backend.advance, self._requests, self._pacer
        wall_s, watched = self._clock.now, bool(self._watchers)
        while self.ended is None:
            if requests.stop is not None:
                self._heed_stop()
                if self.ended is not None:
                    return  # nothing had to be sent
            try:
                now_s, events = advance(self._until_s)
            except Exception as error:
                raise _BackendRaisedError from error
            if pacer.waits:
                pacer.wait_until(now_s, self._look_up)
            self.now_s = now_s
            for event in events:
                self._give(event)
            if now_s >= self._until_s or not events:
                self._keep_time()
            if watched and wall_s() >= self._pulse_s:
                self._pulse()

    def _give(self, event: Event) -> None:
        """The engine has taken the event in and its effects are performed."""
        if type(event) is SensorFrame:
            self._heard[event.board] = event
        if self.ended is None and self.state is not None:
            effects: tuple[Effect, ...] = ()
            try:
                self.state, effects = self._engine.step(self.state, event, self.now_s)
            finally:  # the step that broke the engine is the one to keep
                if self._tap is not None:
                    self._tap.take(event, self.now_s, effects)
            if effects:
                self._perform(effects)

    def _keep_time(self) -> None:
        """Whoever wanted to be woken by now has been."""
        now_s = self.now_s
        if now_s > self._kept_s + _MOMENT_S:
            self._kept_s, self._idle_turns = now_s, 0
        else:
            self._idle_turns += 1
            if self._idle_turns > _MOST_IDLE_TURNS:
                raise RuntimeError(f"mission time stands still at {now_s:g} s")
        if now_s >= self._wake_s:
            self._give(Tick())
            if now_s >= self._wake_s:
                self._wake_s = now_s + _NUDGE_S
        if not self._aborting:
            for companion, onlooker in zip(self._companions, self._onlookers, strict=True):
                if now_s >= companion.due_s:
                    self._hear(companion, onlooker)
        self._plan()

    def _hear(self, companion: Companion, onlooker: Onlooker | None) -> None:
        """The companion has said what it has to say, and the engine has heard it."""
        if self.state is not None and onlooker is not None:
            told = onlooker.look(self.state, self.now_s)
            if told:
                self._tell(told)
        for event in companion.speak(self.now_s):
            self._give(event)

    def _perform(self, effects: Sequence[Effect]) -> None:
        """The robot has its setpoints, and everybody knows what happened."""
        failure: Exception | None = None
        for effect in effects:
            if isinstance(effect, Setpoints):
                failure = self._submit(effect) or failure
            elif isinstance(effect, WakeAt):
                self._wake_s = effect.at_s
            elif isinstance(effect, Fault) and effect.handling == "stop":
                self._fault = self._fault or effect.code  # the first one ended the mission
            elif isinstance(effect, Ended):
                self.ended = effect
        self._tell(effects)
        for companion in self._companions:
            companion.react(effects, self.now_s)
        self._plan()
        if failure is not None:
            raise _BackendRaisedError from failure

    def _submit(self, setpoints: Setpoints) -> Exception | None:
        self._last_id = max(self._last_id, setpoints.setpoint_id)
        try:
            self._backend.submit(setpoints.setpoint_id, setpoints.values)
        except Exception as error:
            return error
        return None

    def _plan(self) -> None:
        """It is clear until when the world may run, and how fast."""
        until_s = self._wake_s
        listening = False
        if not self._aborting:
            for companion in self._companions:
                until_s = min(until_s, companion.due_s)
                listening = listening or companion.listening
            self._pacer.limit(1.0 if listening else inf, self.now_s)
        self._until_s = until_s

    def _tell(self, effects: Sequence[Effect]) -> None:
        for observer in tuple(self._observers):
            try:
                observer.see(effects, self.now_s)
            except OSError as error:
                self._observers.remove(observer)
                self._lose_output(error)

    def _lose_output(self, error: OSError) -> None:
        """A run that nobody can follow any more has been asked to stop."""
        self._output_lost = True
        self._requests.ask(Stop(f"the output cannot be written: {error.strerror}", OUTPUT_LOST))

    def _pulse(self) -> None:
        self._pulse_s = self._clock.now() + PULSE_S
        for watcher in tuple(self._watchers):
            try:
                watcher.pulse(self.now_s)
            except OSError as error:
                self._watchers.remove(watcher)
                self._lose_output(error)

    def _look_up(self) -> bool:
        """Whether a wait of the pacer must be cut short; meanwhile the view lives on."""
        if self._watchers and self._clock.now() >= self._pulse_s:
            self._pulse()
        return self._requests.stop is not None

    def _heed_stop(self) -> None:
        """The engine is on its way to the safe stop, as fast as it goes."""
        if self._requests.urgent:
            raise _Insisted
        stop = self._requests.stop
        if stop is not None and not self._aborting:
            self._aborting = True
            self._pacer.release()
            self._give(Abort(stop.reason))
            self._plan()

    def _abandon(self, ended: Ended, *before: Effect) -> None:
        """The safe array has been handed to the backend past the engine, if anything ever was."""
        effects: list[Effect] = list(before)
        if self.state is not None and self._last_id > 0:
            try:
                safe = Setpoints(self._last_id + 1, self._engine.safe_values(self.state))
                effects.append(safe)
                failure = self._submit(safe)
            except Exception as error:
                failure = error
            if failure is not None:
                note = f"{ended.message}; the safe array could not be sent: {_told(failure)}"
                ended = ended._replace(message=note)
            self._close()
            if not getattr(self._backend, "confirmed", True):
                ended = ended._replace(message=f"{ended.message} ({UNCONFIRMED})")
        self.ended = ended
        if self._tap is not None:
            self._tap.abandon(self.now_s, (*effects, ended))
        for observer in self._observers:
            try:
                observer.see((*effects, ended), self.now_s)
            except Exception:
                continue  # it may have been what broke

    def _close(self) -> None:
        if not self._closed:
            self._closed = True
            self._backend.close()

    def _result(self, code: int, error: BaseException | None = None) -> Result:
        assert self.ended is not None  # every way out has set it
        return Result(self.ended, code, self.now_s, error)


def _told(error: BaseException | None) -> str:
    """One line about an error: its words alone where they are meant for people."""
    text = " ".join(str(error).split())
    return text if isinstance(error, BackendError) else f"{type(error).__name__}: {text}"
