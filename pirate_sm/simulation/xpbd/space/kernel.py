"""The compiled part of the kinematic simulator in space: a chain in round pipes.

All compiled code of this physics is in this one module, because numba's cache does not notice edits
in functions that are called from another file. `space_state.py`, `space_world.py` and `solids.py`
fill the arrays whose columns are named here.

The method is that of the planar kernel (`xpbd/kernel.py`). What space adds:

- A part of the robot, ahead of or behind the roll joint, lies in a plane of its own. Its unit
  normal `n` is perpendicular to the roll link's direction `e`, and rolls about it: `n` turns
  towards `b = n x e`.
- Links stay in the planes of their parts (coplanarity), and the two planes follow the motor of the
  roll joint (twist).
- Wheels are spheres. One drives along `t = n x N`, `N` the wall's normal, and slides along `s`,
  `n` in the wall. Friction bounds both by a circle, the motor the drive alone.
- The pipe is solids, whose walls count where the foot of the wheel's centre lies between two clip
  planes and outside a hole, and edges, which count where no adjacent wall does.
"""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.machine_code import compiled

# Columns of `body`, those of the planar kernel; `body_array` fills both.
MASS_INV, MU_STATIC, MU_KINETIC, WHEEL_RATE, WHEEL_STALL, WHEEL_HOLD, MOTOR_LINK = range(7)
JOINT_K, JOINT_RATE, JOINT_STALL, JOINT_FRICTION, JOINT_MIN, JOINT_MAX, JOINT_DAMPING = range(7, 14)
LINK_LENGTH = 14
BODY_COLUMNS = 15

# Columns of `solids`: kind, a point and a unit direction, two sizes; the planes between which the
# foot must lie, `first * x >= value` and `last * x <= value`; the hole that the foot must not lie
# in; a capsule around the solid; of a cone the cosine of its slope.
#   cylinder, cone: where the axis begins, the axis, the radius there, its growth along the axis
#   torus:          the centre of the ring, the ring's axis, radius of the tube, of the ring
#   disc:           its middle, the direction into the pipe, outer radius, inner radius
KIND, O_X, O_Y, O_Z, A_X, A_Y, A_Z, SIZE, SLOPE_OR_SIZE = range(9)
F_X, F_Y, F_Z, F_VALUE, L_X, L_Y, L_Z, L_VALUE = range(9, 17)
HOLE, H_X, H_Y, H_Z, H_DX, H_DY, H_DZ, H_RADIUS = range(17, 25)
B_X, B_Y, B_Z, B_DX, B_DY, B_DZ, B_RADIUS = range(25, 32)
COSINE = 32
SOLID_COLUMNS = 33
CONE, TORUS, DISC = 0.0, 1.0, 2.0
"""A cylinder is a cone of slope 0."""
NO_HOLE, HALF_HOLE, WHOLE_HOLE = 0.0, 1.0, 2.0
"""A half hole begins at its point: the branch of a tee. A whole one goes both ways: its main."""

# Columns of `edges`: first point, number of points, whether it is closed, up to three solids that
# meet there (-1: none), a sphere around it. Columns of `points`: the place, and the direction into
# the pipe.
E_FIRST, E_COUNT, E_CLOSED, E_ONE, E_X, E_Y, E_Z, E_RADIUS = 0, 1, 2, 3, 6, 7, 8, 9
EDGE_COLUMNS = 10
P_X, P_Y, P_Z, P_IX, P_IY, P_IZ = range(6)
POINT_COLUMNS = 6

# Columns of `legs`, the pieces of the centre line: start, unit tangent, length, arc length of the
# route at the start, direction to side A; for an arc its radius, and towards its centre.
C_X, C_Y, C_Z, C_TX, C_TY, C_TZ, C_LENGTH, C_ARC, C_SX, C_SY, C_SZ = range(11)
C_RADIUS, C_UX, C_UY, C_UZ = range(11, 15)
LEG_COLUMNS = 15

# Entries of `world`; the last two are for how many substeps directions and contacts are kept, and
# in which iteration joints are first pulled.
DT, ITERATIONS, RADIUS, HALF_THICKNESS, CONTACT_COMPLIANCE, ANCHOR_MAX = range(6)
G_X, G_Y, G_Z, MAG_X, MAG_Y, MAG_Z = range(6, 12)
BLOCK_NODE, BLOCK_X, BLOCK_Y, BLOCK_Z, BLOCK_NX, BLOCK_NY, BLOCK_NZ = range(12, 19)
ROLL_LINK, ROLL_TARGET, ROLL_RATE, ROLL_STALL, INERTIA_FRONT, INERTIA_REAR, IMU_LINK = range(19, 26)
LOOK, PULL = 26, 27
WORLD_ENTRIES = 28

# Blocks of `state`; the number times the count of wheels is where each begins. After the last one
# stand the normals of the front and the rear part, their roll rates, the angle of the roll joint,
# and that of its motor.
S_POSITION, S_VELOCITY, S_MOTOR, S_WHEEL, S_BEND, S_ANCHOR, S_TURNED, S_READ, S_ROLL = (
    0, 3, 6, 7, 8, 9, 18, 19, 20,
)  # fmt: skip
R_RATE, R_ANGLE, R_MOTOR = 6, 8, 9
ROLL_ENTRIES = 10

# `out` has a block for each of `physics.PER_WHEEL`, the entries `physics.SINGLE`, then the kernel's
# own: the angle of the roll joint, the rolls of the two parts, and how deep a wheel or link has
# been in a wall so far, m.
OUT_PER_WHEEL = 9
OUT_SINGLE = 8
OUT_ROLL, OUT_ROLL_FRONT, OUT_ROLL_REAR, OUT_DEEPEST = range(4)
OUT_OWN = 4

# Scratch columns per wheel: the link behind it, its levers in the planes of its two ends, gradients
# of its joint, and what is constant in a call.
D_X, D_Y, D_Z, LF_X, LF_Y, LF_Z, LR_X, LR_Y, LR_Z = range(9)
GA_X, GA_Y, GA_Z, GM_X, GM_Y, GM_Z, GB_X, GB_Y, GB_Z = range(9, 18)
J_C, J_D, J_W, J_INV, J_LAM, J_FRICTION, J_STOP, J_RESISTS = range(18, 26)
SPIN, FORCE, SLOPE, LINK_SCALE = range(26, 30)
# Coplanarity of the link behind the wheel: value, share of the roll link's tilt, of the roll,
# inverse mass, impulse.
P_C, P_TILT, P_ROLL, P_INV, P_LAM = range(30, 35)
_NODE_COLUMNS = 35
# Scratch of the two parts: normal, `n x e`, roll in this substep, inverse inertia, roll since the
# normals were found.
N_X, N_Y, N_Z, N_BX, N_BY, N_BZ, N_ROLL, N_INV_I, N_ROLLED = range(9)
_PART_COLUMNS = 9
T_PRESS, T_DRIVE, T_GRIP, T_TORQUE, T_CURRENT, _T_COLUMNS = range(6)
# Scratch columns per contact of a wheel.
NX, NY, NZ, GAP, PUSH, PUSH_INV = range(6)
GI_X, GI_Y, GI_Z, GO_X, GO_Y, GO_Z, DRIVE, DRIVE_INV, TARGET, K_SLOPE, K_FORCE = range(6, 17)
SX, SY, SZ, S_TURN, SIDE, SIDE_W, S_TARGET, K_MU, K_RADIUS, K_CREEP, DISTANCE = range(17, 28)
_CONTACT_COLUMNS = 28
NODE, OTHER, SURFACE, PART = range(4)
# Scratch columns per contact of a link.
K_NX, K_NY, K_NZ, K_SHARE, K_GAP, K_PUSH, K_INV, _K_COLUMNS = range(8)

_ANCHORS = 3
_CONTACTS_EACH = 4

# Blocks of `scratch`; the number times the count of wheels is where each begins. After the last one
# stand the two parts, a foot and a place of the centre line. A call begins with zeros in the first
# three and in the parts.
_AT_NODES = 0
_AT_MOVED = _AT_NODES + _NODE_COLUMNS
_AT_TALLY = _AT_MOVED + 3
_AT_OFF = _AT_TALLY + _T_COLUMNS
_AT_CONTACTS = _AT_OFF + 2
_AT_LEANING = _AT_CONTACTS + _CONTACTS_EACH * _CONTACT_COLUMNS
_AT_PARTS = _AT_LEANING + 2 * _K_COLUMNS
_FOOT, _SPOT = 7, 9
# Blocks of `marks`, likewise: who touches, which links lean, the strongest contact, how many solids
# are near, whether an edge is; then a row per wheel of solids, and two of edges.
_AT_WHO = 0
_AT_WHO_LEANS = _AT_WHO + 4 * _CONTACTS_EACH
_AT_TOUCH = _AT_WHO_LEANS + 2
_AT_NEARS = _AT_TOUCH + 1
_AT_RIMS = _AT_NEARS + 1
_AT_NEAR = _AT_RIMS + 1

