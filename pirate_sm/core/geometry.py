"""Pipes and robots in space: routes, walls, joints, kinematics, statics."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._geometry.chain import (
    WHEELS_SHARE,
    ChainInSpace,
    Pose,
    height_m,
    in_space,
    press_n,
    span_m,
)
from pirate_sm.core._geometry.network import (
    BRANCH,
    IN,
    ON,
    Arc,
    Network,
    Piece,
    Section,
    port_of,
    tilted_up,
)
from pirate_sm.core._geometry.placement import Placement
from pirate_sm.core._geometry.route import (
    Bend,
    Route,
    RouteJoint,
    Walls,
    drawn_walls,
    flat,
    inner_corner,
    turned,
    walls,
)
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
