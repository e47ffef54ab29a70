"""Makes one step of a run at a time: events of the backend in, effects of the engine out.

A pump knows no signals, no wall clock and no observers. Its driver decides when the next step is
made, and receives the effects through ``tell``; see :mod:`pirate_sm.running.runtime.loop`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf
from typing import NamedTuple, Protocol, runtime_checkable

from pirate_sm.core.companion import Companion, Counting, Following, Onlooker
from pirate_sm.core.effects import Effect, Ended, Fault, Setpoints, WakeAt
from pirate_sm.core.engine import Engine, EngineState
from pirate_sm.core.errors import BackendError
from pirate_sm.core.events import (
    Abort,
    Breakpoints,
    Event,
    FrameBlock,
    SensorFrame,
    SignalReport,
    Tick,
)
from pirate_sm.core.resuming import AS_DECLARED, Beginning, Resumption
from pirate_sm.core.robot import RobotState
from pirate_sm.core.sensing import Glide
from pirate_sm.robot.backends.protocol import Backend
from pirate_sm.running.runtime.backend_links import QuietTime

# --- who follows a run ----------------------------------------------------------------------------


PULSE_S = 0.05


class Observer(Protocol):
    """Receives every effect; raises ``OSError`` when its output cannot be written any more."""

    def see(self, effects: Sequence[Effect], now_s: float) -> None:
        """Receive the latest effects."""


@runtime_checkable
class Watcher(Protocol):
    """Is called every ``PULSE_S`` of the wall clock."""

    def pulse(self, now_s: float) -> None:
        """Look at the run."""


class Tap(Protocol):
    """Receives every input and output of the engine, in order; never raises.

    Attributes:
        stepwise: Whether it looks at the run after each step, so that it cannot use blocks.
    """

    stepwise: bool

    @property
    def due_s(self) -> float:
        """Return when it looks at the engine next: at the first step that reaches this time."""

    def start(
        self,
        seen: Sequence[Event],
        now_s: float,
        effects: Sequence[Effect],
        begins: Beginning = AS_DECLARED,
    ) -> None:
        """Receive the start of the engine, with the events known then."""

    def take(self, event: Event, now_s: float, effects: Sequence[Effect]) -> None:
        """Receive a step; a step in which the engine raised has no effects."""

    def secure(self) -> None:
        """Return when all that was received is on the disk, or soon if that takes too long."""

    def take_glide(self, glide: Glide) -> None:
        """Receive the steps that were taken together, and where the robot was at each."""

    def abandon(self, now_s: float, effects: Sequence[Effect]) -> None:
        """Receive the effects of actions past the engine."""


# --- the last frames ------------------------------------------------------------------------------


class LastFrames:
    """Remembers the last frame of each board; one of a block is made when it is needed."""

    def __init__(self) -> None:
        self._last: dict[int, SensorFrame | tuple[FrameBlock, int]] = {}

    def hear(self, frame: SensorFrame) -> None:
        """Remember a frame."""
        self._last[frame.board] = frame

    def hear_block(self, block: FrameBlock) -> None:
        """Remember the frames of a block."""
        for at, board in enumerate(block.boards):
            self._last[board] = block, at

    def frames(self) -> tuple[SensorFrame, ...]:
        """Return the last frame of each board."""
        return tuple(
            each if isinstance(each, SensorFrame) else each[0].frame(each[1])
            for each in self._last.values()
        )


# --- the pump -------------------------------------------------------------------------------------


UNCONFIRMED = "the safe setpoints were not confirmed"

_MOST_IDLE_TURNS = 10_000
"""More turns than this within ``_MOMENT_S`` of mission time show an internal error."""

_MOMENT_S = 1e-4

_NUDGE_S = 1e-9
"""Tolerance for a deadline that rounding has put just after the time in ``wake_at``."""

Tell = Callable[[Sequence[Effect], float], None]


class BackendRaisedError(Exception):
    """The backend has raised; the original exception is the cause."""


class Resuming(NamedTuple):
    """With what a mission begins on a backend that is open.

    Attributes:
        resumption: With what the engine starts whose run was cut off; its program is that of the
            resumption. None if it begins.
        now_s: Mission time by the backend.
        events: The last report of every board, and what else the backend has reported.
        body: The robot as it was adopted; None: as it is declared.
    """

    resumption: Resumption | None
    now_s: float
    events: tuple[Event, ...]
    body: RobotState | None = None


class Pump:
    """Moves events and effects between one backend and one engine.

    Args:
        engine: The engine.
        backend: The backend.
        companions: Can give the engine events.
        tell: Is called after each step of the engine, with the performed effects and the mission
            time.
        tap: Receives every input and output of the engine.
        after: The pump before it on this backend, which has left it open: the robot keeps its
            configuration, and time continues.
        resuming: What an interrupted mission resumes with, on a backend that is open.

    Attributes:
        state: The engine's present state; None before the start.
        now_s: Mission time, s.
        ended: The effect that ended the run; None before.
        fault: Code of the fault that ended the mission; empty if none.
        listening: Whether a companion waits for an operator, so that time must not run ahead.
        aborting: Whether the mission has been aborted; companions are then ignored.
        open: Whether the backend can still be used.
    """

    def __init__(
        self,
        engine: Engine,
        backend: Backend,
        *,
        companions: Sequence[Companion] = (),
        tell: Tell = lambda effects, now_s: None,
        tap: Tap | None = None,
        after: Pump | None = None,
        resuming: Resuming | None = None,
    ) -> None:
        self.state: EngineState | None = None
        self.now_s: float = after.now_s if after else resuming.now_s if resuming else 0.0
        self.ended: Ended | None = None
        self.fault = ""
        self.listening = False
        self.aborting = False
        self.open = True
        self._engine = engine
        self._backend = backend
        self._companions = tuple(companions)
        self._onlookers = tuple(c if isinstance(c, Onlooker) else None for c in companions)
        self._tell = tell
        self._tap = tap
        self._after = after
        self._resuming = resuming
        # A robot that moves on while this program dies: what was sent must be known.
        self._secure = tap.secure if tap is not None and backend.real_time else None
        self._heard: LastFrames = after._heard if after else LastFrames()
        self._last_id: int = after._last_id if after else 0
        self._quiet = QuietTime(engine, backend, companions)
        self._wake_s = self._until_s = inf
        self._kept_s = -inf
        self._idle_turns = 0
        for companion in companions:
            if isinstance(companion, Following):
                companion.follow(engine, lambda: self.state)

    def start(self, *, paused: bool = False, breakpoints: tuple[str, ...] = ()) -> None:
        """Open the backend and start the engine.

        Args:
            paused: Whether the operator controls the robot first.
            breakpoints: Places of the instructions before which the mission pauses.

        Raises:
            BackendRaisedError: The backend cannot be opened or takes no array.
        """
        before = self._after.state if self._after else None
        events = self._first_events()
        begins = Beginning(before and before.robot.at_rest(), paused)
        if self._resuming is not None:
            begins = Beginning(self._resuming.body, paused, self._resuming.resumption)
        seen: list[SensorFrame | SignalReport | Breakpoints] = [
            event for event in events if isinstance(event, SensorFrame | SignalReport)
        ]
        if breakpoints:
            seen.append(Breakpoints(breakpoints))
        for each in seen:
            if isinstance(each, SensorFrame):
                self._heard.hear(each)
        self.state, effects = self._engine.start(self.now_s, seen, **begins._asdict())
        if self._tap is not None:
            self._tap.start(seen, self.now_s, effects, begins)
        self._perform(effects)
        for event in events:
            if not isinstance(event, SensorFrame | SignalReport):
                self.give(event)

    def _first_events(self) -> Sequence[Event]:
        """Return what the backend has reported before the engine starts; open it if it is closed.

        Raises:
            BackendRaisedError: It cannot be opened.
        """
        if self._resuming is not None:
            return self._resuming.events
        if self._after is None or self._after.state is None:
            try:
                return self._backend.open()
            except Exception as error:
                raise BackendRaisedError from error
        for companion in self._companions:
            if isinstance(companion, Counting):
                companion.restart(self._engine.robot)
        return self._heard.frames()

    def glide(self, until_s: float = inf) -> None:
        """Let time run without the engine, as long as nothing but signals changes.

        This does nothing where the backend or the tap must see every step. What happens next is
        found by :meth:`wait`.

        Args:
            until_s: Mission time that is not reached.

        Raises:
            BackendRaisedError: The backend has raised.
        """
        if self.state is None or self.ended is not None:
            return
        if self._tap is not None and self._tap.stepwise:
            return
        try:
            looked_s = inf if self._tap is None else self._tap.due_s
            passed = self._quiet.run(self.state, min(until_s, looked_s))
        except Exception as error:
            raise BackendRaisedError from error
        if passed is None:
            return
        if passed.after is not None:
            self.state = passed.after.applied_to(self.state)
            self._heard.hear_block(passed.frames)
        self._tell_glide(passed)
        self.now_s = passed.now_s
        self._plan()

    def _tell_glide(self, passed: Glide) -> None:
        """Report the steps to the tap, and their effects to everybody else."""
        if self._tap is not None:
            self._tap.take_glide(passed)
        for at_s, _, effects in passed.steps:
            self.now_s = at_s
            if effects:
                self._perform(effects)

    def wait(self, until_s: float = inf) -> tuple[float, Sequence[Event]]:
        """Let time run until an event occurs or a companion is due.

        Args:
            until_s: Mission time at which the wait ends at the latest.

        Returns:
            The time reached and the events at that time, for :meth:`take`.

        Raises:
            BackendRaisedError: The backend has raised.
        """
        try:
            return self._backend.advance(self._until_s if self._until_s < until_s else until_s)
        except Exception as error:
            raise BackendRaisedError from error

    def take(self, now_s: float, events: Sequence[Event]) -> None:
        """Give the engine these events, and let every companion that is due speak.

        Raises:
            BackendRaisedError: The backend has raised.
        """
        self.now_s = now_s
        for event in events:
            self.give(event)
        if now_s >= self._until_s or not events:
            self._keep_time()

    def give(self, event: Event) -> None:
        """Give the engine one event and perform its effects; do nothing after the end.

        Raises:
            BackendRaisedError: The backend has raised.
        """
        if type(event) is SensorFrame:
            self._heard.hear(event)
        if self.ended is None and self.state is not None:
            effects: tuple[Effect, ...] = ()
            try:
                self.state, effects = self._engine.step(self.state, event, self.now_s)
            finally:  # a step in which the engine raised is kept too
                if self._tap is not None:
                    self._tap.take(event, self.now_s, effects)
            if effects:
                self._perform(effects)

    def abort(self, reason: str) -> None:
        """Make the engine begin the safe stop; further steps must follow until it has ended."""
        self.aborting = True
        self.listening = False
        self.give(Abort(reason))
        self._plan()

    def abandon(self, ended: Ended, *before: Effect) -> tuple[Effect, ...]:
        """Send the safe array past the engine, if any array was ever sent, and close the backend.

        This is the last resort when no step can be made any more. It never raises.

        Args:
            ended: How the run ends; failures in here are added to its message.
            before: Effects that precede it.

        Returns:
            All effects; the last one is the end.
        """
        effects: list[Effect] = list(before)
        if self.state is not None and self._last_id > 0:
            try:
                safe = Setpoints(self._last_id + 1, self._engine.safe_values(self.state))
                effects.append(safe)
                failure = self._submit(safe)
            except Exception as error:
                failure = error
            if failure is not None:
                note = f"{ended.message}; the safe array could not be sent: {described(failure)}"
                ended = ended._replace(message=note)
            self.close()
            if not getattr(self._backend, "confirmed", True):
                ended = ended._replace(message=f"{ended.message} ({UNCONFIRMED})")
        self.ended = ended
        done = (*effects, ended)
        if self._tap is not None:
            self._tap.abandon(self.now_s, done)
        return done

    def close(self) -> None:
        """Close the backend, once."""
        if self.open:
            self.open = False
            self._backend.close()

    def _keep_time(self) -> None:
        """Let every companion that is due by now speak."""
        now_s = self.now_s
        if now_s > self._kept_s + _MOMENT_S:
            self._kept_s, self._idle_turns = now_s, 0
        else:
            self._idle_turns += 1
            if self._idle_turns > _MOST_IDLE_TURNS:
                raise RuntimeError(f"mission time stands still at {now_s:g} s")
        if now_s >= self._wake_s:
            self.give(Tick())
            if now_s >= self._wake_s:
                self._wake_s = now_s + _NUDGE_S
        if not self.aborting:
            for companion, onlooker in zip(self._companions, self._onlookers, strict=True):
                if now_s >= companion.due_s:
                    self._hear(companion, onlooker)
        self._plan()

    def _hear(self, companion: Companion, onlooker: Onlooker | None) -> None:
        """Give the engine the companion's events."""
        if self.state is not None and onlooker is not None:
            logs = onlooker.look(self.state, self.now_s)
            if logs:
                self._tell(logs, self.now_s)
        for event in companion.speak(self.now_s):
            self.give(event)

    def _perform(self, effects: Sequence[Effect]) -> None:
        """Submit setpoints to the backend and report the effects."""
        failure: Exception | None = None
        for effect in effects:
            if isinstance(effect, Setpoints):
                if self._secure is not None and self._begins_command(effect):
                    self._secure()
                failure = self._submit(effect) or failure
            elif isinstance(effect, WakeAt):
                self._wake_s = effect.at_s
            elif isinstance(effect, Fault) and effect.handling == "stop":
                self.fault = self.fault or effect.code  # the first fault ended the mission
            elif isinstance(effect, Ended):
                self.ended = effect
        self._tell(effects, self.now_s)
        for companion in self._companions:
            companion.react(effects, self.now_s)
        self._plan()
        if failure is not None:
            raise BackendRaisedError from failure

    def _begins_command(self, setpoints: Setpoints) -> bool:
        """Return whether this is the first array of a command, which moves the chart."""
        flight = self.state.robot.flight if self.state is not None else None
        return (
            flight is not None
            and flight.purpose == "gate"
            and flight.setpoint_id == setpoints.setpoint_id
        )

    def _submit(self, setpoints: Setpoints) -> Exception | None:
        self._last_id = max(self._last_id, setpoints.setpoint_id)
        try:
            self._backend.submit(setpoints.setpoint_id, setpoints.values)
        except Exception as error:
            return error
        return None

    def _plan(self) -> None:
        """Find out until when time may run, and whether a companion waits for an operator."""
        until_s = self._wake_s
        if not self.aborting:
            listening = False
            for companion in self._companions:
                until_s = min(until_s, companion.due_s)
                listening = listening or companion.listening
            self.listening = listening
        self._until_s = until_s


def described(error: BaseException | None) -> str:
    """Return one line about an error: only its message if that is meant for people."""
    if isinstance(error, KeyboardInterrupt):
        return "interrupted by Ctrl-C"
    text = " ".join(str(error).split())
    return text if isinstance(error, BackendError) else f"{type(error).__name__}: {text}"
