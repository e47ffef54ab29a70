"""What a detector by positions knows, as arrays for compiled code, and the looks made for it."""

from __future__ import annotations

from math import inf

import numpy as np

from pirate_sm.core.events import Look, WordWatch
from pirate_sm.core.sensing import Watch
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.gliding import columns as col

_MOST_SEEN = 32
_MOST_LOOKS = 64


class LookTables:
    """The tables of a detector.

    Args:
        wheels: How many wheels the robot has.

    Attributes:
        arrays: The arrays, as the arguments of `looking.look` after the first.
    """

    def __init__(self, wheels: int) -> None:
        self._looker: Floats = np.zeros(col.LOOKER_ENTRIES)
        self._seen: Floats = np.zeros((_MOST_SEEN, wheels + 1))
        self._looks: Floats = np.zeros((_MOST_LOOKS, wheels + 1))
        self._values: Floats = np.zeros(_MOST_SEEN)
        self._points: Floats = np.zeros((0, 2))
        self._bends: Floats = np.zeros((0, 2))
        self._of: tuple[object, object] = ((), ())

    @property
    def arrays(self) -> tuple[Floats, ...]:
        """Return the arrays, in the order of the arguments of `looking.look`."""
        return (
            *(self._looker, self._points, self._bends),
            *(self._seen, self._looks, self._values),
        )

    def take(self, words: WordWatch | None, watch: Watch) -> bool:
        """Take in what a detector knows; return whether there is room for it.

        Args:
            words: What it knows; None where none is relieved.
            watch: What the engine watches, which has heard the same word or not.
        """
        self._looker[:] = 0.0
        self._looker[col.L_DUE_S] = inf
        if words is None:
            return True
        count = len(words.seen)
        if count >= _MOST_SEEN:
            return False
        hears = words.name == watch.word and watch.listening_s < inf
        self._looker[:] = (
            *(words.due_s, words.every_s, words.window_s, words.driven, words.direction),
            *(words.slack_m, words.forgotten_m, words.word, words.said_s, words.repeat_s),
            *(words.valid_for_s if hears else 0.0, count, 0),
        )
        if count:
            self._seen[:count] = [(at, *places) for at, places in words.seen]
        if self._of != (words.points, words.bends):
            self._of = words.points, words.bends
            self._points = np.array(words.points, dtype=np.float64).reshape(-1, 2)
            self._bends = np.array(words.bends, dtype=np.float64).reshape(-1, 2)
        return True

    def made(self) -> tuple[list[Look], float]:
        """Return the looks that have been made, and when the next one is due."""
        count = int(self._looker[col.L_LOOKS])
        rows = self._looks[:count].tolist()
        return [(row[0], tuple(row[1:])) for row in rows], float(self._looker[col.L_DUE_S])