_MARGIN_M = 0.002
# How much nearer than they were a wheel or link may come to a wall during a call, besides what its
# speed brings it.
_NEAR_M = 0.02
_WHEEL_FILTER = 0.5  # of x_velocity, a mean of angle differences (thesis B-11)
# The motor side of a spring may wind this far beyond the joint's own end stop.
_WINDING_RAD = 0.6
_REACHED = 0.9999
_SLIPPED, _STUCK = 0.999, 0.998
# A joint farther from its end stops than this cannot reach them in one substep.
_STOP_RAD = 0.1
# Stiff enough to hold a link in its plane, soft enough for few iterations [decided by trial].
_PLANE_COMPLIANCE_M_N = 1e-6
_TWIST_NM_RAD = 30.0
# Below this share of its radius a wheel that lies on its side does not roll.
_LEAST_ROLLING = 0.05
# Slip angle at which a rolling wheel slides sideways; below, it creeps in proportion to the force
# (brush model of a tyre: Pacejka, Tire and Vehicle Dynamics, chapter 3) [assumed].
_SLIDING_SLIP_RAD = 0.1
# Deeper than the first, as on the edge of a step, a tyre is so many times as stiff [assumed]. The
# last is pushed out in a substep at most, lest a wheel that comes over a rim is thrown [by trial].
_FLAT_TYRE_M, _FLAT_TYRE_STIFFER, _DEEPEST_M = 0.0018, 4.0, 0.006


def scratch_arrays(wheels: int, solids: int, edges: int) -> tuple[Floats, Ints]:
    """Return arrays for `scratch` and `marks` of :func:`advance`, which keeps nothing in them."""
    single = 2 * _PART_COLUMNS + _FOOT + _SPOT
    return (
        np.zeros(_AT_PARTS * wheels + single),
        np.zeros((_AT_NEAR + solids + 2 * edges) * wheels, dtype=np.int64),
    )


@compiled
def _in_bounds(x: float, y: float, z: float, solids: Floats, k: int, foot: Floats) -> bool:
    """Return whether a foot lies between a solid's planes and outside its hole."""
    fx, fy, fz = foot[0], foot[1], foot[2]
    first = solids[k, F_X] * fx + solids[k, F_Y] * fy + solids[k, F_Z] * fz
    if first < solids[k, F_VALUE]:
        return False
    last = solids[k, L_X] * fx + solids[k, L_Y] * fy + solids[k, L_Z] * fz
    if last > solids[k, L_VALUE]:
        return False
    if solids[k, HOLE] == NO_HOLE:
        return True
    dx = fx - solids[k, H_X]
    dy = fy - solids[k, H_Y]
    dz = fz - solids[k, H_Z]
    along = dx * solids[k, H_DX] + dy * solids[k, H_DY] + dz * solids[k, H_DZ]
    if solids[k, HOLE] == HALF_HOLE and along < 0.0:
        return True
    away2 = dx * dx + dy * dy + dz * dz - along * along
    return bool(away2 >= solids[k, H_RADIUS] ** 2)


@compiled
def _foot(x: float, y: float, z: float, solids: Floats, k: int, hit: Floats) -> bool:
    """Return whether a solid's wall counts for a point; write the wall there to `hit`.

    `hit` gets the unit normal into the pipe and the distance from the wall, negative behind it.
    """
    dx = x - solids[k, O_X]
    dy = y - solids[k, O_Y]
    dz = z - solids[k, O_Z]
    ax = solids[k, A_X]
    ay = solids[k, A_Y]
    az = solids[k, A_Z]
    along = dx * ax + dy * ay + dz * az
    rx = dx - along * ax
    ry = dy - along * ay
    rz = dz - along * az
    off = np.sqrt(rx * rx + ry * ry + rz * rz)
    kind = solids[k, KIND]
    if kind == DISC:
        hit[0] = ax
        hit[1] = ay
        hit[2] = az
        hit[3] = along
        if not solids[k, SLOPE_OR_SIZE] <= off <= solids[k, SIZE]:
            return False
    elif off < 1e-9:
        return False
    elif kind == TORUS:
        share = solids[k, SLOPE_OR_SIZE] / off
        rx = dx - share * rx
        ry = dy - share * ry
        rz = dz - share * rz
        away = np.sqrt(rx * rx + ry * ry + rz * rz)
        if away < 1e-9:
            return False
        hit[0] = -rx / away
        hit[1] = -ry / away
        hit[2] = -rz / away
        hit[3] = solids[k, SIZE] - away
    else:
        slope = solids[k, SLOPE_OR_SIZE]
        cos = solids[k, COSINE]
        sin = slope * cos
        share = cos / off
        hit[0] = sin * ax - share * rx
        hit[1] = sin * ay - share * ry
        hit[2] = sin * az - share * rz
        hit[3] = (solids[k, SIZE] + slope * along - off) * cos
    hit[4] = x - hit[3] * hit[0]
    hit[5] = y - hit[3] * hit[1]
    hit[6] = z - hit[3] * hit[2]
    return bool(_in_bounds(x, y, z, solids, k, hit[4:]))


@compiled
def _beside(edge: Floats, at: int, step: int) -> int:
    """Return the point of an edge that is `step` points on; -1 beyond its ends."""
    count = int(edge[E_COUNT])
    k = at - int(edge[E_FIRST]) + step
    if edge[E_CLOSED] != 0.0:
        k = (k + count) % count
    elif k < 0 or k >= count:
        return -1
    return k + int(edge[E_FIRST])


@compiled
def _walk(x: float, y: float, z: float, edge: Floats, points: Floats, at: int) -> int:
    """Return the point of an edge nearest to a place, walking from point `at`."""
    best = np.inf
    for _ in range(int(edge[E_COUNT])):
        here = at
        for step in (-1, 0, 1):
            k = _beside(edge, here, step)
            if k < 0:
                continue
            dx = x - points[k, P_X]
            dy = y - points[k, P_Y]
            dz = z - points[k, P_Z]
            away2 = dx * dx + dy * dy + dz * dz
            if away2 < best:
                best = away2
                at = k
        if at == here:
            break
    return at


