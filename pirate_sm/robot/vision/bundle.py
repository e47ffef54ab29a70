"""Fit a lens and the place of each board at once, to corners that are seen (bundle adjustment).

OpenCV's own `fisheye.calibrate` cuts rays with a plane ahead of the camera, so that it fails on
boards that reach 90 deg from the axis. This uses our model of the lens, which has no such limit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np

from pirate_sm.core.camera import FrameSize, Lens
from pirate_sm.core.errors import not_installed
from pirate_sm.robot.vision.lens import LensModel
from pirate_sm.robot.vision.picture_arrays import Floats
from pirate_sm.robot.vision.plane import first_pose, pose_errors, rms, rotation_of

try:
    from scipy.optimize import least_squares
except ImportError:
    raise not_installed("calibrating a camera", "scipy", "vision") from None

_GUESSES = 0.15 * 1.15 ** np.arange(24)
"""Focal lengths that are tried first, as shares of the width: of lenses of 380 to 14 deg."""

_COEFFICIENTS = {"fisheye": 4, "brown": 5}
_LENS = 4  # focal lengths and centre, before the coefficients
_MOST_STEPS = 100
_ENOUGH = 1e-8
"""A step that lessens the sum of squares by less than this share is the last one."""


def guess_lens(
    model: Literal["fisheye", "brown"], boards: Sequence[Floats], points: Floats, size: FrameSize
) -> LensModel:
    """Return the lens without distortion in which the boards look flattest.

    Args:
        model: The model of the lens.
        boards: The corners of the board in each picture, (N, 2) in px.
        points: The same corners on the board, (N, 3) in m.
        size: Width and height of the pictures.
    """
    middle = (size[0] / 2, size[1] / 2)
    tried = [
        LensModel(Lens(model=model, f=(f, f), centre=middle, k=(0.0,) * _COEFFICIENTS[model]))
        for f in (size[0] * _GUESSES).tolist()
    ]
    return min(tried, key=lambda lens: np.median([_roughly(lens, points, b) for b in boards]))


def _roughly(lens: LensModel, points: Floats, pixels: Floats) -> float:
    pose = first_pose(lens, points, pixels)
    return float("inf") if pose is None else rms(pose_errors(lens, pose, points, pixels))


def adjust(
    lens: LensModel, poses: Sequence[Floats], points: Floats, boards: Sequence[Floats]
) -> LensModel:
    """Return the lens near ``lens`` for which all corners are least far from where they are seen.

    Args:
        lens: Where to begin.
        poses: Rotation and translation of each board, (6,), where to begin.
        points: The corners on the board, (N, 3) in m.
        boards: The corners in each picture, (N, 2) in px.
    """
    seen = np.array(boards)

    def errors(at: Floats) -> Floats:
        return _errors(lens, at, points, seen)

    at = np.concatenate([lens.lens.f, lens.lens.centre, lens.lens.k, *poses])
    found = least_squares(
        lambda at: errors(at).ravel(),
        at,
        jac=lambda at: _slopes(errors, at, len(poses)),
        x_scale="jac",
        ftol=_ENOUGH,
        max_nfev=_MOST_STEPS,
    )
    return _lens(lens, found.x)


def _lens(lens: LensModel, at: Floats) -> LensModel:
    fx, fy, cx, cy, *k = at[: _LENS + len(lens.lens.k)].tolist()
    numbers = {"f": (fx, fy), "centre": (cx, cy), "k": tuple(k)}
    return LensModel(lens.lens.model_copy(update=numbers))


def _errors(lens: LensModel, at: Floats, points: Floats, seen: Floats) -> Floats:
    """Return the errors of all corners, (boards, 2 N) in px."""
    poses = at[_LENS + len(lens.lens.k) :].reshape(-1, 6)
    places = [points @ rotation_of(pose[:3]).T + pose[3:] for pose in poses]
    errors: Floats = _lens(lens, at).project(np.concatenate(places)).reshape(seen.shape) - seen
    return errors.reshape(len(seen), -1)


def _slopes(errors: Callable[[Floats], Floats], at: Floats, boards: int) -> Floats:
    """Return the derivatives of all errors by central differences.

    A board's pose moves its own corners only, so one difference serves the same number of the poses
    of all boards.
    """
    shared = len(at) - 6 * boards
    slopes = np.zeros((*errors(at).shape, len(at)))
    for number in range(shared + 6):
        of_poses = number >= shared
        places = np.arange(number, len(at), 6) if of_poses else np.array([number])
        step = np.zeros(len(at))
        step[places] = 1e-6 * max(1.0, np.abs(at[places]).max())
        change = (errors(at + step) - errors(at - step)) / (2 * step[places[0]])
        if of_poses:
            slopes[np.arange(boards), :, places] = change
        else:
            slopes[:, :, number] = change
    # A corner that is not seen from where a difference looks moves nothing.
    return np.nan_to_num(slopes.reshape(-1, len(at)))
