"""Protocols of companions of a run, which send events: detectors, scripts, operators.

Every companion implements :class:`Companion`; the other protocols are optional.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from typing import Protocol, runtime_checkable

from pirate_sm.core._engine.engine import Engine
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.state import EngineState
from pirate_sm.core._model.events import Event
from pirate_sm.core._model.whereabouts import Look, WordWatch
from pirate_sm.core.effects import Effect, Log


class Companion(Protocol):
    """Observes the engine's effects and sends events at times of its own.

    Attributes:
        due_s: Mission time of its next call of ``speak``; infinite: not before ``react``.
        listening: Whether it waits for a person, so that simulated time must not jump ahead.
    """

    @property
    def due_s(self) -> float:
        """Return the mission time of its next call."""

    @property
    def listening(self) -> bool:
        """Return whether it waits for a person."""

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Process the effects of the last step."""

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the events due now, often none, and advance ``due_s``."""


class CompanionBase:
    """A companion that waits for no operator, ignores effects and sends no events.

    Subclasses have :attr:`Companion.due_s` and override what they need.
    """

    listening: bool = False

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Do nothing."""

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return no events."""
        return ()


@runtime_checkable
class Onlooker(Protocol):
    """A companion that receives the engine's state before each call of ``speak``."""

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Examine the state; return messages for the observers of the run."""


@runtime_checkable
class Counting(Protocol):
    """A companion with counters that start at zero with each mission."""

    def restart(self, robot: RobotSpec) -> None:
        """Reset the counters for another mission with this robot, which has not moved.

        The polarity may differ from the mission before.
        """


@runtime_checkable
class Following(Protocol):
    """A companion that reads the engine's state at any time."""

    def follow(self, engine: Engine, state: Callable[[], EngineState | None]) -> None:
        """Use this source of the run's state from now on; it returns None before the start."""


@runtime_checkable
class Relieved(Protocol):
    """A companion by positions whose looks others can make while it has nothing new to say."""

    def word_watch(self, state: EngineState) -> WordWatch | None:
        """Return what it knows now; None where it must look itself."""

    def relieve(self, looks: Sequence[Look], due_s: float, said_s: float | None) -> None:
        """Take looks that others have made; the next one is due at ``due_s``.

        Args:
            looks: The looks.
            due_s: When the next one is due.
            said_s: When its word was repeated last; None if it was not.
        """


@contextmanager
def entered(companions: Iterable[Companion]) -> Iterator[None]:
    """Enter those companions that are context managers, such as sockets and cameras.

    Raises:
        UsageError: One of them cannot be opened.
    """
    with ExitStack() as stack:
        for companion in companions:
            if isinstance(companion, AbstractContextManager):
                stack.enter_context(companion)
        yield
