"""The robot and its pipe as a ``foxglove.SceneUpdate``: drawn once, moved by the frames.

Walls of round pipes are cylinders where they are straight, else triangles.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import pairwise
from math import atan2, cos, dist, hypot, sin
from typing import Any, NamedTuple

from pirate_sm.core.geometry import Piece, Route, Vector, combined, crossed, dot, flat, walls
from pirate_sm.core.models import Body, Pipe
from pirate_sm.running.recording.viewers.pipe_walls import Ring, Rings, unit, walls_in_space
from pirate_sm.running.recording.viewers.transforms import PIPE, Quaternion, of_axes

# --- pipes ----------------------------------------------------------------------------------------


_ROUNDING_M = 1e-6


class Cylinder(NamedTuple):
    """A straight wall with square ends.

    Attributes:
        middle: The middle of its axis, m.
        turned: The rotation that takes z to its axis.
        diameter_m: Its inner diameter.
        length_m: Its length.
    """

    middle: Vector
    turned: Quaternion
    diameter_m: float
    length_m: float


class Mesh(NamedTuple):
    """A wall of any other shape.

    Attributes:
        points: The corners, m.
        triangles: For each triangle the indices of its corners.
    """

    points: tuple[Vector, ...]
    triangles: tuple[tuple[int, int, int], ...]


def walls_to_draw(route: Route) -> Iterator[Cylinder | Mesh]:
    """Yield the walls of all pipes of a route's network, in the frame of the drawing."""
    for rings in walls_in_space(route.network, route.placement):
        yield _cylinder(rings) or _mesh(rings)


def _cylinder(rings: Rings) -> Cylinder | None:
    """Return the cylinder that two rings are; None for another shape."""
    if len(rings) != 2:
        return None
    first, last = (_middle(ring) for ring in rings)
    length_m, radius_m = dist(first, last), dist(first, rings[0][0])
    if length_m < _ROUNDING_M:
        return None
    axis = unit(combined((1.0, last), (-1.0, first)))
    for middle, ring in ((first, rings[0]), (last, rings[1])):
        for point in ring:
            away = combined((1.0, point), (-1.0, middle))
            if (
                abs(dot(away, axis)) > _ROUNDING_M
                or abs(dist(point, middle) - radius_m) > _ROUNDING_M
            ):
                return None
    across = unit(combined((1.0, rings[0][0]), (-1.0, first)))
    turned = of_axes(across, crossed(axis, across), axis)
    return Cylinder(combined((0.5, first), (0.5, last)), turned, 2 * radius_m, length_m)


def _mesh(rings: Rings) -> Mesh:
    around = len(rings[0])
    triangles = []
    for ring, _ in enumerate(pairwise(rings)):
        for number in range(around):
            a, b = ring * around + number, ring * around + (number + 1) % around
            triangles += [(a, b, a + around), (b, b + around, a + around)]
    return Mesh(tuple(point for ring in rings for point in ring), tuple(triangles))


def _middle(ring: Ring) -> Vector:
    share = 1.0 / len(ring)
    return combined(*((share, point) for point in ring))


# --- the scene ------------------------------------------------------------------------------------


_WALL = (0.55, 0.58, 0.62, 1.0)
_GLASS = (0.55, 0.58, 0.62, 0.15)
_BODY = (0.93, 0.55, 0.14, 1.0)
_WHEEL = (0.2, 0.2, 0.22, 1.0)
_SPOKE = (0.95, 0.95, 0.95, 1.0)
_SPOKE_M = 0.003
_WALL_M = 0.004

_LINE_LIST = 2
_KINDS = ("arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models")
_UPRIGHT = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}


def scene_message(stamp: str, body: Body, pipe: Pipe | None) -> bytes:
    """Return a message with the whole scene, which viewers show as long as they run.

    Args:
        stamp: The time as JSON.
        body: The robot's body.
        pipe: The pipe; None if unknown.
    """
    entities = [*_links(body), *_wheels(body)]
    if pipe is not None:
        entities.append(_pipe(pipe) if pipe.section == "bars" else _network(pipe))
    time = json.loads(stamp)
    for entity in entities:
        entity["timestamp"] = time
    return json.dumps({"deletions": [], "entities": entities}, separators=(",", ":")).encode()


