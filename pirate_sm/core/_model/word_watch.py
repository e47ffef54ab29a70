"""What a detector by positions knows, so that others can look while it has nothing to say."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeAlias

Look: TypeAlias = tuple[float, tuple[float, ...]]
"""A time, and where each wheel was along the pipe."""


class WordWatch(NamedTuple):
    """What a detector knows between two looks; see :mod:`pirate_sm.robot.detectors.word_timing`.

    Attributes:
        places_m: Returns the position of each wheel along the pipe.
        due_s: When it looks next; ``every_s``: how long after each look it looks again.
        window_s: Over which time a position is filtered; ``seen``: the looks in it.
        driven: Whether wheels are driven.
        direction: In which direction they were driven last: 1 forward, -1 backward, 0 never.
        points: Per word, the farthest first, its wheel and what is added to how far the wheel is
            beyond a crossing; the word begins where the sum is 0.
        bends: The bends along the pipe, and how far each reaches: with the last of the points its
            words begin so much earlier, with the others so much later.
        slack_m: How far before its point the present word stays; ``forgotten_m``: how far beyond it
            a word ends.
        word: Index of the present word among the points; -1 without one. ``name``: the word.
        valid_for_s: How long it is valid.
        said_s: When it was said; ``repeat_s``: after which time it is said again, infinite without
            a word.
    """

    places_m: Callable[[], Sequence[float]]
    due_s: float
    every_s: float
    window_s: float
    seen: Sequence[Look]
    driven: bool
    direction: int
    points: tuple[tuple[int, float], ...]
    bends: tuple[tuple[float, float], ...]
    slack_m: float
    forgotten_m: float
    word: int
    name: str
    valid_for_s: float
    said_s: float
    repeat_s: float
