"""One defect at work on a simulated robot: when it occurs, and what a kind of defect can change."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from pirate_sm.model.simulation import Defect
from pirate_sm.simulation.electronics import Electronics

Counts: TypeAlias = list[float]


class Incident(NamedTuple):
    """Something that has just happened to the boards or to the controller of the link.

    Attributes:
        what: ``boards_restarted``; ``controller_restarted``: motors go on as they were until it
            is set up; ``controller_hangs``; ``motor_moves``: one that nobody asked.
        until_s: When it is over, where it takes time.
    """

    what: Literal["boards_restarted", "controller_restarted", "controller_hangs", "motor_moves"]
    until_s: float = math.inf


class Effect:
    """One defect at work; a kind overrides what it changes.

    Args:
        defect: Its numbers.
        robot: The electronics and, through them, the physics that it acts on.
        rng: Its own source of chance.

    Attributes:
        due_s: When it next does something all of a sudden; infinite for one that does not.
    """

    due_s = math.inf

    def __init__(self, defect: Defect, robot: Electronics, rng: np.random.Generator) -> None:
        self.defect = defect
        self.robot = robot
        self.rng = rng
        self._until = -math.inf
        self._next = defect.after + self._pause()

    def active(self, now: float) -> bool:
        """Return whether an occurrence goes on.

        With `every` they come at random from `after` on; without, one begins at `after`. Without
        `lasting` one never ends.
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
        """Draw how long it is until the next occurrence; 0 if the defect does not come again."""
        every = self.defect.every
        return float(self.rng.exponential(every)) if every > 0 else 0.0

    def begin(self) -> None:
        """Make the robot what the defect makes of it from the start."""

    def step(self, now: float) -> Incident | None:
        """Act on the robot at this time; return what the controller has to do with."""
        return None

    def frame(self, now: float, board: int, first: int, counts: Counts) -> Counts | None:
        """Return what the board's frame says instead; None when it does not arrive.

        Args:
            now: Time.
            board: Id of the board.
            first: Row of the channel table of its first channel.
            counts: What it should say; may be changed.
        """
        return counts

    def delivery(self, now: float) -> tuple[bool, bool]:
        """Return whether an array sent now arrives, and whether its echo does."""
        return True, True


class Sudden(Effect):
    """A defect that comes at moments, once or at random, and is done at once."""

    def __init__(self, defect: Defect, robot: Electronics, rng: np.random.Generator) -> None:
        super().__init__(defect, robot, rng)
        self.due_s = self._next

    def step(self, now: float) -> Incident | None:
        """Strike once the moment has come."""
        if now < self.due_s:
            return None
        self.due_s += self._pause() or math.inf
        return self.strike(now)

    def strike(self, now: float) -> Incident | None:
        """Do what the defect does; return what the controller has to do with."""
        raise NotImplementedError
