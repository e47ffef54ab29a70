"""Find where the camera hangs, by tags or points of the setup; name what was measured wrongly."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from pirate_sm.core.camera import FEWEST_POINTS, Camera, CameraPose
from pirate_sm.core.errors import UsageError
from pirate_sm.robot.vision.lens import LensModel
from pirate_sm.robot.vision.picture_arrays import Floats, Frame
from pirate_sm.robot.vision.plane import find_view, rms
from pirate_sm.robot.vision.seeing import setup_tag_points
from pirate_sm.robot.vision.tags import find_tags, grayed

LARGEST_RMS_PX = 3.0
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
    found = _fitted(lens, known)
    if found is not None and found.rms_px <= LARGEST_RMS_PX:
        return found
    off_px = float("inf") if found is None else found.rms_px
    said = "fit no place of the camera"
    if np.isfinite(off_px):
        said = f"are off by {off_px:.1f} px (rms), more than {LARGEST_RMS_PX:g} px"
    return f"the known places {said}: {_cause(lens, known, off_px)}"


def _in_a_line(points: Floats) -> bool:
    """Return whether points are spread less than a tenth as far across as along."""
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[1] < _FLATTEST * spread[0])


def _fitted(lens: LensModel, known: Mapping[str, KnownPlace]) -> Survey | None:
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
    if best_px <= LARGEST_RMS_PX and best_px < _MUCH_BETTER * off_px:
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
    found = _fitted(lens, known)
    return float("inf") if found is None else found.rms_px


def _exchange(known: Mapping[str, KnownPlace], one: str, other: str) -> dict[str, KnownPlace]:
    """Return the places as if these two had been exchanged on the setup."""
    changed = dict(known)
    changed[one] = KnownPlace(known[other].points, known[one].pixels)
    changed[other] = KnownPlace(known[one].points, known[other].pixels)
    return changed
