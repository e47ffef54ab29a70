"""Where the walls and edges of the pipes are, seen from a point, and which of them are near."""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.kinematic.space import columns as col
from pirate_sm.simulation.machine_code import compiled

# How much nearer than they were a wheel or link may come to a wall during a call, besides what its
# speed brings it.
_NEAR_M = 0.02


@compiled
def _in_bounds(x: float, y: float, z: float, solids: Floats, k: int, foot: Floats) -> bool:
    """Return whether a foot lies between a solid's planes and outside its hole."""
    fx, fy, fz = foot[0], foot[1], foot[2]
    first = solids[k, col.F_X] * fx + solids[k, col.F_Y] * fy + solids[k, col.F_Z] * fz
    if first < solids[k, col.F_VALUE]:
        return False
    last = solids[k, col.L_X] * fx + solids[k, col.L_Y] * fy + solids[k, col.L_Z] * fz
    if last > solids[k, col.L_VALUE]:
        return False
    if solids[k, col.HOLE] == col.NO_HOLE:
        return True
    dx = fx - solids[k, col.H_X]
    dy = fy - solids[k, col.H_Y]
    dz = fz - solids[k, col.H_Z]
    along = dx * solids[k, col.H_DX] + dy * solids[k, col.H_DY] + dz * solids[k, col.H_DZ]
    if solids[k, col.HOLE] == col.HALF_HOLE and along < 0.0:
        return True
    away2 = dx * dx + dy * dy + dz * dz - along * along
    return bool(away2 >= solids[k, col.H_RADIUS] ** 2)


@compiled
def foot(x: float, y: float, z: float, solids: Floats, k: int, hit: Floats) -> bool:
    """Return whether a solid's wall counts for a point; write the wall there to `hit`.

    `hit` gets the unit normal into the pipe and the distance from the wall, negative behind it.
    """
    dx = x - solids[k, col.O_X]
    dy = y - solids[k, col.O_Y]
    dz = z - solids[k, col.O_Z]
    ax = solids[k, col.A_X]
    ay = solids[k, col.A_Y]
    az = solids[k, col.A_Z]
    along = dx * ax + dy * ay + dz * az
    rx = dx - along * ax
    ry = dy - along * ay
    rz = dz - along * az
    off = np.sqrt(rx * rx + ry * ry + rz * rz)
    kind = solids[k, col.KIND]
    if kind == col.DISC:
        hit[0] = ax
        hit[1] = ay
        hit[2] = az
        hit[3] = along
        if not solids[k, col.SLOPE_OR_SIZE] <= off <= solids[k, col.SIZE]:
            return False
    elif off < 1e-9:
        return False
    elif kind == col.TORUS:
        share = solids[k, col.SLOPE_OR_SIZE] / off
        rx = dx - share * rx
        ry = dy - share * ry
        rz = dz - share * rz
        away = np.sqrt(rx * rx + ry * ry + rz * rz)
        if away < 1e-9:
            return False
        hit[0] = -rx / away
        hit[1] = -ry / away
        hit[2] = -rz / away
        hit[3] = solids[k, col.SIZE] - away
    else:
        slope = solids[k, col.SLOPE_OR_SIZE]
        cos = solids[k, col.COSINE]
        sin = slope * cos
        share = cos / off
        hit[0] = sin * ax - share * rx
        hit[1] = sin * ay - share * ry
        hit[2] = sin * az - share * rz
        hit[3] = (solids[k, col.SIZE] + slope * along - off) * cos
    hit[4] = x - hit[3] * hit[0]
    hit[5] = y - hit[3] * hit[1]
    hit[6] = z - hit[3] * hit[2]
    return bool(_in_bounds(x, y, z, solids, k, hit[4:]))


@compiled
def _beside(edge: Floats, at: int, step: int) -> int:
    """Return the point of an edge that is `step` points on; -1 beyond its ends."""
    count = int(edge[col.E_COUNT])
    k = at - int(edge[col.E_FIRST]) + step
    if edge[col.E_CLOSED] != 0.0:
        k = (k + count) % count
    elif k < 0 or k >= count:
        return -1
    return k + int(edge[col.E_FIRST])


@compiled
def _walk(x: float, y: float, z: float, edge: Floats, points: Floats, at: int) -> int:
    """Return the point of an edge nearest to a place, walking from point `at`."""
    best = np.inf
    for _ in range(int(edge[col.E_COUNT])):
        here = at
        for step in (-1, 0, 1):
            k = _beside(edge, here, step)
            if k < 0:
                continue
            dx = x - points[k, col.P_X]
            dy = y - points[k, col.P_Y]
            dz = z - points[k, col.P_Z]
            away2 = dx * dx + dy * dy + dz * dz
            if away2 < best:
                best = away2
                at = k
        if at == here:
            break
    return at


@compiled
def on_edge(
    x: float, y: float, z: float, edge: Floats, points: Floats, at: int, hit: Floats
) -> int:
    """Return the point of an edge nearest to a place, walking from point `at`.

    `hit` gets the nearest place of the line and its squared distance.
    """
    at = _walk(x, y, z, edge, points, at)
    hit[3] = np.inf
    for step in (-1, 1):
        k = _beside(edge, at, step)
        if k < 0:
            continue
        ex = points[k, col.P_X] - points[at, col.P_X]
        ey = points[k, col.P_Y] - points[at, col.P_Y]
        ez = points[k, col.P_Z] - points[at, col.P_Z]
        dx = x - points[at, col.P_X]
        dy = y - points[at, col.P_Y]
        dz = z - points[at, col.P_Z]
        share = (dx * ex + dy * ey + dz * ez) / (ex * ex + ey * ey + ez * ez)
        share = min(max(share, 0.0), 1.0)
        dx -= share * ex
        dy -= share * ey
        dz -= share * ez
        away2 = dx * dx + dy * dy + dz * dz
        if away2 < hit[3]:
            hit[0] = x - dx
            hit[1] = y - dy
            hit[2] = z - dz
            hit[3] = away2
    return at


