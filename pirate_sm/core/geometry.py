"""Pipes and robots in space: routes, walls, joints, kinematics, statics."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._geometry import plane
from pirate_sm.core._geometry.chain_in_space import ChainInSpace, in_space
from pirate_sm.core._geometry.clamping import WHEELS_SHARE, height_m, press_n, span_m
from pirate_sm.core._geometry.joints import Bend, RouteJoint
from pirate_sm.core._geometry.kinematics import Pose, link_poses
from pirate_sm.core._geometry.mouth import sink_m
from pirate_sm.core._geometry.network import BRANCH, IN, ON, Network, Section, port_of, tilted_up
from pirate_sm.core._geometry.part_planes import part_normals, unit
from pirate_sm.core._geometry.piece import Arc, Piece
from pirate_sm.core._geometry.placement import Placement
from pirate_sm.core._geometry.plane import (
    Walls,
    drawn_walls,
    flat,
    inner_corner,
    nearest_on,
    turned,
    walls,
)
from pirate_sm.core._geometry.room import Room
from pirate_sm.core._geometry.route import Route
from pirate_sm.core._geometry.space import (
    DRAWING,
    GRAVITY_M_S2,
    Frame,
    Place,
    Vector,
    between,
    combined,
    crossed,
    dot,
    scaled,
)
from pirate_sm.core._geometry.tube_rings import Ring, Rings, plain_tubes, walls_in_space
from pirate_sm.core._geometry.views import (
    Outline,
    clock_rad,
    outlines,
    seen_in,
    unrolled,
    unrolled_walls,
    upright,
)
