"""The signals after frames that have changed nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import NamedTuple

from pirate_sm.engine.sensing.environment import Surveyed
from pirate_sm.engine.sensing.known_signals import Numbers, Sensing
from pirate_sm.engine.sensing.sensor_memory import BoardMemory
from pirate_sm.engine.state import EngineState
from pirate_sm.model.frame_block import FrameBlock
from pirate_sm.model.word_watch import Look


class Glided(NamedTuple):
    """What quiet frames change.

    The first are as in :class:`~pirate_sm.engine.sensing.known_signals.Sensing`; ``surveyed`` is
    what the survey remembers, ``wake_at_s`` the next time at which something changes without an
    event.
    """

    numbers: Numbers
    heard_s: Numbers
    shares: Numbers
    angles: Numbers
    records: tuple[BoardMemory, ...]
    loss: float
    checked_s: float
    wake_at_s: float
    surveyed: Surveyed


class Glide(NamedTuple):
    """Cycles that have passed without the engine.

    Attributes:
        now_s: The time reached.
        after: The signals after them; None where nothing has been taken.
        frames: The frames that were taken.
        ticks: When silent boards were looked for, and when something would change after that.
        looks: The looks that were made for a detector.
        due_s: When its next one is due.
    """

    now_s: float
    after: Glided | None
    frames: FrameBlock
    ticks: Sequence[tuple[float, float]] = ()
    looks: Sequence[Look] = ()
    due_s: float = inf


def after_glide(state: EngineState, after: Glided) -> EngineState:
    """Return the state with the signals after quiet frames."""
    sensing = sensing_after(state.sensing, after)
    return state._replace(sensing=sensing, surveyed=after.surveyed, wake_at_s=after.wake_at_s)


def sensing_after(sensing: Sensing, after: Glided) -> Sensing:
    """Return the signals after quiet frames."""
    numbers, heard_s, shares, angles, records, loss, checked_s, *_ = after
    return Sensing(
        *(numbers, heard_s, checked_s, sensing.stale, shares, angles, records),
        *(sensing.asked, loss, sensing.told, sensing.traction, sensing.outside_until_s),
    )
