"""The planes in which the two parts lie, and the twist between them."""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.machine_code import compiled
from pirate_sm.simulation.xpbd.space import columns as col

# Stiff enough to hold a link in its plane, soft enough for few iterations [decided by trial].
_PLANE_COMPLIANCE_M_N = 1e-6


@compiled
def stand(pos: Floats, roll: Floats, world: Floats, parts: Floats) -> None:
    """Bring the parts' normals square to the roll link, and measure the roll joint."""
    r = int(world[col.ROLL_LINK])
    ex = pos[r, 0] - pos[r + 1, 0]
    ey = pos[r, 1] - pos[r + 1, 1]
    ez = pos[r, 2] - pos[r + 1, 2]
    share = 1.0 / np.sqrt(ex * ex + ey * ey + ez * ez)
    ex *= share
    ey *= share
    ez *= share
    for p in range(2):
        nx = roll[3 * p]
        ny = roll[3 * p + 1]
        nz = roll[3 * p + 2]
        off = nx * ex + ny * ey + nz * ez
        nx -= off * ex
        ny -= off * ey
        nz -= off * ez
        share = 1.0 / np.sqrt(nx * nx + ny * ny + nz * nz)
        nx *= share
        ny *= share
        nz *= share
        parts[p, col.N_ROLLED] = 0.0
        parts[p, col.N_X] = nx
        parts[p, col.N_Y] = ny
        parts[p, col.N_Z] = nz
        parts[p, col.N_BX] = ny * ez - nz * ey
        parts[p, col.N_BY] = nz * ex - nx * ez
        parts[p, col.N_BZ] = nx * ey - ny * ex
    sin = 0.0
    cos = 0.0
    for k in range(3):
        sin += parts[0, col.N_X + k] * parts[1, col.N_BX + k]
        cos += parts[0, col.N_X + k] * parts[1, col.N_X + k]
    change = np.arctan2(sin, cos) - roll[col.R_ANGLE]
    roll[col.R_ANGLE] += change - 2.0 * np.pi * np.rint(change / (2.0 * np.pi))


@compiled
def keep(roll: Floats, parts: Floats, dt: float) -> None:
    """Turn the parts' normals by what they have rolled in a substep."""
    for p in range(2):
        parts[p, col.N_ROLLED] += parts[p, col.N_ROLL]
        # Cosine and sine of an angle whose half has this tangent; it rolls by mrad.
        half = 0.5 * parts[p, col.N_ROLLED]
        share = 1.0 / (1.0 + half * half)
        cos = (1.0 - half * half) * share
        sin = 2.0 * half * share
        for k in range(3):
            roll[3 * p + k] = cos * parts[p, col.N_X + k] + sin * parts[p, col.N_BX + k]
        roll[col.R_RATE + p] = parts[p, col.N_ROLL] / dt


@compiled
def lie_in_planes(n: int, body: Floats, world: Floats, w: Floats, parts: Floats) -> None:
    """Set values and gradients of the links' coplanarity with the normals of their parts."""
    r = int(world[col.ROLL_LINK])
    compliance = _PLANE_COMPLIANCE_M_N / (world[col.DT] * world[col.DT])
    inv_r = body[r, col.MASS_INV]
    inv_s = body[r + 1, col.MASS_INV]
    length = np.sqrt(w[r, col.D_X] ** 2 + w[r, col.D_Y] ** 2 + w[r, col.D_Z] ** 2)
    for m in range(n - 1):
        if m == r:
            continue
        p = 0 if m < r else 1
        value = 0.0
        turn = 0.0
        tilt = 0.0
        for k in range(3):
            value += w[m, col.D_X + k] * parts[p, col.N_X + k]
            turn += w[m, col.D_X + k] * parts[p, col.N_BX + k]
            tilt += w[m, col.D_X + k] * w[r, col.D_X + k]
        tilt /= length * length
        w[m, col.P_C] = value
        w[m, col.P_ROLL] = turn
        w[m, col.P_TILT] = tilt
        w[m, col.P_LAM] = 0.0
        # The link shares a node with the roll link where it is next to it.
        at_r = -tilt - 1.0 if m == r - 1 else -tilt
        at_s = tilt + 1.0 if m == r + 1 else tilt
        mass_inv = inv_r * at_r * at_r + inv_s * at_s * at_s + turn * turn * parts[p, col.N_INV_I]
        if m != r + 1:
            mass_inv += body[m, col.MASS_INV]
        if m != r - 1:
            mass_inv += body[m + 1, col.MASS_INV]
        w[m, col.P_INV] = 1.0 / (mass_inv + compliance)


@compiled
def solve_planes(
    n: int, mov: Floats, body: Floats, world: Floats, w: Floats, parts: Floats, off: Floats
) -> None:
    """Bring each link into the plane of its part once.

    `off` has two rows: how far each wheel has moved out of the plane, and before this.
    """
    r = int(world[col.ROLL_LINK])
    compliance = _PLANE_COMPLIANCE_M_N / (world[col.DT] * world[col.DT])
    for p in range(2):
        first = 0 if p == 0 else r
        last = r + 1 if p == 0 else n - 1
        nx = parts[p, col.N_X]
        ny = parts[p, col.N_Y]
        nz = parts[p, col.N_Z]
        for i in range(first, last + 1):
            off[0, i] = nx * mov[i, 0] + ny * mov[i, 1] + nz * mov[i, 2]
            off[1, i] = off[0, i]
        for m in range(first, last):
            if m == r:
                continue
            tilt = w[m, col.P_TILT]
            value = w[m, col.P_C] + off[0, m] - off[0, m + 1]
            value += w[m, col.P_ROLL] * parts[p, col.N_ROLL] - tilt * (off[0, r] - off[0, r + 1])
            delta = -(value + compliance * w[m, col.P_LAM]) * w[m, col.P_INV]
            w[m, col.P_LAM] += delta
            off[0, m] += body[m, col.MASS_INV] * delta
            off[0, m + 1] -= body[m + 1, col.MASS_INV] * delta
            off[0, r] -= body[r, col.MASS_INV] * delta * tilt
            off[0, r + 1] += body[r + 1, col.MASS_INV] * delta * tilt
            parts[p, col.N_ROLL] += parts[p, col.N_INV_I] * w[m, col.P_ROLL] * delta
        for i in range(first, last + 1):
            step = off[0, i] - off[1, i]
            mov[i, 0] += step * nx
            mov[i, 1] += step * ny
            mov[i, 2] += step * nz


@compiled
def solve_twist(roll: Floats, parts: Floats, dt: float, impulse: float) -> float:
    """Pull the two parts once towards the motor of the roll joint; return the impulse so far."""
    compliance = 1.0 / (col.TWIST_NM_RAD * dt * dt)
    left = roll[col.R_MOTOR] - roll[col.R_ANGLE] - parts[0, col.N_ROLL] + parts[1, col.N_ROLL]
    both = parts[0, col.N_INV_I] + parts[1, col.N_INV_I]
    delta = (left - compliance * impulse) / (both + compliance)
    parts[0, col.N_ROLL] += parts[0, col.N_INV_I] * delta
    parts[1, col.N_ROLL] -= parts[1, col.N_INV_I] * delta
    return float(impulse + delta)
