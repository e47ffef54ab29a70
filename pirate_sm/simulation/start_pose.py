"""The pose of a robot at the start of a run: wheel positions, and how springs are wound up."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise

from pirate_sm.core.errors import UsageError
from pirate_sm.core.geometry import Frame, Piece, Route, Vector, dot, span_m
from pirate_sm.core.models import Profile
from pirate_sm.simulation.physics import ChainBody, StartPose
from pirate_sm.simulation.standing import Standing

_TURNED_RAD = math.radians(5)
"""A roll joint that is nearer to its target has come to it; its spring gives way by 2 deg [D]."""

_LEAST_PULL = 0.01
"""Share of its weight below which a robot is not pulled to any side of an upright pipe."""


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


def standing_again(
    chain: ChainBody, profile: Profile, it: Standing, roll_target_rad: float
) -> StartPose:
    """Return the pose of a robot that is put back where it stood.

    Nobody measures where the motor of the roll joint is. It is not driven back, so it is at its
    target unless the joint was still turning when the recording was cut off.

    Args:
        chain: The robot's body.
        profile: Its profile.
        it: How it stood.
        roll_target_rad: Setpoint of the roll joint.
    """
    bends, motors = [0.0] * chain.nodes, [0.0] * chain.nodes
    for joint, bend, torque in zip(profile.body.joints, it.bends_rad, it.torques_nm, strict=True):
        wheel = chain.joint_index[joint.name]
        bends[wheel] = bend
        motors[wheel] = bend + torque / chain.joints[wheel].stiffness_nm_rad
    angle = it.rolls_rad[0]
    arrived = abs(roll_target_rad - angle) <= _TURNED_RAD
    motor = roll_target_rad if arrived else angle
    rolls, places = it.rolls_rad, it.places_m
    return StartPose(places, tuple(bends), tuple(motors), rolls_rad=rolls, roll_motor_rad=motor)


def lying(pose: StartPose, chain: ChainBody, route: Route) -> tuple[Vector, ...]:
    """Return the centres of the wheels in a round pipe, in the plane of the robot's roll.

    A robot that does not span the pipe lies on its wall, as gravity pulls it.
    """
    piece = _piece_of(pose, route)
    along = dot(route.up, piece.frame.ahead)
    pull = [along * a - u for a, u in zip(piece.frame.ahead, route.up, strict=True)]
    weight = math.hypot(*pull)
    room = piece.diameter_m / 2 - chain.wheel_radius_m
    offs = [_off(place, piece) for place in pose.places]
    fills = max(abs(aside) for _, aside in offs) > room / 2
    shift = 0.0 if fills or weight < _LEAST_PULL else room / weight
    dx, dy, dz = (shift * each for each in pull)
    frame = piece.frame.rolled(pose.roll_rad)
    places = [frame.point(along, aside) for along, aside in offs]
    return tuple((x + dx, y + dy, z + dz) for x, y, z in places)


def normals_of(pose: StartPose, route: Route, link: int) -> tuple[Vector, Vector]:
    """Return the unit normals of the planes of the parts ahead and behind in a round pipe.

    Args:
        pose: The pose.
        route: The way through the pipe.
        link: Index of the link with the roll joint, which belongs to both parts.
    """
    if not pose.rolls_rad:
        normal = _piece_of(pose, route).frame.rolled(pose.roll_rad).normal
        return normal, normal
    ahead, behind = pose.places[link], pose.places[link + 1]
    (ax, ay, az), (bx, by, bz) = ahead, behind
    along = (ax - bx, ay - by, az - bz)
    front, rear = (
        _normal_at(route.frame_at(route.arc_of(place)).rolled(roll), along)
        for place, roll in zip((ahead, behind), pose.rolls_rad[1:], strict=True)
    )
    return front, rear


def _normal_at(frame: Frame, along: Vector) -> Vector:
    """Return the unit vector square to a link whose roll about the frame's axis is the frame's.

    The roll of a part is that of its normal across the pipe's axis. The normal may lean along the
    axis, because the link does.
    """
    share = dot(frame.normal, along) / dot(frame.ahead, along)
    x, y, z = (n - share * a for n, a in zip(frame.normal, frame.ahead, strict=True))
    size = math.sqrt(x * x + y * y + z * z)
    return x / size, y / size, z / size


def _piece_of(pose: StartPose, route: Route) -> Piece:
    return route.piece_at(route.arc_of(pose.places[0]))


def _off(place: Vector, piece: Piece) -> tuple[float, float]:
    """Return how far a place is along a piece, and from its axis towards side A, m."""
    along = piece.beyond_m(place)
    axis = piece.frame.point(along)
    return along, sum((p - a) * s for p, a, s in zip(place, axis, piece.frame.side, strict=True))


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
