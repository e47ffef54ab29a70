"""Columns of the arrays that the kernel computes in, and what several of its modules share.

`world.py` fills the arrays from outside.
"""

from __future__ import annotations

# Columns of `body`, a row per wheel; joint columns are of the joint at that wheel, the link's
# length is of the link from that wheel to the next one behind it.
MASS_INV, MU_STATIC, MU_KINETIC, WHEEL_RATE, WHEEL_STALL, WHEEL_HOLD, MOTOR_LINK = range(7)
JOINT_K, JOINT_RATE, JOINT_STALL, JOINT_FRICTION, JOINT_MIN, JOINT_MAX, JOINT_DAMPING = range(7, 14)
LINK_LENGTH = 14
BODY_COLUMNS = 15

# Columns of `walls`: start, unit tangent, length, unit normal into the pipe; whether an inner
# corner ends it, then the next wall's tangent and the bisector into the pipe.
W_X, W_Y, W_TX, W_TY, W_LENGTH, W_NX, W_NY, W_CORNER, W_NEXT_TX, W_NEXT_TY, W_BX, W_BY = range(12)
WALL_COLUMNS = 12

# Columns of `legs`, the straight parts of the centre line: start, unit tangent, length, arc length
# at the start, gravity along it, towards side A and along the normal of the plane.
L_X, L_Y, L_TX, L_TY, L_LENGTH, L_S, L_GT, L_GN, L_GB = range(9)
LEG_COLUMNS = 9

# Entries of `world`: the step, the body's sizes, the contact, an obstacle, the roll joint, the
# magnetic field in the axes of the drawing; for how many substeps directions and contacts are kept,
# in which iteration joints are first pulled, the share of a call in what the accelerometer shows,
# and the force that resists rolling over the normal force.
DT, ITERATIONS, RADIUS, HALF_THICKNESS, CONTACT_COMPLIANCE, ANCHOR_MAX, DEPTH = range(7)
BLOCK_NODE, BLOCK_X, BLOCK_Y, BLOCK_NX, BLOCK_NY = range(7, 12)
ROLL_LINK, ROLL_TARGET, ROLL_RATE, MAG_X, MAG_Y, MAG_Z, ROLL_STALL = range(12, 19)
LOOK, PULL, FELT, ROLLING_RESISTANCE = range(19, 23)
WORLD_ENTRIES = 23

# Blocks of `state`; the number times the count of wheels is the length of each.
S_POSITION, S_VELOCITY, S_MOTOR, S_WHEEL, S_BEND, S_ANCHOR, S_TURNED, S_READ, S_ROLL = (
    0, 2, 4, 5, 6, 7, 11, 12, 13,
)  # fmt: skip
# `out` has a block for each of `physics.PER_WHEEL`, the entries `physics.SINGLE`, and two blocks of
# the kernel's own: each wheel's offset towards side A and the number of its leg.
OUT_PER_WHEEL = 9
OUT_SINGLE = 8
OUT_OWN = 2

# Scratch columns per wheel. Those of joints and motors come first, as in space, which uses the same
# functions for them.
J_C, J_D, J_W, J_INV, J_LAM, J_FRICTION, J_STOP, J_RESISTS = range(8)
SPIN, FORCE, SLOPE, LINK_SCALE = range(8, 12)
X0, Y0, LEVER_X, LEVER_Y, GA_X, GA_Y, GM_X, GM_Y, GB_X, GB_Y, G_X, G_Y, DRAG = range(12, 25)
NODE_COLUMNS = 25
# Sums per wheel over the substeps of a call.
T_PRESS, T_DRIVE, T_GRIP, T_TORQUE, T_CURRENT, T_COLUMNS = range(6)
# Scratch columns per contact, and per link at an inner corner.
(
    NX, NY, N_INV, GAP, PUSH, GI_X, GI_Y, GO_X, GO_Y, T_INV, ROLLING, TARGET, C_SLOPE, C_MU,
    C_FORCE, C_STIFF, HELD,
) = range(17)  # fmt: skip
CONTACT_COLUMNS = 17
K_NX, K_NY, K_SHARE, K_GAP, K_PUSH, K_INV, K_COLUMNS = range(7)
NODE, OTHER, KEY = range(3)

MARGIN_M = 0.002
# Shares of the longest anchor: from the first on the friction is kinetic; a wheel that does not
# slip stays below the second.
SLIPPED, STUCK = 0.999, 0.998
