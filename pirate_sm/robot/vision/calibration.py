"""Calibrate a camera: measure its lens by pictures of a chessboard, and find where it hangs.

The lens and the place of each board are fitted at once to the corners that are seen (bundle
adjustment). OpenCV's own `fisheye.calibrate` cuts rays with a plane ahead of the camera, so that it
fails on boards that reach 90 deg from the axis. This uses our model of the lens, which has no such
limit. Where the camera hangs follows from tags or points of the setup; what was measured wrongly
there is named.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Literal, NamedTuple

import numpy as np

from pirate_sm.core.errors import UsageError, not_installed
from pirate_sm.robot.camera import FEWEST_POINTS, Camera, CameraPose, FrameSize, Lens
from pirate_sm.robot.vision.opencv import Floats, Frame
from pirate_sm.robot.vision.projection import (
    LensModel,
    find_pose,
    find_view,
    first_pose,
    pose_errors,
    rms,
    rotation_of,
)
from pirate_sm.robot.vision.seeing import setup_tag_points
from pirate_sm.robot.vision.targets import Chessboard, find_tags, grayed

try:
    from scipy.optimize import least_squares
except ImportError:
    raise not_installed("calibrating a camera", "scipy", "vision") from None


# --- bundle adjustment ----------------------------------------------------------------------------


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


# --- the lens -------------------------------------------------------------------------------------


FEWEST_BOARDS = 15

LARGEST_RMS_OF_LENS_PX: dict[str, float] = {"fisheye": 0.5, "brown": 1.0}
"""What is refused. On synthetic boards of a lens of 180 deg Brown leaves 0.67 px, a fisheye 0.1."""

_LEAST_CELLS, _CELLS = 7, (3, 3)
_LEAST_TILT_DEG = 12.0

_LEAST_USED = 0.8
"""Share of the boards that the lens must fit; below it is the lens or its model that is wrong."""

_ROUNDS = 2
"""A board without a place in the first guess, or with its mirror image, finds it in the second."""

_FAR_OFF = 3.0
"""A board is left out that is off by more than this many times the median of all, and by more than
the largest rms: pictures in which the board was moved or bent, or its corners were mistaken."""


@dataclass(frozen=True)
class LensCalibration:
    """A measured lens.

    Attributes:
        lens: The lens.
        rms_px: How far the corners of the boards are from where they should be.
        left_out: The boards that were not used, by name, and how far each is off, px.
    """

    lens: Lens
    rms_px: float
    left_out: dict[str, float]


class _Placed(NamedTuple):
    """A board at its best place for a lens; ``rms_px`` is infinite if there is none."""

    pose: Floats
    rms_px: float


def calibrate(
    named: Mapping[str, Floats],
    board: Chessboard,
    size: FrameSize,
    model: Literal["fisheye", "brown"],
) -> LensCalibration | str:
    """Return the lens that fits the boards best, or why these boards are not enough.

    Args:
        named: The corners of the board in each picture, (N, 2) in px, by the picture's name.
        board: The board.
        size: Width and height of the pictures.
        model: The model of the lens.
    """
    boards = list(named.values())
    refusal = _refusal(boards, board, size)
    if refusal:
        return refusal
    lens, placed, used = _fitted_lens(boards, board, size, model)
    off_px = {name: each.rms_px for name, each in zip(named, placed, strict=True)}
    unseen = [name for name, each in off_px.items() if each == float("inf")]
    if unseen:
        return (
            f"the model {model} does not fit this lens: one of this model would not show the board"
            f" where it is seen in {', '.join(unseen)}"
        )
    limit_px = LARGEST_RMS_OF_LENS_PX[model]
    rms_px = float(np.sqrt(np.mean([placed[number].rms_px ** 2 for number in used])))
    if rms_px > limit_px:
        return (
            f"the corners are off by {rms_px:.2f} px (rms), more than {limit_px} px: is the board"
            " flat, the camera fixed in focus, and the model right?"
        )
    left_out = {name: px for n, (name, px) in enumerate(off_px.items()) if n not in used}
    refusal = _refusal([boards[number] for number in used], board, size)
    if refusal:
        return f"without {', '.join(left_out)}, whose corners fit no such lens, {refusal}"
    tilt_deg = _tilt_deg([placed[number].pose for number in used])
    if tilt_deg < _LEAST_TILT_DEG:
        return (
            f"all boards lie at nearly the same angle, within {tilt_deg:.0f} deg: tilt the board by"
            " 30 deg to each side, else focal length and distance cannot be separated"
        )
    return LensCalibration(lens.lens, rms_px, left_out)


def _fitted_lens(
    boards: Sequence[Floats], board: Chessboard, size: FrameSize, model: Literal["fisheye", "brown"]
) -> tuple[LensModel, list[_Placed], list[int]]:
    """Return the lens, each board's place in it, and the numbers of the boards that were used."""
    lens = guess_lens(model, boards, board.points, size)
    used = list(range(len(boards)))
    while True:
        for _ in range(_ROUNDS):
            lens, placed = _adjusted(lens, boards, board, used)
        off_px = np.array([placed[number].rms_px for number in used])
        far_px = max(LARGEST_RMS_OF_LENS_PX[model], _FAR_OFF * float(np.median(off_px)))
        off_px[np.isinf(off_px)] = 0.0  # a board that the lens cannot show speaks against the lens
        if off_px.max() <= far_px or len(used) <= _LEAST_USED * len(boards):
            return lens, placed, used
        used.pop(int(np.argmax(off_px)))  # one only: the others are off because of it