@compiled
def _on_edge(
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
        ex = points[k, P_X] - points[at, P_X]
        ey = points[k, P_Y] - points[at, P_Y]
        ez = points[k, P_Z] - points[at, P_Z]
        dx = x - points[at, P_X]
        dy = y - points[at, P_Y]
        dz = z - points[at, P_Z]
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
    first = int(edge[E_FIRST])
    length2 = ex * ex + ey * ey + ez * ez
    found = -1
    best = reach * reach
    for k in range(first, first + int(edge[E_COUNT])):
        dx = points[k, P_X] - x
        dy = points[k, P_Y] - y
        dz = points[k, P_Z] - z
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
def _look_around(
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
        reach = world[RADIUS] + _NEAR_M + 2.0 * (speed + passed * 9.81) * passed
        nears[i] = 0
        for k in range(solids.shape[0]):
            dx = x - solids[k, B_X]
            dy = y - solids[k, B_Y]
            dz = z - solids[k, B_Z]
            length2 = solids[k, B_DX] ** 2 + solids[k, B_DY] ** 2 + solids[k, B_DZ] ** 2
            share = dx * solids[k, B_DX] + dy * solids[k, B_DY] + dz * solids[k, B_DZ]
            share = min(max(share / length2, 0.0), 1.0) if length2 > 0.0 else 0.0
            dx -= share * solids[k, B_DX]
            dy -= share * solids[k, B_DY]
            dz -= share * solids[k, B_DZ]
            if dx * dx + dy * dy + dz * dz < (solids[k, B_RADIUS] + reach) ** 2:
                near[i, nears[i]] = k
                nears[i] += 1
        rims[i] = 0
        for k in range(edges.shape[0]):
            dx = x - edges[k, E_X]
            dy = y - edges[k, E_Y]
            dz = z - edges[k, E_Z]
            away2 = dx * dx + dy * dy + dz * dz
            rim_at[i, k] = -1
            link_at[i, k] = -1
            if away2 < (edges[k, E_RADIUS] + reach) ** 2:
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
            if away2 < (edges[k, E_RADIUS] + 0.5 * body[i, LINK_LENGTH] + reach) ** 2:
                link_at[i, k] = _nearest_point(x, y, z, ex, ey, ez, edges[k], points, reach)
                rims[i] = max(rims[i], link_at[i, k] + 1)


@compiled
def _faces_edge(
    x: float, y: float, z: float, solids: Floats, edge: Floats, reach: float, hit: Floats
) -> bool:
    """Return whether an edge is near a point, and none of the walls that meet there counts.

    `hit` has what `_on_edge` wrote; it gets what `_foot` writes.
    """
    if hit[3] >= reach * reach or hit[3] == 0.0:
        return False
    away = np.sqrt(hit[3])
    nx = (x - hit[0]) / away
    ny = (y - hit[1]) / away
    nz = (z - hit[2]) / away
    for m in range(3):
        solid = int(edge[E_ONE + m])
        if solid >= 0 and _foot(x, y, z, solids, solid, hit):
            return False
    hit[0] = nx
    hit[1] = ny
    hit[2] = nz
    hit[3] = away
    return True


@compiled
def _touch(
    count: int, i: int, surface: int, hit: Floats, world: Floats, con: Floats, who: Ints
) -> int:
    """Note a contact of a wheel; return the count of contacts."""
    if count == con.shape[0]:
        return count
    con[count, NX] = hit[0]
    con[count, NY] = hit[1]
    con[count, NZ] = hit[2]
    con[count, DISTANCE] = hit[3] - world[RADIUS]
    who[count, NODE] = i
    who[count, SURFACE] = surface
    return count + 1


@compiled
def _find_contacts(
    n: int,
    pos: Floats,
    vel: Floats,
    solids: Floats,
    edges: Floats,
    points: Floats,
    world: Floats,
    near: Ints,
    nears: Ints,
    rims: Ints,
    rim_at: Ints,
    con: Floats,
    who: Ints,
    hit: Floats,
) -> int:
    """Write normals and gaps of wheels near a wall, an edge or an obstacle; return the count."""
    count = 0
    radius = world[RADIUS]
    kept = (world[LOOK] - 1.0) * world[DT]
    for i in range(n):
        x, y, z = pos[i, 0], pos[i, 1], pos[i, 2]
        speed = abs(vel[i, 0]) + abs(vel[i, 1]) + abs(vel[i, 2])
        reach = radius + _MARGIN_M + kept * speed
        for k in range(nears[i]):
            solid = near[i, k]
            if _foot(x, y, z, solids, solid, hit) and -radius < hit[3] < reach:
                count = _touch(count, i, solid, hit, world, con, who)
        if rims[i] != 0:
            for k in range(edges.shape[0]):
                if rim_at[i, k] < 0:
                    continue
                at = _on_edge(x, y, z, edges[k], points, rim_at[i, k], hit)
                rim_at[i, k] = at
                if _faces_edge(x, y, z, solids, edges[k], reach, hit):
                    count = _touch(count, i, solids.shape[0] + k, hit, world, con, who)
        if world[BLOCK_NODE] == i:
            hit[0] = world[BLOCK_NX]
            hit[1] = world[BLOCK_NY]
            hit[2] = world[BLOCK_NZ]
            hit[3] = (
                (x - world[BLOCK_X]) * hit[0]
                + (y - world[BLOCK_Y]) * hit[1]
                + (z - world[BLOCK_Z]) * hit[2]
            )
            if hit[3] < reach:
                count = _touch(count, i, -1, hit, world, con, who)
    return count


@compiled
def _face(c: int, p: int, radius: float, parts: Floats, con: Floats) -> float:
    """Write the directions of driving and sliding of a contact; return the sine axle to normal.

    Sliding = s dp + r s (e x N) d roll, with e = b x n. A wheel that lies on its side does not
    roll, and any direction in the wall will do: then the sine is 0.
    """
    nx = con[c, NX]
    ny = con[c, NY]
    nz = con[c, NZ]
    ax = parts[p, N_X]
    ay = parts[p, N_Y]
    az = parts[p, N_Z]
    bx = parts[p, N_BX]
    by = parts[p, N_BY]
    bz = parts[p, N_BZ]
    ex = by * az - bz * ay
    ey = bz * ax - bx * az
    ez = bx * ay - by * ax
    tx = ay * nz - az * ny
    ty = az * nx - ax * nz
    tz = ax * ny - ay * nx
    sine = np.sqrt(tx * tx + ty * ty + tz * tz)
    length = sine
    if sine < _LEAST_ROLLING:
        tx = by * nz - bz * ny
        ty = bz * nx - bx * nz
        tz = bx * ny - by * nx
        length = np.sqrt(tx * tx + ty * ty + tz * tz)
        sine = 0.0
    share = 1.0 / length
    tx *= share
    ty *= share
    tz *= share
    sx = ny * tz - nz * ty
    sy = nz * tx - nx * tz
    sz = nx * ty - ny * tx
    turn = sx * (ey * nz - ez * ny) + sy * (ez * nx - ex * nz) + sz * (ex * ny - ey * nx)
    con[c, GI_X] = tx
    con[c, GI_Y] = ty
    con[c, GI_Z] = tz
    con[c, SX] = sx
    con[c, SY] = sy
    con[c, SZ] = sz
    con[c, S_TURN] = turn * radius
    return float(sine)


@compiled
def _recall(
    c: int, i: int, body: Floats, world: Floats, anchor: Floats, con: Floats, who: Ints
) -> None:
    """Set the targets of a contact to what its wheel has kept there, and its friction."""
    drive = 0.0
    side = 0.0
    for k in range(0, 3 * _ANCHORS, 3):
        if anchor[i, k] == who[c, SURFACE] + 1.0:
            drive = anchor[i, k + 1]
            side = anchor[i, k + 2]
    slipped = _SLIPPED * world[ANCHOR_MAX]
    slipping = drive * drive + side * side >= slipped * slipped
    con[c, K_MU] = body[i, MU_KINETIC] if slipping else body[i, MU_STATIC]
    con[c, TARGET] = drive
    con[c, S_TARGET] = side


@compiled
def _gear(c: int, i: int, sine: float, body: Floats, world: Floats, w: Floats, con: Floats) -> int:
    """Let a contact drive: its lever, its motor's limits; return the other wheel of the lever.

    The motor reacts on its link: rolling = t dp - r sine (d link angle + d wheel angle).
    """
    radius = world[RADIUS] * sine
    link = int(body[i, MOTOR_LINK])
    other = link
    column = LR_X
    lever = -radius
    if link == i:
        other = link + 1
        column = LF_X
        lever = radius
    own = 0.0
    across = 0.0
    for k in range(3):
        reaction = lever * w[link, column + k]
        con[c, GI_X + k] -= reaction
        con[c, GO_X + k] = reaction
        own += con[c, GI_X + k] ** 2
        across += reaction * reaction
    con[c, K_RADIUS] = radius
    con[c, K_FORCE] = w[i, FORCE] / sine
    con[c, K_SLOPE] = w[i, SLOPE] * sine * sine
    con[c, TARGET] += w[i, SPIN] * radius
    mass_inv = body[i, MASS_INV] * own + body[other, MASS_INV] * across
    con[c, DRIVE_INV] = 1.0 / (mass_inv + con[c, K_SLOPE])
    return other


@compiled
def _press(c: int, con: Floats) -> None:
    """Set the gap of a contact by its distance, and zero its impulses."""
    con[c, PUSH] = 0.0
    con[c, DRIVE] = 0.0
    con[c, SIDE] = 0.0
    # The gap as one of constant stiffness would be with the same force.
    gap = con[c, DISTANCE]
    gap += (_FLAT_TYRE_STIFFER - 1.0) * min(0.0, gap + _FLAT_TYRE_M)
    con[c, GAP] = max(gap, -_DEEPEST_M)


@compiled
def _prepare_contacts(
    count: int,
    body: Floats,
    world: Floats,
    anchor: Floats,
    w: Floats,
    parts: Floats,
    con: Floats,
    who: Ints,
) -> None:
    """Set gradients, masses, limits and targets of the contacts, and zero their impulses."""
    compliance = world[CONTACT_COMPLIANCE] / (world[DT] * world[DT])
    for c in range(count):
        i = who[c, NODE]
        p = 0 if i <= world[ROLL_LINK] else 1
        who[c, PART] = p
        who[c, OTHER] = i
        _press(c, con)
        con[c, PUSH_INV] = 1.0 / (body[i, MASS_INV] + compliance)
        if who[c, SURFACE] < 0:
            con[c, K_MU] = 0.0
            continue
        sine = _face(c, p, world[RADIUS], parts, con)
        _recall(c, i, body, world, anchor, con, who)
        con[c, SIDE_W] = body[i, MASS_INV] + con[c, S_TURN] ** 2 * parts[p, N_INV_I]
        con[c, K_CREEP] = _SLIDING_SLIP_RAD
        if sine > 0.0:
            who[c, OTHER] = _gear(c, i, sine, body, world, w, con)
            continue
        con[c, K_CREEP] = 0.0
        con[c, K_RADIUS] = 0.0
        con[c, K_SLOPE] = 0.0
        con[c, K_FORCE] = np.inf
        con[c, DRIVE_INV] = 1.0 / body[i, MASS_INV]
        for k in range(3):
            con[c, GO_X + k] = 0.0


@compiled
def _rolled(c: int, i: int, o: int, mov: Floats, con: Floats) -> float:
    """Return how far a wheel without its motor would have rolled along the wall."""
    own = con[c, GI_X] * mov[i, 0]
    own += con[c, GI_Y] * mov[i, 1]
    own += con[c, GI_Z] * mov[i, 2]
    other = con[c, GO_X] * mov[o, 0]
    other += con[c, GO_Y] * mov[o, 1]
    other += con[c, GO_Z] * mov[o, 2]
    return float(own + other)


@compiled
def _slid(c: int, i: int, mov: Floats, parts: Floats, con: Floats, p: int) -> float:
    """Return how far a wheel has slid along its axle."""
    slid = con[c, SX] * mov[i, 0]
    slid += con[c, SY] * mov[i, 1]
    slid += con[c, SZ] * mov[i, 2]
    return float(slid + con[c, S_TURN] * parts[p, N_ROLL])


@compiled
def _crept(c: int, rolled: float, con: Floats) -> float:
    """Return how far a wheel has crept along its axle while it rolled."""
    friction = con[c, K_MU] * con[c, PUSH]
    return float(con[c, K_CREEP] * abs(rolled) * con[c, SIDE] / friction) if friction > 0.0 else 0.0


@compiled
def _solve_contacts(
    count: int, mov: Floats, body: Floats, compliance: float, parts: Floats, con: Floats, who: Ints
) -> None:
    """Push out, roll and hold each contact once, with friction within its cone."""
    for c in range(count):
        i = who[c, NODE]
        inv = body[i, MASS_INV]
        # What a wheel moves stays in registers until it is known.
        x, y, z = mov[i, 0], mov[i, 1], mov[i, 2]
        push = con[c, PUSH]
        gap = (con[c, GAP] + con[c, NX] * x) + (con[c, NY] * y + con[c, NZ] * z)
        new = max(0.0, push - (gap + compliance * push) * con[c, PUSH_INV])
        step = inv * (new - push)
        con[c, PUSH] = new
        x += step * con[c, NX]
        y += step * con[c, NY]
        z += step * con[c, NZ]
        limit = con[c, K_MU] * new
        drive = con[c, DRIVE]
        side = con[c, SIDE]
        if con[c, K_MU] == 0.0 or (limit == 0.0 and drive == 0.0 and side == 0.0):
            mov[i, 0] = x
            mov[i, 1] = y
            mov[i, 2] = z
            continue
        o = who[c, OTHER]
        p = who[c, PART]
        rolled = con[c, GI_X] * x + con[c, GI_Y] * y + con[c, GI_Z] * z
        rolled += con[c, GO_X] * mov[o, 0] + con[c, GO_Y] * mov[o, 1] + con[c, GO_Z] * mov[o, 2]
        slid = con[c, SX] * x + con[c, SY] * y + con[c, SZ] * z
        slid += con[c, S_TURN] * parts[p, N_ROLL]
        left = con[c, TARGET] - rolled - con[c, K_SLOPE] * drive
        to_drive = drive + left * con[c, DRIVE_INV]
        to_drive = min(max(to_drive, -con[c, K_FORCE]), con[c, K_FORCE])
        creep = con[c, K_CREEP] * abs(rolled)
        # At a limit of 0 the circle below leaves nothing.
        to_side = side
        if limit > 0.0:
            away = (con[c, S_TARGET] - slid) * limit - creep * side
            to_side += away / (con[c, SIDE_W] * limit + creep)
        both2 = to_drive * to_drive + to_side * to_side
        if both2 > limit * limit:
            share = limit / np.sqrt(both2)
            to_drive *= share
            to_side *= share
        con[c, DRIVE] = to_drive
        con[c, SIDE] = to_side
        drive = to_drive - drive
        side = to_side - side
        mov[i, 0] = x + inv * (drive * con[c, GI_X] + side * con[c, SX])
        mov[i, 1] = y + inv * (drive * con[c, GI_Y] + side * con[c, SY])
        mov[i, 2] = z + inv * (drive * con[c, GI_Z] + side * con[c, SZ])
        parts[p, N_ROLL] += parts[p, N_INV_I] * con[c, S_TURN] * side
        step = body[o, MASS_INV] * drive
        mov[o, 0] += step * con[c, GO_X]
        mov[o, 1] += step * con[c, GO_Y]
        mov[o, 2] += step * con[c, GO_Z]


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
    gap = hit[3] - world[HALF_THICKNESS]
    if gap > _MARGIN_M * world[LOOK] or gap < -2.0 * world[HALF_THICKNESS] or count == cor.shape[0]:
        return count
    compliance = world[CONTACT_COMPLIANCE] / (world[DT] * world[DT])
    who[count] = m
    cor[count, K_NX] = hit[0]
    cor[count, K_NY] = hit[1]
    cor[count, K_NZ] = hit[2]
    cor[count, K_SHARE] = share
    cor[count, K_GAP] = gap
    cor[count, K_PUSH] = 0.0
    mass_inv = body[m, MASS_INV] * (1.0 - share) ** 2 + body[m + 1, MASS_INV] * share**2
    cor[count, K_INV] = 1.0 / (mass_inv + compliance)
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
    share = _share(pos, m, points[at, P_X], points[at, P_Y], points[at, P_Z])
    for _ in range(2):
        share = min(max(share, 0.0), 1.0)
        x = pos[m, 0] + share * (pos[m + 1, 0] - pos[m, 0])
        y = pos[m, 1] + share * (pos[m + 1, 1] - pos[m, 1])
        z = pos[m, 2] + share * (pos[m + 1, 2] - pos[m, 2])
        at = _on_edge(x, y, z, edge, points, at, hit)
        share = _share(pos, m, hit[0], hit[1], hit[2])
    if share <= 0.0 or share >= 1.0:
        return count
    x = pos[m, 0] + share * (pos[m + 1, 0] - pos[m, 0]) - hit[0]
    y = pos[m, 1] + share * (pos[m + 1, 1] - pos[m, 1]) - hit[1]
    z = pos[m, 2] + share * (pos[m + 1, 2] - pos[m, 2]) - hit[2]
    away = np.sqrt(x * x + y * y + z * z)
    if away > world[HALF_THICKNESS] + _MARGIN_M * world[LOOK] or away < 1e-9:
        return count
    # The link may have got over the edge with its middle; the pipe's inside says which way is out.
    if x * points[at, P_IX] + y * points[at, P_IY] + z * points[at, P_IZ] < 0.0:
        away = -away
    hit[0] = x / away
    hit[1] = y / away
    hit[2] = z / away
    hit[3] = away
    return int(_lean(count, m, share, hit, body, world, cor, who))


@compiled
def _find_leaning(
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
            if solids[solid, KIND] != TORUS:
                continue
            # The place of the link that is nearest to the axis of the ring.
            ax = solids[solid, A_X]
            ay = solids[solid, A_Y]
            az = solids[solid, A_Z]
            dx = pos[m, 0] - solids[solid, O_X]
            dy = pos[m, 1] - solids[solid, O_Y]
            dz = pos[m, 2] - solids[solid, O_Z]
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
            if _foot(x, y, z, solids, solid, hit):
                count = _lean(count, m, share, hit, body, world, cor, who)
    return count


@compiled
def _clear(c: int, m: int, mov: Floats, cor: Floats) -> float:
    """Return the gap between a link and what it leans on after what it has moved."""
    behind = cor[c, K_SHARE]
    ahead = 1.0 - behind
    gap = cor[c, K_GAP]
    gap += cor[c, K_NX] * ahead * mov[m, 0]
    gap += cor[c, K_NY] * ahead * mov[m, 1]
    gap += cor[c, K_NZ] * ahead * mov[m, 2]
    gap += cor[c, K_NX] * behind * mov[m + 1, 0]
    gap += cor[c, K_NY] * behind * mov[m + 1, 1]
    gap += cor[c, K_NZ] * behind * mov[m + 1, 2]
    return float(gap)


@compiled
def _solve_leaning(
    count: int, mov: Floats, body: Floats, compliance: float, w: Floats, cor: Floats, who: Ints
) -> None:
    """Push each link that leans on something clear of it once."""
    for c in range(count):
        m = who[c]
        behind = cor[c, K_SHARE]
        ahead = 1.0 - behind
        gap = _clear(c, m, mov, cor)
        new = max(0.0, cor[c, K_PUSH] - (gap + compliance * cor[c, K_PUSH]) * cor[c, K_INV])
        delta = new - cor[c, K_PUSH]
        cor[c, K_PUSH] = new
        step = body[m, MASS_INV] * ahead * delta
        mov[m, 0] += step * cor[c, K_NX]
        mov[m, 1] += step * cor[c, K_NY]
        mov[m, 2] += step * cor[c, K_NZ]
        step = body[m + 1, MASS_INV] * behind * delta
        mov[m + 1, 0] += step * cor[c, K_NX]
        mov[m + 1, 1] += step * cor[c, K_NY]
        mov[m + 1, 2] += step * cor[c, K_NZ]


@compiled
def _stand(pos: Floats, roll: Floats, world: Floats, parts: Floats) -> None:
    """Bring the parts' normals square to the roll link, and measure the roll joint."""
    r = int(world[ROLL_LINK])
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
        parts[p, N_ROLLED] = 0.0
        parts[p, N_X] = nx
        parts[p, N_Y] = ny
        parts[p, N_Z] = nz
        parts[p, N_BX] = ny * ez - nz * ey
        parts[p, N_BY] = nz * ex - nx * ez
        parts[p, N_BZ] = nx * ey - ny * ex
    sin = 0.0
    cos = 0.0
    for k in range(3):
        sin += parts[0, N_X + k] * parts[1, N_BX + k]
        cos += parts[0, N_X + k] * parts[1, N_X + k]
    change = np.arctan2(sin, cos) - roll[R_ANGLE]
    roll[R_ANGLE] += change - 2.0 * np.pi * np.rint(change / (2.0 * np.pi))


@compiled
def _keep(roll: Floats, parts: Floats, dt: float) -> None:
    """Turn the parts' normals by what they have rolled in a substep."""
    for p in range(2):
        parts[p, N_ROLLED] += parts[p, N_ROLL]
        # Cosine and sine of an angle whose half has this tangent; it rolls by mrad.
        half = 0.5 * parts[p, N_ROLLED]
        share = 1.0 / (1.0 + half * half)
        cos = (1.0 - half * half) * share
        sin = 2.0 * half * share
        for k in range(3):
            roll[3 * p + k] = cos * parts[p, N_X + k] + sin * parts[p, N_BX + k]
        roll[R_RATE + p] = parts[p, N_ROLL] / dt


@compiled
def _turn_roll_motor(roll: Floats, world: Floats) -> float:
    """Turn the motor side of the roll joint by one substep; return the current's share.

    It turns at rate * (1 - torque / stall torque) and is never driven back.
    """
    wanted = world[ROLL_TARGET] - roll[R_MOTOR]
    if wanted == 0.0:
        return 0.0
    against = _TWIST_NM_RAD * (roll[R_MOTOR] - roll[R_ANGLE]) / world[ROLL_STALL]
    if wanted < 0.0:
        against = -against
    load = min(max(against, 0.0), 1.0)
    reach = world[ROLL_RATE] * (1.0 - load) * world[DT]
    roll[R_MOTOR] += min(max(wanted, -reach), reach)
    return float(load)


@compiled
def _lie_in_planes(n: int, body: Floats, world: Floats, w: Floats, parts: Floats) -> None:
    """Set values and gradients of the links' coplanarity with the normals of their parts."""
    r = int(world[ROLL_LINK])
    compliance = _PLANE_COMPLIANCE_M_N / (world[DT] * world[DT])
    inv_r = body[r, MASS_INV]
    inv_s = body[r + 1, MASS_INV]
    length = np.sqrt(w[r, D_X] ** 2 + w[r, D_Y] ** 2 + w[r, D_Z] ** 2)
    for m in range(n - 1):
        if m == r:
            continue
        p = 0 if m < r else 1
        value = 0.0
        turn = 0.0
        tilt = 0.0
        for k in range(3):
            value += w[m, D_X + k] * parts[p, N_X + k]
            turn += w[m, D_X + k] * parts[p, N_BX + k]
            tilt += w[m, D_X + k] * w[r, D_X + k]
        tilt /= length * length
        w[m, P_C] = value
        w[m, P_ROLL] = turn
        w[m, P_TILT] = tilt
        w[m, P_LAM] = 0.0
        # The link shares a node with the roll link where it is next to it.
        at_r = -tilt - 1.0 if m == r - 1 else -tilt
        at_s = tilt + 1.0 if m == r + 1 else tilt
        mass_inv = inv_r * at_r * at_r + inv_s * at_s * at_s + turn * turn * parts[p, N_INV_I]
        if m != r + 1:
            mass_inv += body[m, MASS_INV]
        if m != r - 1:
            mass_inv += body[m + 1, MASS_INV]
        w[m, P_INV] = 1.0 / (mass_inv + compliance)


@compiled
def _solve_planes(
    n: int, mov: Floats, body: Floats, world: Floats, w: Floats, parts: Floats, off: Floats
) -> None:
    """Bring each link into the plane of its part once.

    `off` has two rows: how far each wheel has moved out of the plane, and before this.
    """
    r = int(world[ROLL_LINK])
    compliance = _PLANE_COMPLIANCE_M_N / (world[DT] * world[DT])
    for p in range(2):
        first = 0 if p == 0 else r
        last = r + 1 if p == 0 else n - 1
        nx = parts[p, N_X]
        ny = parts[p, N_Y]
        nz = parts[p, N_Z]
        for i in range(first, last + 1):
            off[0, i] = nx * mov[i, 0] + ny * mov[i, 1] + nz * mov[i, 2]
            off[1, i] = off[0, i]
        for m in range(first, last):
            if m == r:
                continue
            tilt = w[m, P_TILT]
            value = w[m, P_C] + off[0, m] - off[0, m + 1]
            value += w[m, P_ROLL] * parts[p, N_ROLL] - tilt * (off[0, r] - off[0, r + 1])
            delta = -(value + compliance * w[m, P_LAM]) * w[m, P_INV]
            w[m, P_LAM] += delta
            off[0, m] += body[m, MASS_INV] * delta
            off[0, m + 1] -= body[m + 1, MASS_INV] * delta
            off[0, r] -= body[r, MASS_INV] * delta * tilt
            off[0, r + 1] += body[r + 1, MASS_INV] * delta * tilt
            parts[p, N_ROLL] += parts[p, N_INV_I] * w[m, P_ROLL] * delta
        for i in range(first, last + 1):
            step = off[0, i] - off[1, i]
            mov[i, 0] += step * nx
            mov[i, 1] += step * ny
            mov[i, 2] += step * nz


@compiled
def _solve_twist(roll: Floats, parts: Floats, dt: float, impulse: float) -> float:
    """Pull the two parts once towards the motor of the roll joint; return the impulse so far."""
    compliance = 1.0 / (_TWIST_NM_RAD * dt * dt)
    left = roll[R_MOTOR] - roll[R_ANGLE] - parts[0, N_ROLL] + parts[1, N_ROLL]
    both = parts[0, N_INV_I] + parts[1, N_INV_I]
    delta = (left - compliance * impulse) / (both + compliance)
    parts[0, N_ROLL] += parts[0, N_INV_I] * delta
    parts[1, N_ROLL] -= parts[1, N_INV_I] * delta
    return float(impulse + delta)


@compiled
def _turned(i: int, mov: Floats, w: Floats) -> float:
    """Return by how much a joint has turned in this substep."""
    # Three short sums, because one long sum would wait for each of its terms in turn.
    ahead = w[i, GA_X] * mov[i - 1, 0]
    ahead += w[i, GA_Y] * mov[i - 1, 1]
    ahead += w[i, GA_Z] * mov[i - 1, 2]
    middle = w[i, GM_X] * mov[i, 0]
    middle += w[i, GM_Y] * mov[i, 1]
    middle += w[i, GM_Z] * mov[i, 2]
    behind = w[i, GB_X] * mov[i + 1, 0]
    behind += w[i, GB_Y] * mov[i + 1, 1]
    behind += w[i, GB_Z] * mov[i + 1, 2]
    return float(behind + middle + ahead)


@compiled
def _turn_motor(
    i: int,
    duty: float,
    bend: Floats,
    motor: Floats,
    body: Floats,
    dt: float,
    w: Floats,
    tally: Floats,
) -> None:
    """Turn the motor of a joint by one substep, and zero the joint's impulses.

    It turns at rate * (duty - torque / stall torque) and is never driven back.
    """
    rate = duty - body[i, JOINT_K] * (motor[i] - bend[i]) / body[i, JOINT_STALL]
    rate = min(max(rate, min(duty, 0.0)), max(duty, 0.0))
    turned = motor[i] + body[i, JOINT_RATE] * rate * dt
    motor[i] = min(
        max(turned, body[i, JOINT_MIN] - _WINDING_RAD), body[i, JOINT_MAX] + _WINDING_RAD
    )
    tally[i, T_CURRENT] += abs(duty - rate)
    w[i, J_LAM] = 0.0
    w[i, J_FRICTION] = 0.0
    w[i, J_STOP] = 0.0


@compiled
def _go_on(
    n: int,
    count: int,
    leans: int,
    mov: Floats,
    roll: Floats,
    bend: Floats,
    motor: Floats,
    anchor: Floats,
    command: Floats,
    body: Floats,
    world: Floats,
    w: Floats,
    parts: Floats,
    con: Floats,
    who: Ints,
    cor: Floats,
    leaning: Ints,
    tally: Floats,
) -> None:
    """Begin a substep with the directions and contacts of the one before.

    Angles, distances and links change by what the wheels have moved.
    """
    r = int(world[ROLL_LINK])
    roll[R_ANGLE] += parts[0, N_ROLL] - parts[1, N_ROLL]
    for p in range(2):
        nx = parts[p, N_X]
        ny = parts[p, N_Y]
        nz = parts[p, N_Z]
        tilted = nx * (mov[r, 0] - mov[r + 1, 0])
        tilted += ny * (mov[r, 1] - mov[r + 1, 1])
        tilted += nz * (mov[r, 2] - mov[r + 1, 2])
        for m in range(0 if p == 0 else r + 1, r if p == 0 else n - 1):
            off = nx * (mov[m, 0] - mov[m + 1, 0])
            off += ny * (mov[m, 1] - mov[m + 1, 1])
            off += nz * (mov[m, 2] - mov[m + 1, 2])
            w[m, P_C] += off + w[m, P_ROLL] * parts[p, N_ROLL] - w[m, P_TILT] * tilted
            w[m, P_LAM] = 0.0
    for m in range(n - 1):
        for k in range(3):
            w[m, D_X + k] += mov[m, k] - mov[m + 1, k]
    for i in range(1, n - 1):
        bend[i] += _turned(i, mov, w)
        _turn_motor(i, command[i], bend, motor, body, world[DT], w, tally)
    for c in range(count):
        i = who[c, NODE]
        con[c, DISTANCE] += con[c, NX] * mov[i, 0] + con[c, NY] * mov[i, 1] + con[c, NZ] * mov[i, 2]
        _press(c, con)
        if who[c, SURFACE] >= 0:
            _recall(c, i, body, world, anchor, con, who)
            con[c, TARGET] += w[i, SPIN] * con[c, K_RADIUS]
    for c in range(leans):
        cor[c, K_GAP] = _clear(c, leaning[c], mov, cor)
        cor[c, K_PUSH] = 0.0


@compiled
def _begin(
    n: int,
    pos: Floats,
    bend: Floats,
    motor: Floats,
    command: Floats,
    body: Floats,
    world: Floats,
    w: Floats,
    parts: Floats,
    tally: Floats,
) -> None:
    """Compute angles and gradients from the positions, and turn the motors by one substep."""
    dt = world[DT]
    r = int(world[ROLL_LINK])
    for i in range(n - 1):
        dx = pos[i, 0] - pos[i + 1, 0]
        dy = pos[i, 1] - pos[i + 1, 1]
        dz = pos[i, 2] - pos[i + 1, 2]
        w[i, D_X] = dx
        w[i, D_Y] = dy
        w[i, D_Z] = dz
        share = 1.0 / (dx * dx + dy * dy + dz * dz)
        p = 0 if i <= r else 1
        nx = parts[p, N_X]
        ny = parts[p, N_Y]
        nz = parts[p, N_Z]
        w[i, LF_X] = (ny * dz - nz * dy) * share
        w[i, LF_Y] = (nz * dx - nx * dz) * share
        w[i, LF_Z] = (nx * dy - ny * dx) * share
        if i == r:
            w[i, LR_X] = (parts[1, N_Y] * dz - parts[1, N_Z] * dy) * share
            w[i, LR_Y] = (parts[1, N_Z] * dx - parts[1, N_X] * dz) * share
            w[i, LR_Z] = (parts[1, N_X] * dy - parts[1, N_Y] * dx) * share
        else:
            for k in range(3):
                w[i, LR_X + k] = w[i, LF_X + k]
        if i == 0:
            continue
        ax = w[i - 1, D_X]
        ay = w[i - 1, D_Y]
        az = w[i - 1, D_Z]
        sin = nx * (ay * dz - az * dy) + ny * (az * dx - ax * dz) + nz * (ax * dy - ay * dx)
        cos = ax * dx + ay * dy + az * dz
        cos -= (nx * ax + ny * ay + nz * az) * (nx * dx + ny * dy + nz * dz)
        change = np.arctan2(sin, cos) - bend[i]
        if abs(change) > np.pi:
            change -= 2.0 * np.pi * np.rint(change / (2.0 * np.pi))
        bend[i] += change
        _turn_motor(i, command[i], bend, motor, body, dt, w, tally)
        inv = 0.0
        for k in range(3):
            w[i, GA_X + k] = -w[i - 1, LR_X + k]
            w[i, GB_X + k] = -w[i, LF_X + k]
            w[i, GM_X + k] = w[i, LF_X + k] + w[i - 1, LR_X + k]
            inv += body[i - 1, MASS_INV] * w[i, GA_X + k] ** 2
            inv += body[i, MASS_INV] * w[i, GM_X + k] ** 2
            inv += body[i + 1, MASS_INV] * w[i, GB_X + k] ** 2
        w[i, J_W] = inv
        w[i, J_INV] = 1.0 / ((1.0 + w[i, J_D]) * inv + w[i, J_C])
        free = body[i, JOINT_MIN] + _STOP_RAD < bend[i] < body[i, JOINT_MAX] - _STOP_RAD
        w[i, J_RESISTS] = 0.0 if free and body[i, JOINT_FRICTION] == 0.0 else 1.0


@compiled
def _predict(n: int, mov: Floats, vel: Floats, roll: Floats, world: Floats, parts: Floats) -> None:
    """Move the wheels as gravity alone would, and roll the parts on."""
    dt = world[DT]
    for i in range(n):
        for k in range(3):
            mov[i, k] = dt * (vel[i, k] + dt * world[G_X + k])
    for p in range(2):
        parts[p, N_ROLL] = dt * roll[R_RATE + p]


@compiled
def _resist(i: int, turned: float, bend: float, body: Floats, dt2: float, w: Floats) -> float:
    """Return the impulse that a joint's dry friction and end stops add after it has turned."""
    added = 0.0
    if body[i, JOINT_FRICTION] > 0.0:
        limit = body[i, JOINT_FRICTION] * dt2
        new = min(max(w[i, J_FRICTION] - turned / w[i, J_W], -limit), limit)
        added = new - w[i, J_FRICTION]
        w[i, J_FRICTION] = new
    angle = bend + turned + added * w[i, J_W]
    old = w[i, J_STOP]
    if angle > body[i, JOINT_MAX] or old < 0.0:
        w[i, J_STOP] = min(0.0, old - (angle - body[i, JOINT_MAX]) / w[i, J_W])
    elif angle < body[i, JOINT_MIN] or old > 0.0:
        w[i, J_STOP] = max(0.0, old - (angle - body[i, JOINT_MIN]) / w[i, J_W])
    return float(added + w[i, J_STOP] - old)


@compiled
def _solve_joints(
    n: int, mov: Floats, bend: Floats, motor: Floats, body: Floats, dt2: float, w: Floats
) -> None:
    """Pull each joint once towards its motor-side angle through its spring."""
    for i in range(1, n - 1):
        turned = _turned(i, mov, w)
        left = motor[i] - bend[i] - turned * (1.0 + w[i, J_D]) - w[i, J_C] * w[i, J_LAM]
        delta = left * w[i, J_INV]
        w[i, J_LAM] += delta
        turned += w[i, J_W] * delta
        if w[i, J_RESISTS] != 0.0:
            delta += _resist(i, turned, bend[i], body, dt2, w)
        step = body[i - 1, MASS_INV] * delta
        mov[i - 1, 0] += step * w[i, GA_X]
        mov[i - 1, 1] += step * w[i, GA_Y]
        mov[i - 1, 2] += step * w[i, GA_Z]
        step = body[i, MASS_INV] * delta
        mov[i, 0] += step * w[i, GM_X]
        mov[i, 1] += step * w[i, GM_Y]
        mov[i, 2] += step * w[i, GM_Z]
        step = body[i + 1, MASS_INV] * delta
        mov[i + 1, 0] += step * w[i, GB_X]
        mov[i + 1, 1] += step * w[i, GB_Y]
        mov[i + 1, 2] += step * w[i, GB_Z]


@compiled
def _solve_links(n: int, mov: Floats, body: Floats, w: Floats) -> None:
    """Bring each link back to its length once."""
    for m in range(n - 1):
        dx = w[m, D_X] + mov[m, 0] - mov[m + 1, 0]
        dy = w[m, D_Y] + mov[m, 1] - mov[m + 1, 1]
        dz = w[m, D_Z] + mov[m, 2] - mov[m + 1, 2]
        # (d^2 - l^2) / 2l has the same root as d - l and needs no square root.
        scale = body[m, LINK_LENGTH] ** 2 - dx * dx - dy * dy - dz * dz
        scale *= w[m, LINK_SCALE]
        ahead = scale * body[m, MASS_INV]
        behind = scale * body[m + 1, MASS_INV]
        mov[m, 0] += ahead * dx
        mov[m, 1] += ahead * dy
        mov[m, 2] += ahead * dz
        mov[m + 1, 0] -= behind * dx
        mov[m + 1, 1] -= behind * dy
        mov[m + 1, 2] -= behind * dz


@compiled
def _strongest(n: int, count: int, con: Floats, who: Ints, touch: Ints, tally: Floats) -> None:
    """Write the strongest wall contact of each wheel to `touch`, -1 without any."""
    for i in range(n):
        touch[i] = -1
    for c in range(count):
        i = who[c, NODE]
        if con[c, PUSH] > 0.0 and who[c, SURFACE] >= 0:
            tally[i, T_PRESS] += con[c, PUSH]
            if touch[i] < 0 or con[c, PUSH] > con[touch[i], PUSH]:
                touch[i] = c


@compiled
def _remember(anchor: Floats, surface: float, drive: float, side: float) -> None:
    """Keep what a wheel has left unsolved at a surface, where there is room."""
    for k in range(0, 3 * _ANCHORS, 3):
        if anchor[k] == 0.0:
            anchor[k] = surface
            anchor[k + 1] = drive
            anchor[k + 2] = side
            return


@compiled
def _turn_wheels(
    n: int,
    count: int,
    mov: Floats,
    wheel: Floats,
    anchor: Floats,
    world: Floats,
    w: Floats,
    parts: Floats,
    con: Floats,
    who: Ints,
    touch: Ints,
    tally: Floats,
) -> None:
    """Turn the wheels, and carry unsolved rolling and sliding over as the anchor.

    As in the plane: a wheel slips only if the force along the wall has reached its friction, and a
    stalled wheel keeps no anchor along its drive.
    """
    bound = world[ANCHOR_MAX]
    _strongest(n, count, con, who, touch, tally)
    anchor[:] = 0.0
    for c in range(count):
        if con[c, PUSH] <= 0.0 or who[c, SURFACE] < 0:
            continue
        i = who[c, NODE]
        drive = con[c, DRIVE]
        side = con[c, SIDE]
        rolled = _rolled(c, i, who[c, OTHER], mov, con)
        left = con[c, TARGET] - rolled - con[c, K_SLOPE] * drive
        aside = (
            con[c, S_TARGET] - _slid(c, i, mov, parts, con, who[c, PART]) - _crept(c, rolled, con)
        )
        tally[i, T_DRIVE] += abs(drive) * con[c, K_RADIUS]
        tally[i, T_GRIP] += drive
        friction = con[c, K_MU] * con[c, PUSH]
        stalled = con[c, K_FORCE] < friction and abs(drive) >= _REACHED * con[c, K_FORCE]
        if stalled:
            left = 0.0
        away = np.sqrt(left * left + aside * aside)
        force = np.sqrt(drive * drive + side * side)
        slips = away >= bound and force >= _REACHED * friction
        most = bound if slips else _STUCK * bound
        if away > most:
            left *= most / away
            aside *= most / away
        _remember(anchor[i], who[c, SURFACE] + 1.0, left, aside)
        if touch[i] == c:
            if con[c, K_RADIUS] == 0.0 or (slips and not stalled):
                wheel[i] += w[i, SPIN]
                if con[c, K_RADIUS] != 0.0:
                    wheel[i] -= con[c, K_SLOPE] * drive / con[c, K_RADIUS]
            else:
                wheel[i] += rolled / con[c, K_RADIUS]
    for i in range(n):
        if touch[i] < 0:
            wheel[i] += w[i, SPIN]


@compiled
def _on_leg(x: float, y: float, z: float, leg: Floats, first: bool, last: bool) -> float:
    """Return the place of a piece of the centre line that is nearest to a point, m along it.

    The first and the last piece continue beyond the pipe's ends.
    """
    dx = x - leg[C_X]
    dy = y - leg[C_Y]
    dz = z - leg[C_Z]
    along = dx * leg[C_TX] + dy * leg[C_TY] + dz * leg[C_TZ]
    if leg[C_RADIUS] > 0.0:
        inward = dx * leg[C_UX] + dy * leg[C_UY] + dz * leg[C_UZ]
        angle = np.arctan2(along, leg[C_RADIUS] - inward)
        # Beyond its ends the nearer one counts.
        opposite = 0.5 * leg[C_LENGTH] / leg[C_RADIUS] - np.pi
        if angle < opposite:
            angle += 2.0 * np.pi
        along = angle * leg[C_RADIUS]
    if not first:
        along = max(along, 0.0)
    if not last:
        along = min(along, leg[C_LENGTH])
    return float(along)


@compiled
def _at_leg(along: float, leg: Floats, spot: Floats) -> None:
    """Write a place of a piece of the centre line, and its tangent and side, to `spot`."""
    if leg[C_RADIUS] == 0.0:
        for k in range(3):
            spot[k] = leg[C_X + k] + along * leg[C_TX + k]
            spot[3 + k] = leg[C_TX + k]
            spot[6 + k] = leg[C_SX + k]
        return
    angle = along / leg[C_RADIUS]
    sin = np.sin(angle)
    cos = np.cos(angle)
    inward = leg[C_SX] * leg[C_UX] + leg[C_SY] * leg[C_UY] + leg[C_SZ] * leg[C_UZ]
    for k in range(3):
        t = leg[C_TX + k]
        u = leg[C_UX + k]
        spot[k] = leg[C_X + k] + leg[C_RADIUS] * (sin * t + (1.0 - cos) * u)
        spot[3 + k] = cos * t + sin * u
        spot[6 + k] = leg[C_SX + k] + inward * ((cos - 1.0) * u - sin * t)


@compiled
def _roll_of(p: int, parts: Floats, spot: Floats) -> float:
    """Return the roll of a part against the pipe where it is."""
    aside = 0.0
    for k in range(3):
        aside += parts[p, N_X + k] * spot[6 + k]
    up = parts[p, N_X] * (spot[4] * spot[8] - spot[5] * spot[7])
    up += parts[p, N_Y] * (spot[5] * spot[6] - spot[3] * spot[8])
    up += parts[p, N_Z] * (spot[3] * spot[7] - spot[4] * spot[6])
    return float(np.arctan2(aside, up))


@compiled
def _project(
    n: int, pos: Floats, legs: Floats, world: Floats, parts: Floats, spot: Floats, out: Floats
) -> None:
    """Write the arc length of each wheel and the rolls of the parts to `out`."""
    r = int(world[ROLL_LINK])
    own = OUT_PER_WHEEL * n + OUT_SINGLE
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
        out[7 * n + i] = legs[at, C_ARC] + there
        if i == r or i == r + 1:
            _at_leg(there, legs[at], spot)
            out[own + OUT_ROLL_FRONT + i - r] = _roll_of(i - r, parts, spot)


@compiled
def _prepare(n: int, command: Floats, body: Floats, world: Floats, w: Floats) -> None:
    """Set what is constant during a call: motor limits, compliances."""
    dt = world[DT]
    radius = world[RADIUS]
    for i in range(n):
        duty = command[n + i]
        w[i, SPIN] = duty * body[i, WHEEL_RATE] * dt
        w[i, SLOPE] = 0.0
        w[i, FORCE] = body[i, WHEEL_HOLD] / radius * dt * dt
        if duty != 0.0:
            w[i, FORCE] = body[i, WHEEL_STALL] / radius * dt * dt
            w[i, SLOPE] = body[i, WHEEL_RATE] * radius**2 / (body[i, WHEEL_STALL] * dt)
        w[i, J_C] = 1.0 / (body[i, JOINT_K] * dt * dt)
        w[i, J_D] = body[i, JOINT_DAMPING] / (body[i, JOINT_K] * dt)
        if i < n - 1:
            both = body[i, MASS_INV] + body[i + 1, MASS_INV]
            w[i, LINK_SCALE] = 0.5 / (body[i, LINK_LENGTH] ** 2 * both)


@compiled
def _feel(
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
    is zero.
    """
    k = OUT_PER_WHEEL * n + 2
    m = int(world[IMU_LINK])
    ex = pos[m, 0] - pos[m + 1, 0]
    ey = pos[m, 1] - pos[m + 1, 1]
    ez = pos[m, 2] - pos[m + 1, 2]
    length = np.sqrt(ex * ex + ey * ey + ez * ez)
    ex /= length
    ey /= length
    ez /= length
    nx = parts[0, N_X]
    ny = parts[0, N_Y]
    nz = parts[0, N_Z]
    bx = ny * ez - nz * ey
    by = nz * ex - nx * ez
    bz = nx * ey - ny * ex
    fx = accel_x - world[G_X]
    fy = accel_y - world[G_Y]
    fz = accel_z - world[G_Z]
    out[k] = fx * ex + fy * ey + fz * ez
    out[k + 1] = -(fx * bx + fy * by + fz * bz)
    out[k + 2] = -(fx * nx + fy * ny + fz * nz)
    out[k + 3] = world[MAG_X] * ex + world[MAG_Y] * ey + world[MAG_Z] * ez
    out[k + 4] = -(world[MAG_X] * bx + world[MAG_Y] * by + world[MAG_Z] * bz)
    out[k + 5] = -(world[MAG_X] * nx + world[MAG_Y] * ny + world[MAG_Z] * nz)


@compiled
def advance(
    state: Floats,
    command: Floats,
    body: Floats,
    solids: Floats,
    edges: Floats,
    points: Floats,
    legs: Floats,
    world: Floats,
    out: Floats,
    scratch: Floats,
    marks: Ints,
    steps: int,
) -> None:
    """Simulate `steps` substeps and write the quantities to `out`.

    Equal inputs give equal results to the bit. SI units.

    Args:
        state: See `space_state.SpaceState`; changed.
        command: Duty of the joint at each wheel, then of each wheel.
        body: `(wheels, BODY_COLUMNS)`.
        solids: `(solids, SOLID_COLUMNS)`.
        edges: `(edges, EDGE_COLUMNS)`.
        points: `(points, POINT_COLUMNS)`, of all edges in turn.
        legs: `(legs, LEG_COLUMNS)`.
        world: `(WORLD_ENTRIES,)`.
        out: `(OUT_PER_WHEEL * wheels + OUT_SINGLE + OUT_OWN,)`.
        scratch: Memory, of :func:`scratch_arrays`, which keeps nothing. Code that gets memory of
            its own counts who uses each array, which took a tenth of the time.
        marks: Memory too.
        steps: Number of substeps; at least 1.
    """
    n = body.shape[0]
    pos = state[: 3 * n].reshape(n, 3)
    vel = state[3 * n : 6 * n].reshape(n, 3)
    motor = state[S_MOTOR * n : S_WHEEL * n]
    wheel = state[S_WHEEL * n : S_BEND * n]
    bend = state[S_BEND * n : S_ANCHOR * n]
    anchor = state[S_ANCHOR * n : S_TURNED * n].reshape(n, 3 * _ANCHORS)
    turned = state[S_TURNED * n : S_READ * n]
    read = state[S_READ * n : S_ROLL * n]
    roll = state[S_ROLL * n : S_ROLL * n + ROLL_ENTRIES]
    w = scratch[: _AT_MOVED * n].reshape(n, _NODE_COLUMNS)
    mov = scratch[_AT_MOVED * n : _AT_TALLY * n].reshape(n, 3)
    tally = scratch[_AT_TALLY * n : _AT_OFF * n].reshape(n, _T_COLUMNS)
    off = scratch[_AT_OFF * n : _AT_CONTACTS * n].reshape(2, n)
    con = scratch[_AT_CONTACTS * n : _AT_LEANING * n].reshape(_CONTACTS_EACH * n, _CONTACT_COLUMNS)
    cor = scratch[_AT_LEANING * n : _AT_PARTS * n].reshape(2 * n, _K_COLUMNS)
    at = _AT_PARTS * n + 2 * _PART_COLUMNS
    parts = scratch[_AT_PARTS * n : at].reshape(2, _PART_COLUMNS)
    hit = scratch[at : at + _FOOT]
    spot = scratch[at + _FOOT : at + _FOOT + _SPOT]
    who = marks[: _AT_WHO_LEANS * n].reshape(_CONTACTS_EACH * n, 4)
    leaning = marks[_AT_WHO_LEANS * n : _AT_TOUCH * n]
    touch = marks[_AT_TOUCH * n : _AT_NEARS * n]
    nears = marks[_AT_NEARS * n : _AT_RIMS * n]
    rims = marks[_AT_RIMS * n : _AT_NEAR * n]
    at = (_AT_NEAR + solids.shape[0]) * n
    near = marks[_AT_NEAR * n : at].reshape(n, solids.shape[0])
    rim_at = marks[at : at + edges.shape[0] * n].reshape(n, edges.shape[0])
    at += edges.shape[0] * n
    link_at = marks[at : at + edges.shape[0] * n].reshape(n, edges.shape[0])
    scratch[: _AT_OFF * n] = 0.0
    parts[:] = 0.0
    dt = world[DT]
    passed = dt * steps
    compliance = world[CONTACT_COMPLIANCE] / (dt * dt)
    imu = int(world[IMU_LINK])
    vx, vy, vz = vel[imu, 0], vel[imu, 1], vel[imu, 2]
    parts[0, N_INV_I] = 1.0 / world[INERTIA_FRONT]
    parts[1, N_INV_I] = 1.0 / world[INERTIA_REAR]
    _prepare(n, command, body, world, w)
    _look_around(
        n, pos, vel, body, solids, edges, points, world, passed, near, nears, rims, rim_at, link_at
    )
    current = 0.0
    deepest = 0.0
    count = 0
    leans = 0
    for step in range(steps):
        if step % int(world[LOOK]) == 0:
            _stand(pos, roll, world, parts)
            _begin(n, pos, bend, motor, command, body, world, w, parts, tally)
            _lie_in_planes(n, body, world, w, parts)
            count = _find_contacts(
                n, pos, vel, solids, edges, points, world, near, nears, rims, rim_at, con, who, hit
            )
            _prepare_contacts(count, body, world, anchor, w, parts, con, who)
            leans = _find_leaning(
                n, pos, solids, edges, points, body, world, near, nears, rims, link_at,
                cor, leaning, hit,
            )  # fmt: skip
        else:
            _go_on(
                n, count, leans, mov, roll, bend, motor, anchor, command, body, world, w, parts,
                con, who, cor, leaning, tally,
            )  # fmt: skip
        current += _turn_roll_motor(roll, world)
        for c in range(count):
            deepest = min(deepest, con[c, DISTANCE])
        for c in range(leans):
            deepest = min(deepest, cor[c, K_GAP])
        _predict(n, mov, vel, roll, world, parts)
        twist = 0.0
        for k in range(int(world[ITERATIONS])):
            if k >= world[PULL]:
                _solve_joints(n, mov, bend, motor, body, dt * dt, w)
            _solve_planes(n, mov, body, world, w, parts, off)
            twist = _solve_twist(roll, parts, dt, twist)
            _solve_contacts(count, mov, body, compliance, parts, con, who)
            _solve_leaning(leans, mov, body, compliance, w, cor, leaning)
            _solve_links(n, mov, body, w)
        for i in range(n):
            for k in range(3):
                vel[i, k] = mov[i, k] / dt
                pos[i, k] += mov[i, k]
            tally[i, T_TORQUE] += body[i, JOINT_K] * (motor[i] - bend[i])
        _turn_wheels(n, count, mov, wheel, anchor, world, w, parts, con, who, touch, tally)
        _keep(roll, parts, dt)
    _stand(pos, roll, world, parts)
    _project(n, pos, legs, world, parts, spot, out)
    per_step = 1.0 / (dt * dt * steps)
    for i in range(n):
        turned[i] += _WHEEL_FILTER * (wheel[i] - read[i] - turned[i])
        read[i] = wheel[i]
        out[i] = bend[i]
        out[n + i] = tally[i, T_TORQUE] / steps
        out[2 * n + i] = tally[i, T_CURRENT] / steps
        out[3 * n + i] = wheel[i]
        out[4 * n + i] = turned[i]
        out[5 * n + i] = tally[i, T_DRIVE] * per_step
        out[6 * n + i] = tally[i, T_PRESS] * per_step
        out[8 * n + i] = tally[i, T_GRIP] * per_step
    out[OUT_PER_WHEEL * n] = roll[R_ANGLE]
    out[OUT_PER_WHEEL * n + 1] = current / steps
    own = OUT_PER_WHEEL * n + OUT_SINGLE
    out[own + OUT_ROLL] = roll[R_ANGLE]
    out[own + OUT_DEEPEST] = max(out[own + OUT_DEEPEST], -deepest)
    _feel(
        n,
        pos,
        (vel[imu, 0] - vx) / passed,
        (vel[imu, 1] - vy) / passed,
        (vel[imu, 2] - vz) / passed,
        world,
        parts,
        out,
    )
