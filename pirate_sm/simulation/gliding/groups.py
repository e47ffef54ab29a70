"""Groups of arrays that go through compiled functions together; see `columns.py` for each."""

from __future__ import annotations

from typing import TypeAlias

from pirate_sm.simulation.arrays import Floats, Ints, Words

Place: TypeAlias = tuple[Floats, Floats, Floats, Floats]
"""Quantities of the physics, laid out by `physics.QuantityLayout`; the roll joint's angle, then the
roll of each part, rad; position of each wheel along the pipe, m; `around`."""

Electronics: TypeAlias = tuple[Floats, Floats, Words, Floats]
"""The channel table, see `digitizing.digitize`; the last count of every channel; the state of the
generator of noise; the counts that defects show in place of those measured, NaN for the others."""

RobotRows: TypeAlias = tuple[Ints, Ints, Ints, Floats]
"""`boards`, the rows and the lists of the table of signals, `robot`."""

Scratch: TypeAlias = tuple[Floats, Floats]
"""As long as the signals, and the stack of :mod:`~pirate_sm.simulation.gliding.machine`."""

Task: TypeAlias = tuple[Ints, Floats, Floats, Floats, Floats]
"""`conditions`, their code, the signals when the wait began, `duties`, `watch`."""

Posture: TypeAlias = tuple[Floats, Floats, Floats, Ints, Floats]
"""`chain`, `parts`, `body`, a row of the parts that are held and two of memory, `surveyed`."""

Looker: TypeAlias = tuple[Floats, Floats, Floats, Floats, Floats, Floats]
"""`looker`, `points`; the bends, a row each: position and reach; the looks of the window and those
that have been made, a row each: the time, and the positions; scratch."""

Taken: TypeAlias = tuple[Floats, Ints, Floats, Floats, Ints]
"""Time, board (by its position) and values of each frame, a row each; `ticks`, `met`. The row after
the last frame may be one that waits for the engine."""
