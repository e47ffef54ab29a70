"""Look for silent boards in compiled code, as long as all of them have reported."""

from __future__ import annotations

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.gliding import columns as col
from pirate_sm.simulation.machine_code import compiled


@compiled
def may_listen(
    now_s: float, heard_s: Floats, robot: Floats, watch: Floats, ticks: Floats, met: Ints
) -> bool:
    """Return whether every board has reported lately, and nothing else is due.

    If not, the engine has to look. `heard_s` tells when each board last reported; see
    :mod:`pirate_sm.core.robot`.
    """
    if met[col.N_TICKS] == ticks.shape[0] or heard_s.shape[0] == 0:
        return False
    if now_s >= watch[col.A_ALARM_S] - col.TOLERANCE_S:
        return False
    newest_s = heard_s[0]
    for at_s in heard_s:
        newest_s = max(newest_s, at_s)
        if (
            at_s <= now_s - robot[col.R_STALE_AFTER_S]
            or at_s <= now_s - robot[col.R_SILENT_AFTER_S]
        ):
            return False
    return bool(newest_s > now_s - robot[col.R_SILENT_AFTER_S] / 2)


@compiled
def listen(
    now_s: float,
    of_frame: float,
    robot: Floats,
    watch: Floats,
    clock: Floats,
    ticks: Floats,
    met: Ints,
) -> None:
    """Note that every board has reported. See `columns.py` for the arrays."""
    made = met[col.N_TICKS]
    clock[col.T_CHECKED_S] = now_s
    clock[col.T_LISTENING_S] = now_s + robot[col.R_LISTEN_EVERY_S]
    ticks[made, col.J_AT_S] = now_s
    ticks[made, col.J_WAKE_S] = min(watch[col.A_ALARM_S], clock[col.T_LISTENING_S])
    ticks[made, col.J_OF_FRAME] = of_frame
    met[col.N_TICKS] = made + 1
