"""Contacts of links with edges and with the inner sides of elbows."""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.machine_code import compiled
from pirate_sm.simulation.xpbd.space import columns as col
from pirate_sm.simulation.xpbd.space.walls import foot, on_edge


@compiled
def _lean(
    count: int,
    m: int,
    share: float,
    hit: Floats,
    body: Floats,
    world: Floats,
    cor: Floats,
    who: Ints,
) -> int:
    """Note a contact of a link; return the count. `hit`: the normal, the distance of its middle."""
    gap = hit[3] - world[col.HALF_THICKNESS]
    if (
        gap > col.MARGIN_M * world[col.LOOK]
        or gap < -2.0 * world[col.HALF_THICKNESS]
        or count == cor.shape[0]
    ):
        return count
    compliance = world[col.CONTACT_COMPLIANCE] / (world[col.DT] * world[col.DT])
    who[count] = m
    cor[count, col.K_NX] = hit[0]
    cor[count, col.K_NY] = hit[1]
    cor[count, col.K_NZ] = hit[2]
    cor[count, col.K_SHARE] = share
    cor[count, col.K_GAP] = gap
    cor[count, col.K_PUSH] = 0.0
    mass_inv = body[m, col.MASS_INV] * (1.0 - share) ** 2 + body[m + 1, col.MASS_INV] * share**2
    cor[count, col.K_INV] = 1.0 / (mass_inv + compliance)
    return count + 1


@compiled
def _share(pos: Floats, m: int, x: float, y: float, z: float) -> float:
    """Return where on a link is the place nearest to a point: 0 its front end, 1 its rear end."""
    ex = pos[m + 1, 0] - pos[m, 0]
    ey = pos[m + 1, 1] - pos[m, 1]
    ez = pos[m + 1, 2] - pos[m, 2]
    along = (x - pos[m, 0]) * ex + (y - pos[m, 1]) * ey + (z - pos[m, 2]) * ez
    return float(along / (ex * ex + ey * ey + ez * ez))


@compiled
def _lean_on_edge(
    count: int,
    m: int,
    pos: Floats,
    edge: Floats,
    points: Floats,
    at: int,
    body: Floats,
    world: Floats,
    cor: Floats,
    who: Ints,
    hit: Floats,
) -> int:
    """Note the contact of a link with an edge, if any; return the count."""
    share = _share(pos, m, points[at, col.P_X], points[at, col.P_Y], points[at, col.P_Z])
    for _ in range(2):
        share = min(max(share, 0.0), 1.0)
        x = pos[m, 0] + share * (pos[m + 1, 0] - pos[m, 0])
        y = pos[m, 1] + share * (pos[m + 1, 1] - pos[m, 1])
        z = pos[m, 2] + share * (pos[m + 1, 2] - pos[m, 2])
        at = on_edge(x, y, z, edge, points, at, hit)
        share = _share(pos, m, hit[0], hit[1], hit[2])
    if share <= 0.0 or share >= 1.0:
        return count
    x = pos[m, 0] + share * (pos[m + 1, 0] - pos[m, 0]) - hit[0]
    y = pos[m, 1] + share * (pos[m + 1, 1] - pos[m, 1]) - hit[1]
    z = pos[m, 2] + share * (pos[m + 1, 2] - pos[m, 2]) - hit[2]
    away = np.sqrt(x * x + y * y + z * z)
    if away > world[col.HALF_THICKNESS] + col.MARGIN_M * world[col.LOOK] or away < 1e-9:
        return count
    # The link may have got over the edge with its middle; the pipe's inside says which way is out.
    if x * points[at, col.P_IX] + y * points[at, col.P_IY] + z * points[at, col.P_IZ] < 0.0:
        away = -away
    hit[0] = x / away
    hit[1] = y / away
    hit[2] = z / away
    hit[3] = away
    return int(_lean(count, m, share, hit, body, world, cor, who))