@compiled
def _nearest_point(
    x: float,
    y: float,
    z: float,
    ex: float,
    ey: float,
    ez: float,
    edge: Floats,
    points: Floats,
    reach: float,
) -> int:
    """Return the point of an edge nearest to a line; -1 if none is within reach.

    The line begins at (x, y, z) and goes by (ex, ey, ez), which may be nothing.
    """
    first = int(edge[col.E_FIRST])
    length2 = ex * ex + ey * ey + ez * ez
    found = -1
    best = reach * reach
    for k in range(first, first + int(edge[col.E_COUNT])):
        dx = points[k, col.P_X] - x
        dy = points[k, col.P_Y] - y
        dz = points[k, col.P_Z] - z
        if length2 > 0.0:
            share = min(max((dx * ex + dy * ey + dz * ez) / length2, 0.0), 1.0)
            dx -= share * ex
            dy -= share * ey
            dz -= share * ez
        away2 = dx * dx + dy * dy + dz * dz
        if away2 < best:
            best = away2
            found = k
    return found


@compiled
def look_around(
    n: int,
    pos: Floats,
    vel: Floats,
    body: Floats,
    solids: Floats,
    edges: Floats,
    points: Floats,
    world: Floats,
    passed: float,
    near: Ints,
    nears: Ints,
    rims: Ints,
    rim_at: Ints,
    link_at: Ints,
) -> None:
    """Note the solids and edges that each wheel, and each link, may touch during this call.

    Writes the numbers of the solids near a wheel to `near`, how many to `nears`; for each edge the
    nearest point, -1 where the edge is far, to `rim_at` and `link_at`; and in `rims` whether any is
    near, 0 or more.
    """
    for i in range(n):
        x, y, z = pos[i, 0], pos[i, 1], pos[i, 2]
        speed = np.sqrt(vel[i, 0] ** 2 + vel[i, 1] ** 2 + vel[i, 2] ** 2)
        reach = world[col.RADIUS] + _NEAR_M + 2.0 * (speed + passed * 9.81) * passed
        nears[i] = 0
        for k in range(solids.shape[0]):
            dx = x - solids[k, col.B_X]
            dy = y - solids[k, col.B_Y]
            dz = z - solids[k, col.B_Z]
            length2 = solids[k, col.B_DX] ** 2 + solids[k, col.B_DY] ** 2 + solids[k, col.B_DZ] ** 2
            share = dx * solids[k, col.B_DX] + dy * solids[k, col.B_DY] + dz * solids[k, col.B_DZ]
            share = min(max(share / length2, 0.0), 1.0) if length2 > 0.0 else 0.0
            dx -= share * solids[k, col.B_DX]
            dy -= share * solids[k, col.B_DY]
            dz -= share * solids[k, col.B_DZ]
            if dx * dx + dy * dy + dz * dz < (solids[k, col.B_RADIUS] + reach) ** 2:
                near[i, nears[i]] = k
                nears[i] += 1
        rims[i] = 0
        for k in range(edges.shape[0]):
            dx = x - edges[k, col.E_X]
            dy = y - edges[k, col.E_Y]
            dz = z - edges[k, col.E_Z]
            away2 = dx * dx + dy * dy + dz * dz
            rim_at[i, k] = -1
            link_at[i, k] = -1
            if away2 < (edges[k, col.E_RADIUS] + reach) ** 2:
                rim_at[i, k] = _nearest_point(x, y, z, 0.0, 0.0, 0.0, edges[k], points, reach)
                rims[i] = max(rims[i], rim_at[i, k] + 1)
            if i == n - 1:
                continue
            ex = pos[i + 1, 0] - x
            ey = pos[i + 1, 1] - y
            ez = pos[i + 1, 2] - z
            dx += 0.5 * ex
            dy += 0.5 * ey
            dz += 0.5 * ez
            away2 = dx * dx + dy * dy + dz * dz
            if away2 < (edges[k, col.E_RADIUS] + 0.5 * body[i, col.LINK_LENGTH] + reach) ** 2:
                link_at[i, k] = _nearest_point(x, y, z, ex, ey, ez, edges[k], points, reach)
                rims[i] = max(rims[i], link_at[i, k] + 1)


@compiled
def faces_edge(
    x: float, y: float, z: float, solids: Floats, edge: Floats, reach: float, hit: Floats
) -> bool:
    """Return whether an edge is near a point, and none of the walls that meet there counts.

    `hit` has what `on_edge` wrote; it gets what `foot` writes.
    """
    if hit[3] >= reach * reach or hit[3] == 0.0:
        return False
    away = np.sqrt(hit[3])
    nx = (x - hit[0]) / away
    ny = (y - hit[1]) / away
    nz = (z - hit[2]) / away
    for m in range(3):
        solid = int(edge[col.E_ONE + m])
        if solid >= 0 and foot(x, y, z, solids, solid, hit):
            return False
    hit[0] = nx
    hit[1] = ny
    hit[2] = nz
    hit[3] = away
    return True
