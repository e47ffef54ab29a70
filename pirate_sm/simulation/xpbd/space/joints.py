"""Joints between links, which springs pull, and the length of links."""

from __future__ import annotations

from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.machine_code import compiled
from pirate_sm.simulation.xpbd.joints import resist
from pirate_sm.simulation.xpbd.space import columns as col


@compiled
def turned_rad(i: int, mov: Floats, w: Floats) -> float:
    """Return by how much a joint has turned in this substep."""
    # Three short sums, because one long sum would wait for each of its terms in turn.
    ahead = w[i, col.GA_X] * mov[i - 1, 0]
    ahead += w[i, col.GA_Y] * mov[i - 1, 1]
    ahead += w[i, col.GA_Z] * mov[i - 1, 2]
    middle = w[i, col.GM_X] * mov[i, 0]
    middle += w[i, col.GM_Y] * mov[i, 1]
    middle += w[i, col.GM_Z] * mov[i, 2]
    behind = w[i, col.GB_X] * mov[i + 1, 0]
    behind += w[i, col.GB_Y] * mov[i + 1, 1]
    behind += w[i, col.GB_Z] * mov[i + 1, 2]
    return float(behind + middle + ahead)


@compiled
def solve_joints(
    n: int, mov: Floats, bend: Floats, motor: Floats, body: Floats, dt2: float, w: Floats
) -> None:
    """Pull each joint once towards its motor-side angle through its spring."""
    for i in range(1, n - 1):
        turned = turned_rad(i, mov, w)
        left = motor[i] - bend[i] - turned * (1.0 + w[i, col.J_D]) - w[i, col.J_C] * w[i, col.J_LAM]
        delta = left * w[i, col.J_INV]
        w[i, col.J_LAM] += delta
        turned += w[i, col.J_W] * delta
        if w[i, col.J_RESISTS] != 0.0:
            delta += resist(i, turned, bend[i], body, dt2, w)
        step = body[i - 1, col.MASS_INV] * delta
        mov[i - 1, 0] += step * w[i, col.GA_X]
        mov[i - 1, 1] += step * w[i, col.GA_Y]
        mov[i - 1, 2] += step * w[i, col.GA_Z]
        step = body[i, col.MASS_INV] * delta
        mov[i, 0] += step * w[i, col.GM_X]
        mov[i, 1] += step * w[i, col.GM_Y]
        mov[i, 2] += step * w[i, col.GM_Z]
        step = body[i + 1, col.MASS_INV] * delta
        mov[i + 1, 0] += step * w[i, col.GB_X]
        mov[i + 1, 1] += step * w[i, col.GB_Y]
        mov[i + 1, 2] += step * w[i, col.GB_Z]


@compiled
def solve_links(n: int, mov: Floats, body: Floats, w: Floats) -> None:
    """Bring each link back to its length once."""
    for m in range(n - 1):
        dx = w[m, col.D_X] + mov[m, 0] - mov[m + 1, 0]
        dy = w[m, col.D_Y] + mov[m, 1] - mov[m + 1, 1]
        dz = w[m, col.D_Z] + mov[m, 2] - mov[m + 1, 2]
        # (d^2 - l^2) / 2l has the same root as d - l and needs no square root.
        scale = body[m, col.LINK_LENGTH] ** 2 - dx * dx - dy * dy - dz * dz
        scale *= w[m, col.LINK_SCALE]
        ahead = scale * body[m, col.MASS_INV]
        behind = scale * body[m + 1, col.MASS_INV]
        mov[m, 0] += ahead * dx
        mov[m, 1] += ahead * dy
        mov[m, 2] += ahead * dz
        mov[m + 1, 0] -= behind * dx
        mov[m + 1, 1] -= behind * dy
        mov[m + 1, 2] -= behind * dz
