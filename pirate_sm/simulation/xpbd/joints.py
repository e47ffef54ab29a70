"""Joints between links, which springs pull, and the length of links."""

from __future__ import annotations

from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.machine_code import compiled
from pirate_sm.simulation.xpbd import columns as col


@compiled
def turned_rad(i: int, pos: Floats, w: Floats) -> float:
    """Return by how much a joint has turned in this substep."""
    # Three short sums, because one long sum would wait for each of its terms in turn.
    ahead = w[i, col.GA_X] * (pos[i - 1, 0] - w[i - 1, col.X0])
    ahead += w[i, col.GA_Y] * (pos[i - 1, 1] - w[i - 1, col.Y0])
    middle = w[i, col.GM_X] * (pos[i, 0] - w[i, col.X0]) + w[i, col.GM_Y] * (
        pos[i, 1] - w[i, col.Y0]
    )
    behind = w[i, col.GB_X] * (pos[i + 1, 0] - w[i + 1, col.X0])
    behind += w[i, col.GB_Y] * (pos[i + 1, 1] - w[i + 1, col.Y0])
    return float(behind + middle + ahead)


@compiled
def resist(i: int, turned: float, bend: float, body: Floats, dt2: float, w: Floats) -> float:
    """Return the impulse that a joint's dry friction and end stops add after it has turned."""
    added = 0.0
    if body[i, col.JOINT_FRICTION] > 0.0:
        limit = body[i, col.JOINT_FRICTION] * dt2
        new = min(max(w[i, col.J_FRICTION] - turned / w[i, col.J_W], -limit), limit)
        added = new - w[i, col.J_FRICTION]
        w[i, col.J_FRICTION] = new
    angle = bend + turned + added * w[i, col.J_W]
    old = w[i, col.J_STOP]
    if angle > body[i, col.JOINT_MAX] or old < 0.0:
        w[i, col.J_STOP] = min(0.0, old - (angle - body[i, col.JOINT_MAX]) / w[i, col.J_W])
    elif angle < body[i, col.JOINT_MIN] or old > 0.0:
        w[i, col.J_STOP] = max(0.0, old - (angle - body[i, col.JOINT_MIN]) / w[i, col.J_W])
    return float(added + w[i, col.J_STOP] - old)


@compiled
def solve_joints(
    n: int, pos: Floats, bend: Floats, motor: Floats, body: Floats, dt2: float, w: Floats
) -> None:
    """Pull each joint once towards its motor-side angle through its spring."""
    for i in range(1, n - 1):
        turned = turned_rad(i, pos, w)
        left = motor[i] - bend[i] - turned * (1.0 + w[i, col.J_D]) - w[i, col.J_C] * w[i, col.J_LAM]
        delta = left * w[i, col.J_INV]
        w[i, col.J_LAM] += delta
        turned += w[i, col.J_W] * delta
        if w[i, col.J_RESISTS] != 0.0:
            delta += resist(i, turned, bend[i], body, dt2, w)
        step = body[i - 1, col.MASS_INV] * delta
        pos[i - 1, 0] += step * w[i, col.GA_X]
        pos[i - 1, 1] += step * w[i, col.GA_Y]
        step = body[i, col.MASS_INV] * delta
        pos[i, 0] += step * w[i, col.GM_X]
        pos[i, 1] += step * w[i, col.GM_Y]
        step = body[i + 1, col.MASS_INV] * delta
        pos[i + 1, 0] += step * w[i, col.GB_X]
        pos[i + 1, 1] += step * w[i, col.GB_Y]


@compiled
def solve_links(n: int, pos: Floats, body: Floats, w: Floats) -> None:
    """Bring each link back to its length once."""
    for m in range(n - 1):
        dx = pos[m, 0] - pos[m + 1, 0]
        dy = pos[m, 1] - pos[m + 1, 1]
        # (d^2 - l^2) / 2l has the same root as d - l and needs no square root.
        scale = (body[m, col.LINK_LENGTH] ** 2 - dx * dx - dy * dy) * w[m, col.LINK_SCALE]
        ahead = scale * body[m, col.MASS_INV]
        behind = scale * body[m + 1, col.MASS_INV]
        pos[m, 0] += ahead * dx
        pos[m, 1] += ahead * dy
        pos[m + 1, 0] -= behind * dx
        pos[m + 1, 1] -= behind * dy
