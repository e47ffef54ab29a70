"""Where the camera hangs over the setup, and where the rays of its pixels meet a plane there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pirate_sm.core.camera import CameraPose
from pirate_sm.robot.vision.lens import LensModel
from pirate_sm.robot.vision.opencv import cv2
from pirate_sm.robot.vision.picture_arrays import Floats

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
