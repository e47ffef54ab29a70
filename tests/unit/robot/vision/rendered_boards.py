"""Draws chessboards as lenses of any angle show them, without OpenCV and `pirate_sm.robot.vision`.

A fisheye bends an angle θ to r = f θ (1 + k1 θ² + k2 θ⁴), a brown lens r = hypot(x/z, y/z) to
f r (1 + k1 r² + k2 r⁴).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SIZE = (480, 360)
COLUMNS, ROWS, SQUARE_M = 9, 6, 0.025
_FINER = 2


@dataclass(frozen=True)
class RenderedLens:
    """A lens that shows an angle along the width of its picture.

    Attributes:
        model: ``fisheye`` or ``brown``.
        across_deg: What it shows along the width.
        k: Its first two coefficients.
        board: Share of the picture's width that a board takes.
    """

    model: str
    across_deg: float
    k: tuple[float, float] = (0.0, 0.0)
    board: float = 0.27

    @property
    def focal_px(self) -> float:
        """Return the focal length."""
        half = np.radians(self.across_deg / 2)
        return float(SIZE[0] / 2 / self._bent(half if self.model == "fisheye" else np.tan(half)))

    def _bent(self, straight: Floats | float) -> Floats | float:
        return straight * (1 + self.k[0] * straight**2 + self.k[1] * straight**4)

    def rays(self, across: Floats, down: Floats) -> Floats:
        """Return unit directions of places in the picture, in px from its middle, (..., 3)."""
        radius = np.hypot(across, down) / self.focal_px
        table = np.linspace(0.0, 2.4 if self.model == "fisheye" else 12.0, 20000)
        rises = np.append(True, np.diff(self._bent(table)) > 0).cumprod().astype(bool)
        straight = np.interp(radius, self._bent(table)[rises], table[rises], right=np.nan)
        angle = straight if self.model == "fisheye" else np.arctan(straight)
        turn = np.arctan2(down, across)
        aside = np.sin(angle)
        return np.stack([aside * np.cos(turn), aside * np.sin(turn), np.cos(angle)], axis=-1)

    def pictures(self, count: int = 20) -> Iterator[NDArray[np.uint8]]:
        """Yield pictures of a board that is held into all parts of the picture and tilted."""
        width, height = SIZE
        fine = (np.arange(width * _FINER) + 0.5) / _FINER - width / 2
        fine_down = (np.arange(height * _FINER) + 0.5) / _FINER - height / 2
        rays = self.rays(*np.meshgrid(fine, fine_down)).astype(np.float32)
        for number in range(count):
            yield _seen(rays, *self._held(number))

    def _held(self, number: int) -> tuple[Floats, Floats]:
        """Return how a board is turned, and where its middle is, m."""
        chance = np.random.default_rng(number)
        across, down = (number % 5 / 2 - 1) * 0.68, (number // 5 / 1.5 - 1) * 0.62
        ray = self.rays(np.array(across * SIZE[0] / 2), np.array(down * SIZE[1] / 2))
        side = np.cross([0.0, 1.0, 0.0], ray)
        facing = np.column_stack([side / np.linalg.norm(side), np.zeros(3), ray])
        facing[:, 1] = np.cross(ray, facing[:, 0])
        aside = self.rays(
            np.array([1.0, 0.0]) + across * SIZE[0] / 2, np.array([0.0, 1.0]) + down * SIZE[1] / 2
        )
        px_per_rad = 1 / np.linalg.norm(aside - ray, axis=1).min()
        distance_m = SQUARE_M * 9 * px_per_rad / (self.board * SIZE[0])
        return facing @ _turned(chance.uniform(-0.5, 0.5, 3)), ray * distance_m


def _turned(angles: Floats) -> Floats:
    matrix = np.eye(3)
    for (one, other), angle in zip(((1, 2), (0, 2), (0, 1)), angles, strict=True):
        turn = np.eye(3)
        turn[[one, other], [one, other]] = np.cos(angle)
        turn[one, other], turn[other, one] = -np.sin(angle), np.sin(angle)
        matrix = matrix @ turn
    return matrix


def _seen(rays: Floats, turn: Floats, middle: Floats) -> NDArray[np.uint8]:
    local = rays @ turn.astype(np.float32)
    away = middle @ turn
    with np.errstate(divide="ignore", invalid="ignore"):
        share = away[2] / local[..., 2]
        u = (share * local[..., 0] - away[0]) / SQUARE_M
        v = (share * local[..., 1] - away[1]) / SQUARE_M
    white = (np.floor(u + (COLUMNS + 1) / 2) + np.floor(v + (ROWS + 1) / 2)) % 2 == 0
    on_squares = (np.abs(u) < (COLUMNS + 1) / 2) & (np.abs(v) < (ROWS + 1) / 2)
    on_paper = (np.abs(u) < (COLUMNS + 3) / 2) & (np.abs(v) < (ROWS + 3) / 2)
    value = np.where(on_squares & ~white, 35.0, np.where(on_paper, 215.0, 90.0))
    value = np.where(share > 0, value, 90.0)
    width, height = SIZE
    mean = value.reshape(height, _FINER, width, _FINER).mean(axis=(1, 3))
    return np.round(mean).astype(np.uint8)