@compiled
def find_leaning(
    n: int,
    pos: Floats,
    solids: Floats,
    edges: Floats,
    points: Floats,
    body: Floats,
    world: Floats,
    near: Ints,
    nears: Ints,
    rims: Ints,
    link_at: Ints,
    cor: Floats,
    who: Ints,
    hit: Floats,
) -> int:
    """Write the links that touch an edge or the inner side of an elbow; return the count."""
    count = 0
    for m in range(n - 1):
        if rims[m] != 0:
            for k in range(edges.shape[0]):
                at = link_at[m, k]
                if at >= 0:
                    count = _lean_on_edge(
                        count, m, pos, edges[k], points, at, body, world, cor, who, hit
                    )
        for k in range(nears[m]):
            solid = near[m, k]
            if solids[solid, col.KIND] != col.TORUS:
                continue
            # The place of the link that is nearest to the axis of the ring.
            ax = solids[solid, col.A_X]
            ay = solids[solid, col.A_Y]
            az = solids[solid, col.A_Z]
            dx = pos[m, 0] - solids[solid, col.O_X]
            dy = pos[m, 1] - solids[solid, col.O_Y]
            dz = pos[m, 2] - solids[solid, col.O_Z]
            ex = pos[m + 1, 0] - pos[m, 0]
            ey = pos[m + 1, 1] - pos[m, 1]
            ez = pos[m + 1, 2] - pos[m, 2]
            de = dx * ex + dy * ey + dz * ez
            da = dx * ax + dy * ay + dz * az
            ea = ex * ax + ey * ay + ez * az
            length2 = ex * ex + ey * ey + ez * ez - ea * ea
            if length2 < 1e-9:
                continue
            share = -(de - da * ea) / length2
            if share <= 0.0 or share >= 1.0:
                continue
            x = pos[m, 0] + share * ex
            y = pos[m, 1] + share * ey
            z = pos[m, 2] + share * ez
            if foot(x, y, z, solids, solid, hit):
                count = _lean(count, m, share, hit, body, world, cor, who)
    return count


@compiled
def clear(c: int, m: int, mov: Floats, cor: Floats) -> float:
    """Return the gap between a link and what it leans on after what it has moved."""
    behind = cor[c, col.K_SHARE]
    ahead = 1.0 - behind
    gap = cor[c, col.K_GAP]
    gap += cor[c, col.K_NX] * ahead * mov[m, 0]
    gap += cor[c, col.K_NY] * ahead * mov[m, 1]
    gap += cor[c, col.K_NZ] * ahead * mov[m, 2]
    gap += cor[c, col.K_NX] * behind * mov[m + 1, 0]
    gap += cor[c, col.K_NY] * behind * mov[m + 1, 1]
    gap += cor[c, col.K_NZ] * behind * mov[m + 1, 2]
    return float(gap)


@compiled
def solve_leaning(
    count: int, mov: Floats, body: Floats, compliance: float, w: Floats, cor: Floats, who: Ints
) -> None:
    """Push each link that leans on something clear of it once."""
    for c in range(count):
        m = who[c]
        behind = cor[c, col.K_SHARE]
        ahead = 1.0 - behind
        gap = clear(c, m, mov, cor)
        new = max(
            0.0, cor[c, col.K_PUSH] - (gap + compliance * cor[c, col.K_PUSH]) * cor[c, col.K_INV]
        )
        delta = new - cor[c, col.K_PUSH]
        cor[c, col.K_PUSH] = new
        step = body[m, col.MASS_INV] * ahead * delta
        mov[m, 0] += step * cor[c, col.K_NX]
        mov[m, 1] += step * cor[c, col.K_NY]
        mov[m, 2] += step * cor[c, col.K_NZ]
        step = body[m + 1, col.MASS_INV] * behind * delta
        mov[m + 1, 0] += step * cor[c, col.K_NX]
        mov[m + 1, 1] += step * cor[c, col.K_NY]
        mov[m + 1, 2] += step * cor[c, col.K_NZ]