def _adjusted(
    lens: LensModel, boards: Sequence[Floats], board: Chessboard, used: Sequence[int]
) -> tuple[LensModel, list[_Placed]]:
    """Return a better lens, and the place of each board in it."""
    placed = _placed(lens, boards, board)
    begun = [number for number in used if np.isfinite(placed[number].rms_px)]
    if not begun:
        return lens, placed
    poses = [placed[number].pose for number in begun]
    better = adjust(lens, poses, board.points, [boards[number] for number in begun])
    return better, _placed(better, boards, board)


def _placed(lens: LensModel, boards: Sequence[Floats], board: Chessboard) -> list[_Placed]:
    found = []
    for pixels in boards:
        pose = find_pose(lens, board.points, pixels)
        if pose is None:
            found.append(_Placed(np.zeros(6), float("inf")))
            continue
        across, down = pose_errors(lens, pose, board.points, pixels).reshape(-1, 2).T
        found.append(_Placed(pose, rms(np.hypot(across, down))))
    return found


def _refusal(boards: Sequence[Floats], board: Chessboard, size: FrameSize) -> str:
    """Return why boards are not enough, before anything is computed; empty if they may be."""
    if len(boards) < FEWEST_BOARDS:
        return (
            f"{len(boards)} sharp boards of {board.inside[0]} × {board.inside[1]} corners were"
            f" found, at least {FEWEST_BOARDS} at different places are needed"
        )
    cells = (np.vstack(list(boards)) / np.array(size) * np.array(_CELLS)).astype(int)
    covered = len({(int(x), int(y)) for x, y in cells})
    if covered < _LEAST_CELLS:
        return (
            f"the boards cover {covered} of the 9 parts of the picture: hold the board into every"
            " corner, too, where the distortion is largest"
        )
    return ""


def _tilt_deg(poses: Sequence[Floats]) -> float:
    """Return the largest angle between a board and the mean of all, deg."""
    normals = np.array([rotation_of(pose[:3])[:, 2] for pose in poses])
    normals *= np.sign(normals[:, 2:])
    mean = normals.mean(axis=0)
    return float(np.degrees(np.arccos(np.clip(normals @ mean / np.linalg.norm(mean), -1, 1))).max())


# --- the place ------------------------------------------------------------------------------------


LARGEST_RMS_OF_PLACE_PX = 3.0
"""A tag that is 20 mm off makes 4.5 px, two exchanged ones 263 px, tags right to 1 mm below 1."""

_MUCH_BETTER = 0.4
_FLATTEST = 0.1


@dataclass(frozen=True)
class KnownPlace:
    """A tag or a point of the setup.

    Attributes:
        points: Where its corners are, (N, 3) in m; of a point there is one.
        pixels: Where they are seen, (N, 2) in px.
    """

    points: Floats
    pixels: Floats


@dataclass(frozen=True)
class Survey:
    """Where the camera hangs.

    Attributes:
        pose: Its place and rotation.
        rms_px: How far the known places are from where they should be, root mean square.
        each_px: The same for each of them.
    """

    pose: CameraPose
    rms_px: float
    each_px: Mapping[str, float]


