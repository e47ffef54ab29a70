"""A pipe as MuJoCo's boxes: bars beside a robot in a plane, plates around one in space."""

from __future__ import annotations

from math import atan2, cos, dist, pi, sin, tan
from xml.etree.ElementTree import Element, SubElement

from pirate_sm.core.errors import UsageError
from pirate_sm.core.geometry import Piece, Route, flat, walls
from pirate_sm.simulation.mujoco.names import BOTH_BITS, OBSTACLE, WHEEL_BIT, numbers

PLATES = 24
"""Of a round pipe; between two of them it is 1 % wider than on their middles."""
# Thin enough that the end of a bar at an inner corner hardly stands out of the next bar.
_HALF_M = 0.003
_FAR_M = 1000.0


def add_pipe(world: Element, route: Route, *, space: bool) -> None:
    """Add the walls of a route, and an obstacle that is far away, to the bodies of a world.

    Raises:
        UsageError: The pipe is round and not straight.
    """
    if not space:
        _add_bars(world, route)
    elif len(route.pieces) > 1:
        raise UsageError(
            "the backend physics has no bends in a round pipe: use a straight one, or"
            " `section: bars` for its plane"
        )
    else:
        _add_plates(world, route.pieces[0])
    half = route.pieces[0].diameter_m / 2
    body = SubElement(world, "body", name=OBSTACLE, mocap="true", pos=numbers(_FAR_M, _FAR_M, 0))
    # Its face is the origin, and it lies ahead of it.
    SubElement(
        body, "geom", type="box", pos=numbers(half, 0, 0), size=numbers(half, half, half),
        priority="3", condim="1", contype="0", conaffinity=WHEEL_BIT, rgba="0.7 0.2 0.2 1",
    )  # fmt: skip


def _add_bars(world: Element, route: Route) -> None:
    """Add a bar for each wall; it begins and ends where the walls meet."""
    half_m = route.pieces[0].diameter_m / 2
    for side, corners in enumerate(walls(route)):
        outwards = 1.0 if side == 0 else -1.0
        for piece, (x0, y0), (x1, y1) in zip(route.pieces, corners[:-1], corners[1:], strict=True):
            ahead_x, ahead_y = flat(piece.frame.ahead)
            off = outwards * _HALF_M
            place = ((x0 + x1) / 2 - off * ahead_y, (y0 + y1) / 2 + off * ahead_x, 0.0)
            turn = atan2(ahead_y, ahead_x) / 2
            _add_box(
                world, place, (cos(turn), 0.0, 0.0, sin(turn)),
                (dist((x0, y0), (x1, y1)) / 2, _HALF_M, half_m),
            )  # fmt: skip


def _add_plates(world: Element, piece: Piece) -> None:
    """Add plates that touch the round wall of a straight pipe along their middles."""
    radius, half = piece.diameter_m / 2, piece.length_m / 2
    out = radius + _HALF_M
    width = out * tan(pi / PLATES)
    for number in range(PLATES):
        angle = 2 * pi * number / PLATES
        place = (half, out * cos(angle), out * sin(angle))
        turn = (cos(angle / 2), sin(angle / 2), 0.0, 0.0)
        _add_box(world, place, turn, (half, _HALF_M, width))


def _add_box(
    world: Element,
    place: tuple[float, float, float],
    turn: tuple[float, float, float, float],
    size: tuple[float, float, float],
) -> None:
    SubElement(
        world, "geom", type="box", pos=numbers(*place), quat=numbers(*turn), size=numbers(*size),
        contype="0", conaffinity=BOTH_BITS, rgba="0.6 0.7 0.8 0.25",
    )  # fmt: skip