def _entity(name: str, frame: str, **shapes: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "frame_id": frame,
        "id": name,
        "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": True,
        "metadata": [],
        **{kind: shapes.get(kind, []) for kind in _KINDS},
    }


def _links(body: Body) -> list[dict[str, Any]]:
    thick = 2 * body.body_half_thickness
    entities = []
    for link in body.links:
        halves = [link.module] if link.roll is None else [link.module, f"{link.module}_rear"]
        length = link.length / len(halves)
        shape = _shape(_point(-length / 2), (length, thick, thick), _BODY)
        entities += [_entity(name, name, cubes=[shape]) for name in halves]
    return entities


def _wheels(body: Body) -> list[dict[str, Any]]:
    across, width = 2 * body.wheel_radius, body.wheel_width
    disc = _shape(_point(), (across, across, width), _WHEEL)
    disc |= {"bottom_scale": 1.0, "top_scale": 1.0}
    spoke = _shape(_point(), (across, _SPOKE_M, width + _SPOKE_M), _SPOKE)
    return [
        _entity(wheel.name, wheel.name, cylinders=[disc], cubes=[spoke]) for wheel in body.wheels
    ]


def _pipe(pipe: Pipe) -> dict[str, Any]:
    route = pipe.route()
    points = [
        _point(*corner) for wall in walls(route) for pair in pairwise(wall) for corner in pair
    ]
    lines = {"type": _LINE_LIST, "pose": _pose(_point()), "thickness": _WALL_M}
    lines |= {"scale_invariant": False, "points": points}
    lines |= {"color": _color(_WALL), "colors": [], "indices": []}
    glass = [_glass(piece) for piece in route.pieces]
    return _entity(PIPE, PIPE, lines=[lines], cylinders=glass)


def _network(pipe: Pipe) -> dict[str, Any]:
    """Return all pipes of a network; the frame of the drawing is turned so that down is down."""
    cylinders, triangles = [], []
    for wall in walls_to_draw(pipe.route()):
        if isinstance(wall, Cylinder):
            size = wall.diameter_m, wall.diameter_m, wall.length_m
            shape = _shape(_point(*wall.middle), size, _GLASS)
            shape["pose"]["orientation"] = wall.turned.json
            cylinders.append(shape | {"bottom_scale": 1.0, "top_scale": 1.0})
        else:
            mesh: dict[str, Any] = {"pose": _pose(_point()), "color": _color(_GLASS), "colors": []}
            mesh["points"] = [_point(*(round(value, 6) for value in p)) for p in wall.points]
            mesh["indices"] = [corner for triangle in wall.triangles for corner in triangle]
            triangles.append(mesh)
    return _entity(PIPE, PIPE, cylinders=cylinders, triangles=triangles)


def _glass(piece: Piece) -> dict[str, Any]:
    """Return a piece of pipe as a transparent cylinder; its own axis is z."""
    middle = flat(piece.point(piece.arc_m + piece.length_m / 2))
    heading = atan2(piece.frame.ahead[1], piece.frame.ahead[0])
    # First a rotation from z to x by a right angle about y, then about z by the heading.
    half = hypot(0.5, 0.5)
    turned = {
        "x": -sin(heading / 2) * half,
        "y": cos(heading / 2) * half,
        "z": sin(heading / 2) * half,
        "w": cos(heading / 2) * half,
    }
    shape = _shape(_point(*middle), (piece.diameter_m, piece.diameter_m, piece.length_m), _GLASS)
    shape["pose"]["orientation"] = turned
    return shape | {"bottom_scale": 1.0, "top_scale": 1.0}


def _shape(
    place: dict[str, float],
    size: tuple[float, float, float],
    color: tuple[float, float, float, float],
) -> dict[str, Any]:
    return {
        "pose": _pose(place),
        "size": dict(zip("xyz", size, strict=True)),
        "color": _color(color),
    }


def _pose(place: dict[str, float]) -> dict[str, Any]:
    return {"position": place, "orientation": dict(_UPRIGHT)}


def _point(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> dict[str, float]:
    return {"x": x, "y": y, "z": z}


def _color(parts: tuple[float, float, float, float]) -> dict[str, float]:
    return dict(zip("rgba", parts, strict=True))
