"""A defect that acts on a simulated robot: when it occurs, what it can change, what gets lost."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from pirate_sm.core.models import Defect
from pirate_sm.simulation.electronics import Electronics

Counts: TypeAlias = list[float]


class Incident(NamedTuple):
    """An event on the boards or the controller of the link.

    Attributes:
        what: ``boards_restarted``; ``controller_restarted``: the motors keep their setpoints until
            it is set up; ``controller_hangs``; ``motor_moves``: without a command.
        until_s: When it is over, for lasting events.
    """

    what: Literal["boards_restarted", "controller_restarted", "controller_hangs", "motor_moves"]
    until_s: float = math.inf


class ActingDefect:
    """An acting defect; each kind overrides the methods that it changes.

    Args:
        defect: The profile's numbers.
        robot: The electronics, and through them the physics.
        rng: Random numbers of its own.

    Attributes:
        due_s: When it next strikes; infinite for a defect without sudden events.
    """

    due_s = math.inf

    def __init__(self, defect: Defect, robot: Electronics, rng: np.random.Generator) -> None:
        self.defect = defect
        self.robot = robot
        self.rng = rng
        self._until = -math.inf
        self._next = defect.after + self._pause()

    def active(self, now: float) -> bool:
        """Return whether the defect is active.

        With `every`, occurrences come at random from `after` on; without it, one begins at `after`.
        Without `lasting` an occurrence never ends.
        """
        if now < self._until:
            return True
        if now < self._next:
            return False
        defect = self.defect
        self._until = now + defect.lasting if defect.lasting > 0 else math.inf
        self._next = self._until + (self._pause() or math.inf)
        return True

    def _pause(self) -> float:
        """Draw the time until the next occurrence; 0 if there is none."""
        every = self.defect.every
        return float(self.rng.exponential(every)) if every > 0 else 0.0

    def begin(self) -> None:
        """Change the robot from the start."""

    def step(self, now: float) -> Incident | None:
        """Act on the robot; return an incident for the controller, if any."""
        return None

    def frame(self, now: float, board: int, first: int, counts: Counts) -> Counts | None:
        """Return the frame's counts after the defect; None if the frame is lost.

        Args:
            now: Time.
            board: Id of the board.
            first: Row of the channel table of its first channel.
            counts: The counts without the defect; may be changed.
        """
        return counts

    def glides_until_s(self, now: float) -> float:
        """Return until when it only shows what :meth:`forced` says; before ``now`` if it does not.

        Before that, neither ``step`` nor ``frame`` needs to be called, and ``took`` is called for
        each frame.
        """
        return -math.inf

    def forced(self, now: float) -> Mapping[int, float]:
        """Return the counts that it shows instead of those measured, by row of the channels."""
        return {}

    def took(self, board: int, counts: Counts) -> None:
        """Note the counts of a frame that has been reported meanwhile."""

    def _phase_until_s(self, now: float) -> float:
        """Return when it becomes active or ceases to be; before ``now`` if that is unknown."""
        until_s = self._until if now < self._until else self._next
        return until_s if now < until_s else -math.inf

    def delivery(self, now: float) -> tuple[bool, bool]:
        """Return whether an array sent now arrives, and whether its echo arrives."""
        return True, True


class Sudden(ActingDefect):
    """A defect that strikes at certain times, once or at random."""

    def __init__(self, defect: Defect, robot: Electronics, rng: np.random.Generator) -> None:
        super().__init__(defect, robot, rng)
        self.due_s = self._next

    def step(self, now: float) -> Incident | None:
        """Strike when the time has come."""
        if now < self.due_s:
            return None
        self.due_s += self._pause() or math.inf
        return self.strike(now)

    def glides_until_s(self, now: float) -> float:
        """Return when it strikes."""
        return self.due_s

    def strike(self, now: float) -> Incident | None:
        """Act on the robot; return an incident for the controller, if any."""
        raise NotImplementedError


# --- losses --------------------------------------------------------------------------------------


class Loss:
    """Decides at random which messages arrive.

    Args:
        share: Share of lost messages.
        never_two: Whether one of two consecutive messages of a kind always arrives.
        rng: Random numbers.
    """

    def __init__(self, share: float, never_two: bool, rng: np.random.Generator) -> None:
        # After a loss one message always arrives, so more of the others must be lost.
        self._share = share / (1.0 - share) if never_two else share
        self._never_two = never_two
        self._rng = rng
        self._just_lost: set[Hashable] = set()

    def arrives(self, kind: Hashable) -> bool:
        """Return whether the next message of this kind arrives."""
        if self._share == 0.0:
            return True
        if kind in self._just_lost:
            self._just_lost.discard(kind)
            return True
        if self._rng.random() >= self._share:
            return True
        if self._never_two:
            self._just_lost.add(kind)
        return False
