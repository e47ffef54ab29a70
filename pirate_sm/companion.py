"""Protocols of those who stand beside a mission and speak up: detectors, scripts, operators.

:class:`Companion` is what each of them must be; the others are what it may be besides.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol, runtime_checkable

from pirate_sm.engine.engine import Engine
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.state import EngineState
from pirate_sm.model.effects import Effect, Log
from pirate_sm.model.events import Event


class Companion(Protocol):
    """Sees what the engine does and speaks up at times of its own choosing.

    Attributes:
        due_s: Mission time at which it wants to be asked next; infinite: not before ``react``.
        listening: Whether a person is being waited for, so that time must not run ahead of theirs.
    """

    @property
    def due_s(self) -> float:
        """When it wants to be asked next."""
        ...

    @property
    def listening(self) -> bool:
        """Return whether a person is being waited for."""
        ...

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Take note of what has just happened."""
        ...

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return what there is to say at ``due_s``, which it moves on; often nothing."""
        ...


@runtime_checkable
class Onlooker(Protocol):
    """A companion that is shown the engine's state each time before it is asked to speak."""

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Look at the state; return what is to be told to whoever follows the run."""
        ...


@runtime_checkable
class Counting(Protocol):
    """A companion that counts from the beginning of a mission."""

    def restart(self, robot: RobotSpec) -> None:
        """Begin to count again: another mission begins with this robot, which is where it is.

        Its polarity may be another one.
        """
        ...


@runtime_checkable
class Following(Protocol):
    """A companion that reads the engine's state at moments of its own."""

    def follow(self, engine: Engine, state: Callable[[], EngineState | None]) -> None:
        """Read the state of this run from now on; it is None before the engine has started."""
        ...
