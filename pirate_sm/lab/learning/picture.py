"""A picture of a robot in its pipe as an array of colours, from above, for videos of agents."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pirate_sm.core.geometry import Place, drawn_walls
from pirate_sm.core.models import Body, Pipe
from pirate_sm.core.palette import DAY
from pirate_sm.running.recording.viewers.pipe_walls import outlines, plain_tubes

Image: TypeAlias = NDArray[np.uint8]
_Floats: TypeAlias = NDArray[np.float64]

WIDTH, HEIGHT = 640, 360
_SHOWN_M = 1.5
"""The width of the picture in lengths of the robot, so that it may lie in any direction [D]."""

_WALL_M = 0.004


class DrawnPipe(NamedTuple):
    """What is seen of the pipe.

    Attributes:
        walls: Corners of the walls of a planar pipe.
        areas: Convex areas that together are the inside of round pipes.
    """

    walls: tuple[tuple[Place, ...], ...]
    areas: tuple[tuple[Place, ...], ...]


def drawn_pipe(pipe: Pipe | None) -> DrawnPipe:
    """Return what is seen of a pipe from above."""
    if pipe is None:
        return DrawnPipe((), ())
    route = pipe.route()
    walls = drawn_walls(route)
    return DrawnPipe(walls, () if walls else outlines(plain_tubes(route.placement), (0, 1)))


def picture(wheels: Sequence[Place], held: Sequence[bool], body: Body, around: DrawnPipe) -> Image:
    """Return the picture, ``HEIGHT`` × ``WIDTH`` × 3 values from 0 to 255.

    Args:
        wheels: Where the wheels are, front to rear, m.
        held: Whether each link is part of what holds.
        body: The robot's body.
        around: Its surroundings.
    """
    length_m = sum(float(np.hypot(*np.subtract(a, b))) for a, b in pairwise(wheels))
    sheet = _Sheet(np.mean(wheels, axis=0), max(length_m, 1e-3) * _SHOWN_M / WIDTH)
    for area in around.areas:
        sheet.fill(area, "bore")
    for wall in around.walls:
        sheet.line(wall, _WALL_M, "wall")
    for link, is_held in zip(pairwise(wheels), held, strict=True):
        sheet.line(link, body.body_half_thickness, "held" if is_held else "body")
    for number, wheel in enumerate(wheels):
        sheet.line((wheel, wheel), body.wheel_radius, "ink")
        sheet.line((wheel, wheel), 0.8 * body.wheel_radius, "paper" if number else "soft")
    return sheet.colours


class _Sheet:
    """Colours of pixels around a place.

    Args:
        middle: The place, m.
        pixel_m: Size of a pixel.
    """

    def __init__(self, middle: _Floats, pixel_m: float) -> None:
        self.colours: Image = np.empty((HEIGHT, WIDTH, 3), np.uint8)
        self.colours[:] = _rgb("paper")
        x = middle[0] + (np.arange(WIDTH) - WIDTH / 2 + 0.5) * pixel_m
        y = middle[1] - (np.arange(HEIGHT) - HEIGHT / 2 + 0.5) * pixel_m
        self._x, self._y = x[None, :], y[:, None]

    def line(self, points: Iterable[Place], half_m: float, role: str) -> None:
        """Draw everything within this distance of the line through the points."""
        for (ax, ay), (bx, by) in pairwise(points):
            dx, dy = bx - ax, by - ay
            whole = dx * dx + dy * dy or 1.0
            share = np.clip(((self._x - ax) * dx + (self._y - ay) * dy) / whole, 0.0, 1.0)
            off = np.hypot(self._x - ax - share * dx, self._y - ay - share * dy)
            self.colours[off <= half_m] = _rgb(role)

    def fill(self, corners: Sequence[Place], role: str) -> None:
        """Draw the convex area with these corners."""
        sides = [
            (self._x - ax) * (by - ay) - (self._y - ay) * (bx - ax)
            for (ax, ay), (bx, by) in pairwise((*corners, corners[0]))
        ]
        inside = np.all([side >= 0.0 for side in sides], axis=0)
        inside |= np.all([side <= 0.0 for side in sides], axis=0)
        self.colours[inside] = _rgb(role)


def _rgb(role: str) -> tuple[int, int, int]:
    colour = DAY[role]
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)
