"""The pose of a robot at the start of a run: wheel positions, and how springs are wound up."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise

from pirate_sm.errors import UsageError
from pirate_sm.geometry.clamping import span_m
from pirate_sm.geometry.route import Route
from pirate_sm.geometry.space import Vector
from pirate_sm.simulation.mechanics import ChainBody
from pirate_sm.simulation.physics import StartPose


def stand(
    chain: ChainBody, route: Route, arc_m: float, duties: Mapping[int, float], roll_rad: float = 0.0
) -> StartPose:
    """Return the pose of the robot in a straight piece of the pipe.

    Args:
        chain: The moving parts.
        route: The pipe.
        arc_m: Position of the first wheel along the pipe.
        duties: Duty of each bend joint that is wound up, by its wheel; empty for a straight,
            unclamped robot.
        roll_rad: Roll of the whole robot against the plane of the pipe.

    Raises:
        UsageError: It does not fit there; the message says why.
    """
    held = {wheel: duty for wheel, duty in sorted(duties.items()) if duty != 0.0}
    piece = route.piece_at(arc_m)
    height = piece.diameter_m - 2.0 * chain.wheel_radius_m if held else 0.0
    if any(height >= link.length_m for link in chain.links):
        raise UsageError("the robot cannot be clamped in so wide a pipe")
    side = _first_side(held)
    arc = arc_m
    places: list[Vector] = []
    tilts: list[float] = []
    for i in range(chain.nodes):
        places.append(route.piece_at(arc).point(arc, side * height / 2.0))
        if i == chain.nodes - 1:
            break
        length = chain.links[i].length_m
        tilts.append(side * math.asin(height / length))
        arc -= span_m(length, height)
        side = -side
    if arc < 0.0 or arc_m > route.length_m or route.piece_at(arc) is not piece:
        raise UsageError(
            f"the robot, {arc_m - arc:.2f} m long there, does not fit between the bends and"
            f" ends of the pipe with its first wheel at {arc_m:.2f} m"
        )
    # Headings are against the piece's direction: a link to side A ahead of one to side B.
    inner = [behind - ahead for ahead, behind in pairwise(tilts)]
    bends = (0.0, *inner, 0.0)
    motors = tuple(bend + _winding(chain, i, duties.get(i, 0.0)) for i, bend in enumerate(bends))
    return StartPose(tuple(places), bends, motors, roll_rad)


def _first_side(held: Mapping[int, float]) -> float:
    """Return 1 if the first wheel presses on side A, -1 if on side B.

    Joints alternate: with a negative duty, the V of an odd wheel's joint is open to side B. The
    strongest duty is that of a clamp; a bending part is pushed with less, to either side.
    """
    if not held:
        return 1.0
    strongest = max(held, key=lambda wheel: abs(held[wheel]))
    return math.copysign(1.0, -held[strongest]) * (1.0 if strongest % 2 else -1.0)


def _winding(chain: ChainBody, wheel: int, duty: float) -> float:
    """Return how far a duty winds up the spring of the joint at a wheel, rad."""
    joint = chain.joints.get(wheel)
    return duty * joint.stall_nm / joint.stiffness_nm_rad if joint else 0.0
