"""Columns of the arrays that the kernel in space computes in, and what its modules share.

`space_world.py`, `pipe_shape.py` and `solids.py` fill the arrays from outside.
"""

from __future__ import annotations

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

# Entries of `world`; the last five are for how many substeps directions and contacts are kept, in
# which iteration joints are first pulled, the share of a call in what the accelerometer shows, and
# on what share of its radius a wheel rolls at least, however it leans: on the edge of its tyre; and
# the force that resists rolling over the normal force.
DT, ITERATIONS, RADIUS, HALF_THICKNESS, CONTACT_COMPLIANCE, ANCHOR_MAX = range(6)
G_X, G_Y, G_Z, MAG_X, MAG_Y, MAG_Z = range(6, 12)
BLOCK_NODE, BLOCK_X, BLOCK_Y, BLOCK_Z, BLOCK_NX, BLOCK_NY, BLOCK_NZ = range(12, 19)
ROLL_LINK, ROLL_TARGET, ROLL_RATE, ROLL_STALL, INERTIA_FRONT, INERTIA_REAR, IMU_LINK = range(19, 26)
LOOK, PULL, FELT, TYRE_EDGE, ROLLING_RESISTANCE = range(26, 31)
WORLD_ENTRIES = 31

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

# Scratch columns per wheel: its joint and its motors, as in the plane; the link behind it, its
# levers in the planes of its two ends, gradients of its joint.
J_C, J_D, J_W, J_INV, J_LAM, J_FRICTION, J_STOP, J_RESISTS = range(8)
SPIN, FORCE, SLOPE, LINK_SCALE = range(8, 12)
D_X, D_Y, D_Z, LF_X, LF_Y, LF_Z, LR_X, LR_Y, LR_Z = range(12, 21)
GA_X, GA_Y, GA_Z, GM_X, GM_Y, GM_Z, GB_X, GB_Y, GB_Z = range(21, 30)
# Coplanarity of the link behind the wheel: value, share of the roll link's tilt, of the roll,
# inverse mass, impulse.
P_C, P_TILT, P_ROLL, P_INV, P_LAM = range(30, 35)
NODE_COLUMNS = 35
# Scratch of the two parts: normal, `n x e`, roll in this substep, inverse inertia, roll since the
# normals were found.
N_X, N_Y, N_Z, N_BX, N_BY, N_BZ, N_ROLL, N_INV_I, N_ROLLED = range(9)
PART_COLUMNS = 9
T_PRESS, T_DRIVE, T_GRIP, T_TORQUE, T_CURRENT, T_COLUMNS = range(6)
# Scratch columns per contact of a wheel.
NX, NY, NZ, GAP, PUSH, PUSH_INV = range(6)
GI_X, GI_Y, GI_Z, GO_X, GO_Y, GO_Z, DRIVE, DRIVE_INV, TARGET, K_SLOPE, K_FORCE = range(6, 17)
SX, SY, SZ, S_TURN, SIDE, SIDE_W, S_TARGET, K_MU, K_RADIUS, K_CREEP, DISTANCE = range(17, 28)
K_STIFF, HELD = 28, 29
CONTACT_COLUMNS = 30
NODE, OTHER, SURFACE, PART = range(4)
# Scratch columns per contact of a link.
K_NX, K_NY, K_NZ, K_SHARE, K_GAP, K_PUSH, K_INV, K_COLUMNS = range(8)

# How many surfaces a wheel remembers.
ANCHORS = 3

MARGIN_M = 0.002
SLIPPED, STUCK = 0.999, 0.998
# The spring between the motor of the roll joint and the two parts.
TWIST_NM_RAD = 30.0
