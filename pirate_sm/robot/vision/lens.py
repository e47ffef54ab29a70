"""The lens: from directions in space to pixels and back.

A direction is a ray from the camera: x to the right in the picture, y down, z ahead. The functions
of cv2.fisheye divide by z, so that they know no directions of 90 deg and more from the axis, which
lenses of 180 deg have; up to there the results are the same.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pirate_sm.core.camera import FrameSize, Lens
from pirate_sm.robot.vision.opencv import cv2
from pirate_sm.robot.vision.picture_arrays import Flags, Floats, Frame

_TABLE = 8192
"""Angles in the table of a fisheye: between them it is right to 1e-8, after one step to 1e-15."""


@dataclass(frozen=True)
class LensModel:
    """A lens with the numbers of its calibration.

    Attributes:
        lens: Its model and its numbers.
    """

    lens: Lens

    @cached_property
    def matrix(self) -> Floats:
        """Return the camera matrix K (thesis eq. C-2)."""
        (fx, fy), (cx, cy) = self.lens.f, self.lens.centre
        return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])

    @cached_property
    def _focal(self) -> Floats:
        return np.array(self.lens.f)

    @cached_property
    def _centre(self) -> Floats:
        return np.array(self.lens.centre)

    @cached_property
    def coefficients(self) -> Floats:
        """Return the coefficients of the distortion."""
        return np.array(self.lens.k, dtype=np.float64)

    def project(self, points: Floats) -> Floats:
        """Return where points are in the picture, px.

        Args:
            points: (N, 3) in the camera's axes, m.

        Returns:
            (N, 2); NaN for points that the lens cannot see: behind the picture of a brown lens, or
            where the polynomial of a fisheye folds back.
        """
        if self.lens.model == "fisheye":
            distorted, seen = _bent_by_fisheye(points, self.coefficients)
        else:
            distorted, seen = _bent_by_brown(points, self.coefficients)
        pixels = distorted * self._focal + self._centre
        pixels[np.logical_not(seen)] = np.nan
        return pixels

    def rays(self, pixels: Floats) -> Floats:
        """Return the unit directions in which pixels look, (N, 3); NaN where there is none."""
        pixels = np.asarray(pixels, dtype=np.float64).reshape(-1, 2)
        flat = (pixels - self._centre) / self._focal
        if self.lens.model == "fisheye":
            return _straight_from_fisheye(flat, self.coefficients, *self._angles)
        return _straight_from_brown(pixels, self.matrix, self.coefficients)

    @cached_property
    def _angles(self) -> tuple[Floats, Floats]:
        """Return radii in a fisheye's picture and their angles, up to where the lens folds back."""
        angles = np.linspace(0.0, np.pi, _TABLE)
        radii, slopes = _polynomial(angles, self.coefficients)
        count = int(np.argmin(slopes > 0)) or _TABLE
        return radii[:count], angles[:count]


@dataclass(frozen=True)
class UndistortedView:
    """A picture without distortion, as the finders of the thesis want it (section 5-4).

    Attributes:
        model: The lens.
        size: Width and height of the pictures.
    """

    model: LensModel
    size: FrameSize

    @cached_property
    def matrix(self) -> Floats:
        """Return the camera matrix of the view: it shows 62 deg to either side.

        A flat picture of the whole of a fisheye would be infinitely wide.
        """
        width, height = self.size
        focal = 0.5 * width / np.tan(np.radians(62.0))
        return np.array([[focal, 0.0, width / 2], [0.0, focal, height / 2], [0.0, 0.0, 1.0]])

    @cached_property
    def _maps(self) -> tuple[Frame, Frame]:
        model = self.model
        make: Callable[..., tuple[Frame, Frame]] = (
            cv2.fisheye.initUndistortRectifyMap
            if model.lens.model == "fisheye"
            else cv2.initUndistortRectifyMap
        )
        return make(
            model.matrix, model.coefficients, np.eye(3), self.matrix, self.size, cv2.CV_16SC2
        )

    def of(self, frame: Frame) -> Frame:
        """Return the picture without distortion."""
        undistorted: Frame = cv2.remap(frame, *self._maps, cv2.INTER_LINEAR)
        return undistorted

    def rays(self, pixels: Floats) -> Floats:
        """Return the unit directions in which pixels of this view look, (N, 3)."""
        return _unit(_homogeneous(pixels) @ np.linalg.inv(self.matrix).T)


def _homogeneous(points: Floats) -> Floats:
    return np.column_stack([points, np.ones(len(points))])


def _unit(rays: Floats) -> Floats:
    length: Floats = np.linalg.norm(rays, axis=1, keepdims=True)
    unit: Floats = rays / length
    return unit


def _polynomial(angle: Floats, k: Floats) -> tuple[Floats, Floats]:
    """Return the radius of an angle in a fisheye's picture, and its derivative.

    r = θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸), as cv2.fisheye.
    """
    s = angle * angle
    radius = angle * (1 + s * (k[0] + s * (k[1] + s * (k[2] + s * k[3]))))
    slope = 1 + s * (3 * k[0] + s * (5 * k[1] + s * (7 * k[2] + s * 9 * k[3])))
    return radius, slope


def _bent_by_fisheye(points: Floats, k: Floats) -> tuple[Floats, Flags]:
    across = np.hypot(points[:, 0], points[:, 1])
    angle = np.arctan2(across, points[:, 2])
    radius, slope = _polynomial(angle, k)
    share = np.divide(radius, across, out=np.ones_like(radius), where=across > 1e-12)
    return points[:, :2] * share[:, None], slope > 0


def _straight_from_fisheye(flat: Floats, k: Floats, radii: Floats, angles: Floats) -> Floats:
    radius = np.hypot(flat[:, 0], flat[:, 1])
    angle = np.interp(radius, radii, angles, right=np.nan)
    reached, slope = _polynomial(angle, k)
    angle -= (reached - radius) / slope  # one step of Newton's method
    share = np.divide(np.sin(angle), radius, out=np.ones_like(radius), where=radius > 1e-12)
    return np.column_stack([flat * share[:, None], np.cos(angle)])


def _bent_by_brown(points: Floats, k: Floats) -> tuple[Floats, Flags]:
    """Return the picture of points by thesis eq. C-3, with its misprint corrected.

    x″ = x (1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 x y + p2 (r² + 2 x²), and
    y″ = y (1 + …) + p1 (r² + 2 y²) + 2 p2 x y. The thesis has r² + 2y in the last line.
    """
    seen = points[:, 2] > 0
    x, y = (points[:, :2] / np.where(seen, points[:, 2], 1.0)[:, None]).T
    k1, k2, p1, p2, k3 = k
    s = x * x + y * y
    radial = 1 + s * (k1 + s * (k2 + s * k3))
    bent_x = x * radial + 2 * p1 * x * y + p2 * (s + 2 * x * x)
    bent_y = y * radial + p1 * (s + 2 * y * y) + 2 * p2 * x * y
    folds = 1 + s * (3 * k1 + s * (5 * k2 + s * 7 * k3)) <= 0
    return np.column_stack([bent_x, bent_y]), seen & ~folds


def _straight_from_brown(pixels: Floats, matrix: Floats, k: Floats) -> Floats:
    criteria = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 100, 1e-9)
    flat = cv2.undistortPoints(pixels.reshape(-1, 1, 2), matrix, k, criteria=criteria)
    return _unit(_homogeneous(flat.reshape(-1, 2)))
