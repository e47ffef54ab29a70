"""What is measured after a call: places along the pipe, rolls, and what the IMU feels."""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.kinematic.space import columns as col
from pirate_sm.simulation.machine_code import compiled


@compiled
def _on_leg(x: float, y: float, z: float, leg: Floats, first: bool, last: bool) -> float:
    """Return the place of a piece of the centre line that is nearest to a point, m along it.

    The first and the last piece continue beyond the pipe's ends.
    """
    dx = x - leg[col.C_X]
    dy = y - leg[col.C_Y]
    dz = z - leg[col.C_Z]
    along = dx * leg[col.C_TX] + dy * leg[col.C_TY] + dz * leg[col.C_TZ]
    if leg[col.C_RADIUS] > 0.0:
        inward = dx * leg[col.C_UX] + dy * leg[col.C_UY] + dz * leg[col.C_UZ]
        angle = np.arctan2(along, leg[col.C_RADIUS] - inward)
        # Beyond its ends the nearer one counts.
        opposite = 0.5 * leg[col.C_LENGTH] / leg[col.C_RADIUS] - np.pi
        if angle < opposite:
            angle += 2.0 * np.pi
        along = angle * leg[col.C_RADIUS]
    if not first:
        along = max(along, 0.0)
    if not last:
        along = min(along, leg[col.C_LENGTH])
    return float(along)


@compiled
def _at_leg(along: float, leg: Floats, spot: Floats) -> None:
    """Write a place of a piece of the centre line, and its tangent and side, to `spot`."""
    if leg[col.C_RADIUS] == 0.0:
        for k in range(3):
            spot[k] = leg[col.C_X + k] + along * leg[col.C_TX + k]
            spot[3 + k] = leg[col.C_TX + k]
            spot[6 + k] = leg[col.C_SX + k]
        return
    angle = along / leg[col.C_RADIUS]
    sin = np.sin(angle)
    cos = np.cos(angle)
    inward = (
        leg[col.C_SX] * leg[col.C_UX]
        + leg[col.C_SY] * leg[col.C_UY]
        + leg[col.C_SZ] * leg[col.C_UZ]
    )
    for k in range(3):
        t = leg[col.C_TX + k]
        u = leg[col.C_UX + k]
        spot[k] = leg[col.C_X + k] + leg[col.C_RADIUS] * (sin * t + (1.0 - cos) * u)
        spot[3 + k] = cos * t + sin * u
        spot[6 + k] = leg[col.C_SX + k] + inward * ((cos - 1.0) * u - sin * t)


@compiled
def _roll_of(p: int, parts: Floats, spot: Floats) -> float:
    """Return the roll of a part against the pipe where it is."""
    aside = 0.0
    for k in range(3):
        aside += parts[p, col.N_X + k] * spot[6 + k]
    up = parts[p, col.N_X] * (spot[4] * spot[8] - spot[5] * spot[7])
    up += parts[p, col.N_Y] * (spot[5] * spot[6] - spot[3] * spot[8])
    up += parts[p, col.N_Z] * (spot[3] * spot[7] - spot[4] * spot[6])
    return float(np.arctan2(aside, up))


@compiled
def project(
    n: int, pos: Floats, legs: Floats, world: Floats, parts: Floats, spot: Floats, out: Floats
) -> None:
    """Write the arc length of each wheel and the rolls of the parts to `out`."""
    r = int(world[col.ROLL_LINK])
    own = col.OUT_PER_WHEEL * n + col.OUT_SINGLE
    for i in range(n):
        best = np.inf
        at = 0
        there = 0.0
        for k in range(legs.shape[0]):
            first = k == 0
            last = k == legs.shape[0] - 1
            along = _on_leg(pos[i, 0], pos[i, 1], pos[i, 2], legs[k], first, last)
            _at_leg(along, legs[k], spot)
            away2 = (pos[i, 0] - spot[0]) ** 2
            away2 += (pos[i, 1] - spot[1]) ** 2 + (pos[i, 2] - spot[2]) ** 2
            if away2 < best:
                best = away2
                at = k
                there = along
        out[7 * n + i] = legs[at, col.C_ARC] + there
        if i == r or i == r + 1:
            _at_leg(there, legs[at], spot)
            out[own + col.OUT_ROLL_FRONT + i - r] = _roll_of(i - r, parts, spot)


@compiled
def feel(
    n: int,
    pos: Floats,
    accel_x: float,
    accel_y: float,
    accel_z: float,
    world: Floats,
    parts: Floats,
    out: Floats,
) -> None:
    """Write the IMU's quantities to `out`: specific force and field along forward, side B, up.

    "Up" is against the normal of the part ahead of the roll joint. In free fall the specific force
    is zero; what is shown of it is averaged.
    """
    k = col.OUT_PER_WHEEL * n + 2
    m = int(world[col.IMU_LINK])
    ex = pos[m, 0] - pos[m + 1, 0]
    ey = pos[m, 1] - pos[m + 1, 1]
    ez = pos[m, 2] - pos[m + 1, 2]
    length = np.sqrt(ex * ex + ey * ey + ez * ez)
    ex /= length
    ey /= length
    ez /= length
    nx = parts[0, col.N_X]
    ny = parts[0, col.N_Y]
    nz = parts[0, col.N_Z]
    bx = ny * ez - nz * ey
    by = nz * ex - nx * ez
    bz = nx * ey - ny * ex
    fx = accel_x - world[col.G_X]
    fy = accel_y - world[col.G_Y]
    fz = accel_z - world[col.G_Z]
    share = world[col.FELT]
    out[k] += share * (fx * ex + fy * ey + fz * ez - out[k])
    out[k + 1] -= share * (fx * bx + fy * by + fz * bz + out[k + 1])
    out[k + 2] -= share * (fx * nx + fy * ny + fz * nz + out[k + 2])
    out[k + 3] = world[col.MAG_X] * ex + world[col.MAG_Y] * ey + world[col.MAG_Z] * ez
    out[k + 4] = -(world[col.MAG_X] * bx + world[col.MAG_Y] * by + world[col.MAG_Z] * bz)
    out[k + 5] = -(world[col.MAG_X] * nx + world[col.MAG_Y] * ny + world[col.MAG_Z] * nz)
