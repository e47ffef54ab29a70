"""A session: a robot under the caller's own commands, one step at a time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from math import inf
from os import PathLike
from typing import Self, Unpack

from pirate_sm.api.arguments import Mission, is_number, prepared, whole
from pirate_sm.api.result import Notes, Run, noted
from pirate_sm.core.companion import entered
from pirate_sm.core.effects import CommandStatus, Effect, Ended
from pirate_sm.core.engine import EngineState
from pirate_sm.core.errors import BackendError, DetectorError, UsageError
from pirate_sm.core.events import Answer, Event, OperatorCommand, Pause, Resume
from pirate_sm.core.expressions import Expression, compile_condition
from pirate_sm.core.options import Options
from pirate_sm.core.spelling import meant
from pirate_sm.running.runtime.loop import raised_by_part
from pirate_sm.running.runtime.pump import BackendRaisedError, Pump, described
from pirate_sm.running.wiring import Prepared
from pirate_sm.running.wiring.adoption import adopt_alone
from pirate_sm.simulation.crew import Crew


@contextmanager
def abandoned_on_error(pump: Pump, backend: str) -> Iterator[None]:
    """Send the safe array past the engine if a step breaks, and say so by our own errors.

    Raises:
        BackendError: It was the backend of this name that raised.
        DetectorError: It was a detector of another package.
    """
    try:
        yield
    except BaseException as error:
        if pump.ended is not None:
            raise
        cause = raised_by_part(error)
        if isinstance(cause, DetectorError):
            pump.abandon(Ended("fault", str(cause)))
            raise cause from None
        if isinstance(error, BackendRaisedError):
            message = f"the {backend} backend failed: {described(cause)}"
            pump.abandon(Ended("fault", message))
            raise BackendError(message) from cause
        pump.abandon(Ended("interrupted", described(error)))
        raise


CLOSED = "the session was closed"


class Session:
    """A robot under the caller's commands, with a mission that waits; made by :func:`session`.

    It begins when it is entered (``with``), the mission paused. When the block is left, however
    that happens, the robot is brought to its safe state and the backend closed. The engine guards
    every command as it guards an operator's.

    Attributes:
        status: What became of the newest command: its name, status and reason; None before one.
    """

    def __init__(
        self, ready: Prepared, record: str | PathLike[str] | None = None, *, adopt: bool = False
    ) -> None:
        self.status: CommandStatus | None = None
        self._ready = ready
        self._record = record
        self._adopt = adopt
        self._stack = ExitStack()
        self._pump: Pump | None = None
        self._notes: Notes | None = None

    def __repr__(self) -> str:
        ready = self._ready
        what = f"{ready.loaded.mission.mission} on {ready.backend.name}"
        if self._pump is None:
            return f"<Session of {what}: not entered>"
        how = self.ended.outcome if self.ended else "going on"
        return f"<Session of {what}: {how} at {self.now_s:.2f} s>"

    def __enter__(self) -> Self:
        """Open the backend, start the mission paused, and wait until a command can be given.

        At first the sensors are compared with the states that the mission declares. Where they
        disagree the run has ended with a fault: :attr:`ended` says so.

        Raises:
            BackendError: The backend cannot be opened.
            RecordingError: The recording cannot be begun.
        """
        if self._pump is not None:
            raise UsageError("a session can be entered once")
        with self._stack as stack:
            adopted = adopt_alone(self._ready, stack) if self._adopt else (self._ready, None)
            self._ready, resuming = ready, _ = adopted
            self._notes = stack.enter_context(noted(ready, self._record, lambda: pump.state))
            stack.enter_context(entered(ready.companions))
            self._pump = pump = Pump(
                ready.engine,
                ready.backend,
                companions=ready.companions,
                tell=self._tell,
                tap=self._notes,
                resuming=resuming,
            )
            stack.callback(pump.close)
            with abandoned_on_error(pump, ready.backend.name):
                pump.start(paused=True)
            self.advance()
            self._stack = stack.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        """Bring the robot to its safe state and close the backend."""
        with self._stack:
            pump = self._opened
            if pump.ended is None:
                with abandoned_on_error(pump, self._ready.backend.name):
                    pump.abort(CLOSED)
                    while pump.ended is None:
                        pump.take(*pump.wait())

    @property
    def now_s(self) -> float:
        """Mission time, s."""
        return self._opened.now_s

    @property
    def ended(self) -> Ended | None:
        """How the run has ended; None while it goes on."""
        return self._opened.ended

    @property
    def state(self) -> Mapping[str, str]:
        """The state of each region of the robot's chart, by the region's name."""
        robot, body = self._ready.engine.robot, self._engine_state.robot
        states = robot.table.configurations[body.configuration]
        return dict(zip(robot.regions, states, strict=True))

    @property
    def signals(self) -> Mapping[str, float]:
        """Every signal in SI units by its name; NaN where it is unknown."""
        return self._ready.engine.signals(self._engine_state)

    @property
    def run(self) -> Run:
        """The run as far as it has come, with its tables and its report."""
        if self._notes is None:
            raise UsageError("the session has not been entered")
        return self._notes.run("" if self._opened.open else self._ready.parting())

    def why_not(self, command: str) -> str:
        """Return why a command would be refused now; empty where it would be taken.

        Raises:
            UsageError: The robot has no such command.
        """
        robot = self._ready.engine.robot
        index = robot.table.command_index[self._name(command)]
        return self._engine_state.why_not_command(robot, index)

    def submit(self, command: str) -> None:
        """Give a command, as an operator would; :meth:`advance` waits until it is done.

        Raises:
            UsageError: The robot has no such command, or it is refused; says why.
            BackendError: The backend has failed; the safe setpoints were its last.
        """
        reason = self.why_not(command)
        if reason:
            raise UsageError(f"{command} is refused: {reason}")
        self._give(OperatorCommand(self._name(command)))

    def resume(self) -> None:
        """Let the mission go on from where it waits."""
        self._give(Resume())

    def pause(self) -> None:
        """Stop the wheels and freeze the mission, which gives the robot to the caller."""
        self._give(Pause())

    def answer(self, choice: str) -> None:
        """Answer the question that the mission asks."""
        self._give(Answer(choice))

    def advance(self, until: float | str | None = None, *, within_s: float = 60.0) -> bool:
        """Let time pass; return whether that has come which was waited for.

        Args:
            until: A mission time in s; a condition as missions write it, such as
                ``"odometry >= 200 mm"``; None: until a command can be given, which is when the
                newest one is done or has failed (:attr:`status` says which).
            within_s: How long to wait at most where no mission time is given, s.

        Returns:
            True when it has come; False when time ran out or the run has ended before.

        Raises:
            UsageError: It is no time and no condition, or the condition has a fault.
            BackendError: The backend has failed; the safe setpoints were its last.
        """
        _refuse_time(until, within_s)
        pump = self._opened
        limit_s = pump.now_s + within_s if isinstance(until, str | None) else float(until)
        robot = self._ready.engine.robot
        condition = compile_condition(until, robot.vocabulary) if isinstance(until, str) else None
        with abandoned_on_error(pump, self._ready.backend.name):
            while pump.ended is None:
                if isinstance(until, str | None) and self._holds(condition):
                    return True
                if pump.now_s >= limit_s:
                    return not isinstance(until, str | None)
                if condition is None:  # every frame could make a condition true
                    pump.glide(limit_s)
                pump.take(*pump.wait(limit_s))
        return False

    def _holds(self, condition: Expression | None) -> bool:
        state = self._engine_state
        if condition is not None:
            engine = self._ready.engine
            estimated = not condition.names.isdisjoint(engine.robot.estimated)
            numbers = engine.numbers(state) if estimated else state.sensing.shown
            return condition.evaluate(numbers, state.words) is True
        busy = state.robot.motion is not None and not state.mission.suspended
        return not busy and state.robot.awaited is None and state.look is None

    def _give(self, event: Event) -> None:
        with abandoned_on_error(self._opened, self._ready.backend.name):
            self._opened.give(event)

    def _tell(self, effects: Sequence[Effect], now_s: float) -> None:
        for effect in effects:
            if isinstance(effect, CommandStatus):
                self.status = effect

    def _name(self, command: str) -> str:
        """Return the name of a command that may be given by its alias."""
        if not isinstance(command, str):
            raise UsageError(f"expected the name of a command, got {command!r}")
        name = self._ready.loaded.loaded_robot.profile.aliases.get(command, command)
        known = self._ready.engine.robot.table.command_index
        if name not in known:
            raise UsageError(f"there is no command '{command}': {meant(command, sorted(known))}")
        return name

    @property
    def _opened(self) -> Pump:
        if self._pump is None:
            raise UsageError("the session has not been entered: use it as 'with session(…) as s:'")
        return self._pump

    @property
    def _engine_state(self) -> EngineState:
        state = self._opened.state
        if state is None:
            raise UsageError("the backend has not been opened")
        return state


def advance_all(
    sessions: Sequence[Session],
    until: float | str | None = None,
    *,
    within_s: float = 60.0,
    threads: int | None = None,
) -> list[bool]:
    """Let time pass in many sessions at once; return for each what its ``advance`` returns.

    What happens in one is the same as if it were alone, for any number of threads.

    Args:
        sessions: The sessions, each of them entered.
        until: As for :meth:`Session.advance`.
        within_s: As there.
        threads: How many threads share the work; one for each processor by default.

    Raises:
        UsageError: An argument does not fit.
        BackendError: A backend has failed; time has passed in the other sessions.
    """
    if not isinstance(sessions, Sequence):
        raise UsageError(f"sessions: expected a list of them, got {sessions!r}")
    count = whole(threads, "threads", 1) if threads is not None else None
    come = [False] * len(sessions)

    def advance(row: int) -> None:
        come[row] = sessions[row].advance(until, within_s=within_s)

    with Crew(count) as crew:
        crew.each(advance, range(len(sessions)))
    return come


def _refuse_time(until: object, within_s: object) -> None:
    if not (isinstance(until, str | None) or is_number(until)):
        raise UsageError(f"expected a time in s or a condition as text, got {until!r}")
    if until == inf:
        raise UsageError("until: expected a time in s that comes, got inf")
    if not is_number(within_s):
        raise UsageError(f"within_s: expected a time in s, got {within_s!r}")


def session(
    mission: Mission,
    backend: str = "sim",
    *,
    seed: int = 0,
    record: str | PathLike[str] | None = None,
    check: bool = False,
    yes: bool = False,
    adopt: bool = False,
    **options: Unpack[Options],
) -> Session:
    """Return a session with the robot and the pipe of a mission, which is paused at first.

    Args:
        mission: A shipped mission's name, the path of a file, or what :func:`load` has returned.
        backend: Name of a backend: ``sim``, ``physics``, ``trace``, ``serial``, or another's.
        seed: Of everything random.
        record: A file for a recording, which must not exist yet.
        check: Whether a mission in which the check finds errors is refused.
        yes: Whether you agree that a real robot moves.
        adopt: Whether a robot that stands elsewhere than declared is taken as its sensors show it.
        options: :class:`~pirate_sm.core.options.Options`, such as ``pipe``, ``defects``.

    Raises:
        LoadError: Everything that is wrong with the files; ``problems`` has each with its place.
        CheckError: The mission is refused; ``findings`` has why, each with its place.
        UsageError: An argument does not fit, or an extra is not installed.
    """
    ready = prepared(mission, backend, seed, check=check, yes=yes, **options)
    return Session(ready, record, adopt=adopt)
