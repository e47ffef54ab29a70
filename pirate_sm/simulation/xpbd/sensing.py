"""What is measured after a call: places along the pipe, and what the IMU feels."""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.machine_code import compiled
from pirate_sm.simulation.xpbd import columns as col


@compiled
def project(n: int, pos: Floats, legs: Floats, out: Floats) -> None:
    """Write arc length, offset towards side A and leg of each wheel to their blocks of `out`."""
    side = col.OUT_PER_WHEEL * n + col.OUT_SINGLE
    for i in range(n):
        best = np.inf
        for k in range(legs.shape[0]):
            dx = pos[i, 0] - legs[k, col.L_X]
            dy = pos[i, 1] - legs[k, col.L_Y]
            along = dx * legs[k, col.L_TX] + dy * legs[k, col.L_TY]
            across = dy * legs[k, col.L_TX] - dx * legs[k, col.L_TY]
            # The first and the last leg continue beyond the pipe's open ends.
            if k > 0:
                along = max(along, 0.0)
            if k < legs.shape[0] - 1:
                along = min(along, legs[k, col.L_LENGTH])
            ax = dx - along * legs[k, col.L_TX]
            ay = dy - along * legs[k, col.L_TY]
            away2 = ax * ax + ay * ay
            if away2 < best:
                best = away2
                out[7 * n + i] = legs[k, col.L_S] + along
                out[side + i] = across
                out[side + n + i] = k


@compiled
def feel(
    n: int,
    pos: Floats,
    accel_x: float,
    accel_y: float,
    legs: Floats,
    world: Floats,
    roll: Floats,
    out: Floats,
    w: Floats,
) -> None:
    """Write the IMU's quantities to `out`: specific force and field along forward, side B, up.

    "Up" is the normal of the plane of the part ahead of the roll joint. It points up when the
    pipe lies flat and the part has roll 0. In free fall the specific force is zero; what is
    shown of it is averaged.
    """
    k = col.OUT_PER_WHEEL * n
    m = min(max(int(world[col.ROLL_LINK]), 0), n - 2)
    leg = legs[int(out[(col.OUT_PER_WHEEL + 1) * n + col.OUT_SINGLE + m])]
    hx = pos[m, 0] - pos[m + 1, 0]
    hy = pos[m, 1] - pos[m + 1, 1]
    length = np.sqrt(hx * hx + hy * hy)
    hx /= length
    hy /= length
    cr = np.cos(roll[1])
    sr = np.sin(roll[1])
    across = leg[col.L_GN] if roll[1] == 0.0 else leg[col.L_GN] * cr - leg[col.L_GB] * sr
    fx = accel_x - (leg[col.L_GT] * leg[col.L_TX] - across * leg[col.L_TY])
    fy = accel_y - (leg[col.L_GT] * leg[col.L_TY] + across * leg[col.L_TX])
    share = world[col.FELT]
    out[k + 2] += share * (fx * hx + fy * hy - out[k + 2])
    out[k + 3] += share * (fx * hy - fy * hx - out[k + 3])
    out[k + 4] += share * (leg[col.L_GN] * sr + leg[col.L_GB] * cr - out[k + 4])
    sideways = world[col.MAG_X] * hy - world[col.MAG_Y] * hx
    out[k + 5] = world[col.MAG_X] * hx + world[col.MAG_Y] * hy
    out[k + 6] = sideways * cr - world[col.MAG_Z] * sr
    out[k + 7] = sideways * sr + world[col.MAG_Z] * cr
