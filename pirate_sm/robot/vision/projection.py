"""From places over the setup to pixels and back: the lens, and a plane below the camera.

A direction is a ray from the camera: x to the right in the picture, y down, z ahead. The functions
of cv2.fisheye divide by z, so that they know no directions of 90 deg and more from the axis, which
lenses of 180 deg have; up to there the results are the same.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pirate_sm.robot.camera import CameraPose, FrameSize, Lens
from pirate_sm.robot.vision.opencv import Flags, Floats, Frame, cv2

# --- the lens -------------------------------------------------------------------------------------


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


# --- the plane ------------------------------------------------------------------------------------


_SWINGS = 20
"""Steps of the refinement; it converges in four to six."""


@dataclass(frozen=True)
class View:
    """A lens at its place over the setup.

    Attributes:
        lens: The lens.
        pose: Its place and its rotation.
    """

    lens: LensModel
    pose: CameraPose

    @cached_property
    def place(self) -> Floats:
        """Return where the camera is over the setup, (3,) in m."""
        return np.array(self.pose.at)

    @cached_property
    def rotation(self) -> Floats:
        """Return the matrix from the axes of the setup to those of the camera."""
        return rotation_of(np.array(self.pose.turn))

    def project(self, points: Floats) -> Floats:
        """Return where points of the setup, (N, 3) in m, are in the picture, (N, 2) in px.

        NaN for what the lens cannot see.
        """
        return self.lens.project((points - self.place) @ self.rotation.T)

    def on_plane(self, pixels: Floats, height_m: float) -> Floats:
        """Return where the rays of pixels meet the plane of this height, (N, 2) in m.

        NaN for rays that do not meet it.
        """
        return self.cut(self.lens.rays(pixels), height_m)

    def cut(self, rays: Floats, height_m: float) -> Floats:
        """Return where rays in the camera's axes meet the plane of this height, (N, 2) in m."""
        ahead = rays @ self.rotation  # the inverse of a rotation is its transpose
        down_m = height_m - self.pose.at[2]
        with np.errstate(divide="ignore", invalid="ignore"):
            share = down_m / ahead[:, 2]
        share[np.logical_not(share > 0)] = np.nan
        places: Floats = self.place[:2] + ahead[:, :2] * share[:, None]
        return places

    def residuals(self, points: Floats, pixels: Floats) -> Floats:
        """Return how far known points are from where they should be in the picture, (N,) in px."""
        across, down = (self.project(points) - pixels).T
        distances: Floats = np.hypot(across, down)
        return distances

    def scale(self, places: Floats, height_m: float) -> Floats:
        """Return how many pixels a metre has at places of a plane, (N,): the root of the area."""
        step_m = 1e-3
        ends = [
            self.project(raised(places + np.array(step), height_m))
            for step in ((step_m, 0.0), (-step_m, 0.0), (0.0, step_m), (0.0, -step_m))
        ]
        (ax, ay), (bx, by) = ((ends[0] - ends[1]).T, (ends[2] - ends[3]).T)
        scales: Floats = np.sqrt(np.abs(ax * by - ay * bx)) / (2 * step_m)
        return scales


def raised(places: Floats, height_m: float) -> Floats:
    """Return places of a plane as points of the setup, (N, 3)."""
    return np.column_stack([places, np.full(len(places), height_m)])


def rotation_of(turn: Floats) -> Floats:
    """Return the matrix of a rotation that is given by its axis, as long as its angle in rad."""
    matrix: Floats = cv2.Rodrigues(turn.reshape(3, 1))[0]
    return matrix


def turn_of(rotation: Floats) -> Floats:
    """Return the axis of a rotation, as long as its angle in rad."""
    turn: Floats = cv2.Rodrigues(rotation)[0].ravel()
    return turn


def rms(residuals: Floats) -> float:
    """Return the root mean square of residuals; infinite if a point is not seen at all."""
    mean = float(np.mean(residuals**2)) if len(residuals) else np.nan
    return float(np.sqrt(mean)) if np.isfinite(mean) else float("inf")


def find_view(lens: LensModel, points: Floats, pixels: Floats) -> View | None:
    """Return the view that fits known points best; None if there is none.

    Args:
        lens: The lens.
        points: (N, 3) on the setup, m; at least four, better at several heights.
        pixels: (N, 2) where they are seen.
    """
    pose = find_pose(lens, points, pixels)
    return None if pose is None else View(lens, _pose(pose))


def find_pose(lens: LensModel, points: Floats, pixels: Floats) -> Floats | None:
    """Return rotation and translation of known points, (6,), that fit best; None if none do.

    The rays of the pixels are exact for any lens, so OpenCV's solution for flat pictures begins,
    and Gauss-Newton steps make the error in the picture itself as small as possible.
    """
    pose = first_pose(lens, points, pixels)
    if pose is None:
        return None
    for _ in range(_SWINGS):
        errors = pose_errors(lens, pose, points, pixels)
        if not np.all(np.isfinite(errors)):
            return None
        step = np.linalg.lstsq(_slopes(lens, pose, points, pixels), -errors, rcond=None)[0]
        pose = pose + step
        if np.abs(step).max() < 1e-10:
            break
    return pose


def first_pose(lens: LensModel, points: Floats, pixels: Floats) -> Floats | None:
    """Return rotation and translation of points, (6,), near those that fit best; None if none do.

    A flat picture ends before 90 deg, so it is taken along the mean of the rays, wherever they go.
    """
    rays = lens.rays(pixels)
    rays, points = rays[known := np.isfinite(rays).all(axis=1)], points[known]
    along = _facing(rays.mean(axis=0)) if len(rays) else np.eye(3)
    rays = rays @ along.T
    ahead = rays[:, 2] > 0.05
    if ahead.sum() < 4:
        return None
    flat = rays[ahead, :2] / rays[ahead, 2:]
    try:
        found, turn, shift = cv2.solvePnP(
            points[ahead], flat, np.eye(3), None, flags=cv2.SOLVEPNP_SQPNP
        )
    except cv2.error:  # all in one place or on one line
        return None
    if not found:
        return None
    return np.concatenate([turn_of(along.T @ rotation_of(turn)), along.T @ shift.ravel()])


def _facing(ray: Floats) -> Floats:
    """Return the matrix from the camera's axes to those of which z is along a ray."""
    ahead = ray / np.linalg.norm(ray)
    side = np.cross(np.eye(3)[np.argmin(np.abs(ahead))], ahead)
    side /= np.linalg.norm(side)
    return np.array([side, np.cross(ahead, side), ahead])


def pose_errors(lens: LensModel, pose: Floats, points: Floats, pixels: Floats) -> Floats:
    """Return the errors of points at a pose in the picture, (2 N,) in px; NaN where not seen."""
    seen = lens.project(points @ rotation_of(pose[:3]).T + pose[3:])
    errors: Floats = (seen - pixels).ravel()
    return errors


def _slopes(lens: LensModel, pose: Floats, points: Floats, pixels: Floats) -> Floats:
    """Return the derivatives of the errors, (2 N, 6), by central differences."""
    columns = []
    for number in range(6):
        step = np.zeros(6)
        step[number] = 1e-6
        above = pose_errors(lens, pose + step, points, pixels)
        below = pose_errors(lens, pose - step, points, pixels)
        columns.append((above - below) / 2e-6)
    return np.column_stack(columns)


def _pose(pose: Floats) -> CameraPose:
    at = -rotation_of(pose[:3]).T @ pose[3:]
    x, y, z = (float(each) for each in at)
    a, b, c = (float(each) for each in pose[:3])
    return CameraPose(at=(x, y, z), turn=(a, b, c))