def known_points(camera: Camera) -> dict[str, KnownPlace]:
    """Return the points of a camera's file."""
    return {
        f"point {number}": KnownPlace(np.array([point.at]), np.array([point.seen]))
        for number, point in enumerate(camera.setup.points, start=1)
    }


def known_tags(camera: Camera, frame: Frame) -> dict[str, KnownPlace]:
    """Return the tags of the setup that a frame shows.

    Raises:
        UsageError: It shows some of them more than once; the message names them.
    """
    setup = camera.setup
    found = find_tags(grayed(frame), setup.tags) if setup.tags else []
    tags = [tag for tag in found if str(tag.number) in setup.at]
    count = Counter(tag.number for tag in tags)
    if twice := ", ".join(f"tag {number}" for number in count if count[number] > 1):
        raise UsageError(f"the picture shows {twice} more than once: cover all but the right one")
    return {
        f"tag {tag.number}": KnownPlace(setup_tag_points(camera, str(tag.number)), tag.corners)
        for tag in tags
    }


def survey(lens: LensModel, known: Mapping[str, KnownPlace]) -> Survey | str:
    """Return where the camera hangs, or why these places are not enough."""
    if len(known) < FEWEST_POINTS:
        seen = ", ".join(known) or "nothing"
        return f"of the setup's known places {seen} is seen: at least {FEWEST_POINTS} are needed"
    if _in_a_line(np.vstack([each.points for each in known.values()])):
        return "the known places lie nearly in a line: the camera could hang anywhere around it"
    found = _fitted_place(lens, known)
    if found is not None and found.rms_px <= LARGEST_RMS_OF_PLACE_PX:
        return found
    off_px = float("inf") if found is None else found.rms_px
    said = "fit no place of the camera"
    if np.isfinite(off_px):
        said = f"are off by {off_px:.1f} px (rms), more than {LARGEST_RMS_OF_PLACE_PX:g} px"
    return f"the known places {said}: {_cause(lens, known, off_px)}"


def _in_a_line(points: Floats) -> bool:
    """Return whether points are spread less than a tenth as far across as along."""
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[1] < _FLATTEST * spread[0])


def _fitted_place(lens: LensModel, known: Mapping[str, KnownPlace]) -> Survey | None:
    points = np.vstack([each.points for each in known.values()])
    view = find_view(lens, points, np.vstack([each.pixels for each in known.values()]))
    if view is None:
        return None
    residuals = {n: view.residuals(each.points, each.pixels) for n, each in known.items()}
    each_px = {name: rms(each) for name, each in residuals.items()}
    return Survey(view.pose, rms(np.concatenate(list(residuals.values()))), each_px)


def _cause(lens: LensModel, known: Mapping[str, KnownPlace], off_px: float) -> str:
    """Return what most likely is wrong, by trying: two exchanged, or one measured wrongly."""
    exchanged = {
        (one, other): _rms(lens, _exchange(known, one, other))
        for one, other in combinations(known, 2)
    }
    (one, other), best_px = min(exchanged.items(), key=lambda item: item[1])
    if best_px <= LARGEST_RMS_OF_PLACE_PX and best_px < _MUCH_BETTER * off_px:
        return f"{one} and {other} are exchanged (with them the other way round {best_px:.1f} px)"
    if len(known) > FEWEST_POINTS:
        without = {
            name: _rms(lens, {n: each for n, each in known.items() if n != name}) for name in known
        }
        name, best_px = min(without.items(), key=lambda item: item[1])
        if best_px < _MUCH_BETTER * off_px:
            return f"measure {name} again (without it {best_px:.1f} px)"
    return "measure them again, and calibrate the lens if that has not been done for this size"


def _rms(lens: LensModel, known: Mapping[str, KnownPlace]) -> float:
    found = _fitted_place(lens, known)
    return float("inf") if found is None else found.rms_px


def _exchange(known: Mapping[str, KnownPlace], one: str, other: str) -> dict[str, KnownPlace]:
    """Return the places as if these two had been exchanged on the setup."""
    changed = dict(known)
    changed[one] = KnownPlace(known[other].points, known[one].pixels)
    changed[other] = KnownPlace(known[one].points, known[other].pixels)
    return changed
