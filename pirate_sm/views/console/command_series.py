"""A series of commands that the operator has confirmed: each waits for the one before."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from threading import Lock
from typing import TYPE_CHECKING, NamedTuple

from pirate_sm.core.effects import CommandStatus, Effect, Ended, Fault, Log
from pirate_sm.core.events import Event, GoTo, OperatorCommand

if TYPE_CHECKING:
    from pirate_sm.core.engine import EngineState

LOOK_EVERY_S = 0.02
"""The longest delay between the end of a command and the next one."""

BY_OPERATOR = "the operator has stopped it"
RUN_OVER = "the run has ended"


class CommandSeries(NamedTuple):
    """A series of commands and its progress; immutable.

    Attributes:
        commands: Names of the commands.
        then: The hand-back of the mission after the last of them.
        done: Number of done commands.
        given: Whether the next one has been given.
        stopped: Why the series has stopped; empty while it goes on.
        handed_back: Whether all are done and the mission has been handed back.
    """

    commands: tuple[str, ...]
    then: GoTo
    done: int = 0
    given: bool = False
    stopped: str = ""
    handed_back: bool = False

    @property
    def active(self) -> bool:
        """Whether the series goes on."""
        return not self.stopped and not self.handed_back

    @property
    def current(self) -> str:
        """The next or present command; empty after the last."""
        return self.commands[self.done] if self.done < len(self.commands) else ""


class Giver:
    """A companion of the console's runs that gives a series of commands.

    A command follows when the one before is done. A refusal, a failure or a fault stops the series,
    and so does any other request of the operator.

    Attributes:
        series: The newest series; None before the first.
    """

    listening = False

    def __init__(self) -> None:
        self.series: CommandSeries | None = None
        self._lock = Lock()  # a request to stop must not be lost while the next command is given
        self._busy = True
        self._due_s = -inf

    # --- from the console's thread ------------------------------------------------------------

    def give(self, commands: Sequence[str], then: GoTo) -> None:
        """Begin a series; abandon the present one."""
        with self._lock:
            self._due_s = -inf
            self.series = CommandSeries(tuple(commands), then)

    def stop(self, why: str = BY_OPERATOR) -> None:
        """Give no further command; a command under way goes on until it is done."""
        with self._lock:
            series = self.series
            if series is not None and series.active:
                self.series = series._replace(stopped=why)

    # --- from the run's thread ----------------------------------------------------------------

    @property
    def due_s(self) -> float:
        """Soon while a series goes on; else infinite."""
        return self._due_s if self.series is not None and self.series.active else inf

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Note the end of the command under way, and any event that stops the series."""
        for effect in effects:
            series = self.series
            if series is None or not series.active:
                return
            match effect:
                case CommandStatus(name=series.current, place="") if series.given:
                    self._note(effect)
                case Fault():
                    self.stop(f"{effect.code}: {effect.message}")
                case Ended():
                    self.stop(RUN_OVER)
                case _:
                    pass

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Find out whether the next command would be accepted now."""
        robot = state.robot
        under_way = robot.motion is not None and not state.mission.suspended
        self._busy = under_way or robot.awaited is not None
        self._due_s = now_s + LOOK_EVERY_S
        return ()

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the next command when the one before is done; at the end the hand-back."""
        with self._lock:
            series = self.series
            if series is None or not series.active or series.given or self._busy:
                return ()
            if series.current:
                self.series = series._replace(given=True)
                return (OperatorCommand(series.current),)
            self.series = series._replace(handed_back=True)
            return (series.then,)

    def _note(self, status: CommandStatus) -> None:
        if status.status == "done":
            with self._lock:
                series = self.series
                if series is not None and series.given:
                    self.series = series._replace(done=series.done + 1, given=False)
        elif status.status in ("failed", "refused", "skipped"):
            reason = f": {status.reason}" if status.reason else ""
            self.stop(f"{status.name} {status.status}{reason}")
