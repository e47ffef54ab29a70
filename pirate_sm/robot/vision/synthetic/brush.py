"""Draw shapes of the setup into a picture through the lens, with smooth edges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, pi, sin
from typing import TypeAlias

import numpy as np

from pirate_sm.core.camera import TagFamily
from pirate_sm.robot.vision.opencv import cv2
from pirate_sm.robot.vision.picture_arrays import Floats, Frame
from pirate_sm.robot.vision.plane import View, raised
from pirate_sm.robot.vision.tags import tag_cells, tag_corners

Colour: TypeAlias = tuple[int, int, int]
"""Blue, green, red."""

_SHIFT = 4  # places of polygons have a sixteenth of a pixel
_LONGEST_M = 0.02  # a longer straight line is bent by the lens
_FINER = 4
_CELL = 8  # pixels of a tag's cell before it is seen from the camera
_CORNERS = 32


@dataclass(frozen=True)
class Brush:
    """Draws into one picture.

    Attributes:
        frame: The picture, which is changed.
        view: The lens and its place.
    """

    frame: Frame
    view: View

    def polygon(self, places: Sequence[tuple[float, float]], z_m: float, colour: Colour) -> None:
        """Draw a filled polygon that lies at a height; nothing if the lens cannot see all of it."""
        pixels = self.view.project(raised(_dense(np.array(places)), z_m))
        if not np.all(np.isfinite(pixels)) or np.abs(pixels).max() > 1e5:
            return
        corners = np.round(pixels * (1 << _SHIFT)).astype(np.int32)
        cv2.fillPoly(self.frame, [corners], colour, cv2.LINE_AA, _SHIFT)

    def bar(
        self,
        one: tuple[float, float],
        other: tuple[float, float],
        width_m: float,
        z_m: float,
        colour: Colour,
    ) -> None:
        """Draw a straight bar between two places."""
        self.polygon(bar_corners(one, other, width_m), z_m, colour)

    def disc(
        self, middle: tuple[float, float], radius_m: float, z_m: float, colour: Colour
    ) -> None:
        """Draw a filled circle."""
        x, y = middle
        turns = [2 * pi * number / _CORNERS for number in range(_CORNERS)]
        self.polygon([(x + radius_m * cos(a), y + radius_m * sin(a)) for a in turns], z_m, colour)

    def tag(
        self,
        family: TagFamily,
        number: int,
        middle: tuple[float, float],
        heading_rad: float,
        size_m: float,
        z_m: float,
    ) -> None:
        """Draw a tag with a white margin of one cell."""
        cells = np.pad(tag_cells(family, number), 1, constant_values=255)
        across = len(cells)
        whole_m = size_m * across / (across - 2)
        corners = self.view.project(raised(tag_corners(middle, heading_rad, whole_m), z_m))
        if not np.all(np.isfinite(corners)):
            return
        picture = np.kron(cells, np.ones((_CELL, _CELL), np.uint8))
        self._paste(picture, corners)

    def _paste(self, picture: Frame, corners: Floats) -> None:
        """Draw a gray picture into the quadrilateral of these corners, px."""
        height, width = self.frame.shape[:2]
        left, top = np.maximum(np.floor(corners.min(axis=0)).astype(int) - 1, 0)
        right, bottom = np.minimum(np.ceil(corners.max(axis=0)).astype(int) + 2, (width, height))
        if left >= right or top >= bottom:
            return
        side = len(picture) - 0.5
        edges = np.array([(-0.5, -0.5), (side, -0.5), (side, side), (-0.5, side)], np.float32)
        # The centre of pixel 0 is at 0, of the finer ones at fractions of it.
        finer = ((corners - (left, top) + 0.5) * _FINER - 0.5).astype(np.float32)
        size = ((right - left) * _FINER, (bottom - top) * _FINER)
        turned = cv2.getPerspectiveTransform(edges, finer)
        drawn = cv2.warpPerspective(picture, turned, size, borderMode=cv2.BORDER_REPLICATE)
        mask = np.zeros((size[1], size[0]), np.uint8)
        cv2.fillConvexPoly(mask, np.round(finer).astype(np.int32), 255)
        small = (int(right - left), int(bottom - top))
        drawn = cv2.resize(drawn, small, interpolation=cv2.INTER_AREA).astype(np.float32)
        share = cv2.resize(mask, small, interpolation=cv2.INTER_AREA).astype(np.float32) / 255
        part = self.frame[top:bottom, left:right]
        part[:] = np.round(
            part + (drawn - part.transpose(2, 0, 1)).transpose(1, 2, 0) * share[..., None]
        )


def bar_corners(
    one: tuple[float, float], other: tuple[float, float], width_m: float
) -> list[tuple[float, float]]:
    """Return the corners of a bar from one place to another."""
    ahead = np.array(other) - np.array(one)
    length = float(np.hypot(ahead[0], ahead[1])) or 1.0
    left = np.array([-ahead[1], ahead[0]]) / length * width_m / 2
    corners = (one + left, other + left, other - left, one - left)
    return [(float(x), float(y)) for x, y in corners]


def _dense(places: Floats) -> Floats:
    """Return the corners of a polygon with more corners on its long sides."""
    corners = []
    for here, there in zip(places, np.roll(places, -1, axis=0), strict=True):
        pieces = int(np.hypot(*(there - here)) // _LONGEST_M) + 1
        corners += [here + (there - here) * number / pieces for number in range(pieces)]
    return np.array(corners)
