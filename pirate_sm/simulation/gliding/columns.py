"""Columns of the arrays that compiled code takes frames of boards with.

They are numbers in one file, which fills in nothing: `tables.py` does.
"""

from __future__ import annotations

from typing import TypeAlias

from pirate_sm.simulation.arrays import Floats, Ints, Words

TOLERANCE_S = 2e-9
"""The engine is called this long before a deadline; its own tolerance of times is less."""

# Columns of `boards`, a row per board by its position: where its rows of the table begin, where
# those end that measure, and where all end; the first row of its channels in the electronics, and
# how many values it reports.
B_BEGIN, B_MEASURED, B_END, B_ROW, B_VALUES = range(5)
BOARD_COLUMNS = 5

# Entries of `robot`: the period of reports, how long a board may be silent before anything follows
# from it, how often silent boards are looked for, the cell with the share of lost reports.
R_PERIOD_S, R_SILENT_S, R_LISTEN_EVERY_S, R_LOSS = range(4)

# Columns of `conditions`: the first instruction, that after the last, whether it holds, the boards.
K_BEGIN, K_END, K_HOLDS, K_BOARDS = range(4)

# Columns of `duties`; see `watch.SameDuty`.
P_ANGLE, P_TARGET, P_GAIN, P_THRESHOLD, P_LEAST, P_LIMIT, P_RESOLUTION, P_SENT = range(8)

# Entries of `watch`; see `watch.Watch`: when time stops, from when on no frame is quiet, when the
# engine must be called, the next deadline without the detector's word, and until when a report from
# outside counts.
A_UNTIL_S, A_FRAMES_S, A_ALARM_S, A_DEADLINE_S, A_OUTSIDE_S = range(5)

# Entries of `clock`: time, cycles, the time that the surroundings go by, when silent boards were
# looked for, when they will be next, until when the detector's word is valid.
T_NOW_S, T_CYCLES, T_PASSED_S, T_CHECKED_S, T_LISTENING_S, T_WORD_S = range(6)

# Columns of `turns`, one per cycle in turn: the board's position, the channels that the cycle
# reads, and whether the board reports after it.
U_BOARD, U_FIRST, U_LAST, U_REPORTS = range(4)

# Entries of `around`: the length of a cycle, how far a part may turn out of the plane, whether a
# robot is in the pipe as long as it touches a wall, and how far before and behind the pipe it has
# left it otherwise.
G_CYCLE_S, G_OUT_OF_PLANE, G_TOUCHING, G_BEFORE_M, G_BEHIND_M = range(5)

# Entries of `span`: cycles that have passed in all, how many may, the time that the surroundings go
# by, whether they must be looked at.
X_CYCLES, X_UNTIL, X_PASSED_S, X_MET = range(4)

PRESS = 6
"""The block of `press` among the quantities, see `physics.PER_WHEEL`."""

# Entries of `met`: frames taken, whether a frame waits for the engine, its board, whether the
# surroundings must be looked at, how often silent boards were looked for.
N_FRAMES, N_WAITING, N_BOARD, N_SURROUNDINGS, N_TICKS = range(5)

# Columns of `ticks`: when silent boards were looked for, when the engine would be called next, and
# whether that was in the step of a frame; or when the detector repeated its word, and infinity.
J_AT_S, J_WAKE_S, J_OF_FRAME = range(3)
TICK_COLUMNS = 3

# Entries of `looker`, what a detector by positions knows: when it looks and how often, whether
# wheels are driven and which way, the present word, when it was said, after which time it is said
# again and how long it is valid (0: the engine must hear it); see `core/_model/whereabouts.py`.
# Then how many looks of the window are in `seen`, and how many have been made.
L_DUE_S, L_EVERY_S, L_DRIVEN, L_DIRECTION, L_WORD = range(5)
L_SAID_S, L_REPEAT_S, L_VALID_S, L_SEEN, L_LOOKS = range(5, 10)
LOOKER_ENTRIES = 10

# The column of `points` with the wheel.
O_WHEEL = 0


# --- groups of arrays ----------------------------------------------------------------------------


Place: TypeAlias = tuple[Floats, Floats, Floats, Floats]
"""Quantities of the physics, laid out by `physics.QuantityLayout`; the roll joint's angle, then the
roll of each part, rad; position of each wheel along the pipe, m; `around`."""

Electronics: TypeAlias = tuple[Floats, Floats, Words, Floats]
"""The channel table, see `digitizing.digitize`; the last count of every channel; the state of the
generator of noise; the counts that defects show in place of those measured, NaN for the others."""

RobotRows: TypeAlias = tuple[Ints, Ints, Ints, Floats]
"""`boards`, the rows and the lists of the table of signals, `robot`."""

Scratch: TypeAlias = tuple[Floats, Floats]
"""As long as the signals, and the stack of :mod:`~pirate_sm.simulation.gliding.quiet`."""

Task: TypeAlias = tuple[Ints, Floats, Floats, Floats, Floats]
"""`conditions`, their code, the signals when the wait began, `duties`, `watch`."""

Posture: TypeAlias = tuple[Floats, Floats, Ints, Floats]
"""The chain, the parts, the accelerometer and the memory of the survey, see `surveyor.survey`; a
second row of this is memory for the next survey."""

Looker: TypeAlias = tuple[Floats, Floats, Floats, Floats, Floats, Floats]
"""`looker`, `points`; the bends, a row each: position and reach; the looks of the window and those
that have been made, a row each: the time, and the positions; scratch."""

Taken: TypeAlias = tuple[Floats, Ints, Floats, Floats, Ints]
"""Time, board (by its position) and values of each frame, a row each; `ticks`, `met`. The row after
the last frame may be one that waits for the engine."""
