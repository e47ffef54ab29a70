"""Square tags: their pictures, their corners, and finding them in frames."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final

import numpy as np

from pirate_sm.core.camera import TagFamily
from pirate_sm.robot.vision.opencv import cv2
from pirate_sm.robot.vision.picture_arrays import Floats, Frame, Gray

_DICTIONARIES: Final[Mapping[TagFamily, int]] = {
    "aruco_4x4_50": cv2.aruco.DICT_4X4_50,
    "apriltag_36h11": cv2.aruco.DICT_APRILTAG_36h11,
}
_NEAR_PX = 40
_BORDER = 1  # black cells around the code


@dataclass(frozen=True)
class FoundTag:
    """A tag in a frame.

    Attributes:
        number: Its number in its family.
        corners: (4, 2) px: upper left, upper right, lower right, lower left of the tag.
    """

    number: int
    corners: Floats


def tag_cells(family: TagFamily, number: int) -> Gray:
    """Return a tag as one pixel for each cell, 0 or 255, with its black border."""
    cells = _dictionary(family).markerSize + 2 * _BORDER
    picture: Gray = cv2.aruco.generateImageMarker(_dictionary(family), number, cells, None, _BORDER)
    return picture


def tag_corners(middle: tuple[float, float], heading_rad: float, size_m: float) -> Floats:
    """Return the corners of a tag in its plane, (4, 2), in the order of :class:`FoundTag`.

    Args:
        middle: Its middle.
        heading_rad: Direction of its upper edge from its middle, from x to y.
        size_m: Length of its sides.
    """
    ahead = np.array([np.cos(heading_rad), np.sin(heading_rad)]) * size_m / 2
    left = np.array([-ahead[1], ahead[0]])
    return np.array(middle) + np.array([ahead + left, ahead - left, -ahead - left, left - ahead])


def find_tags(gray: Gray, family: TagFamily) -> list[FoundTag]:
    """Return the tags of a family in a frame, in the order of their numbers."""
    corners, numbers, _ = _detector(family).detectMarkers(gray)
    if numbers is None:
        return []
    found = [
        FoundTag(int(number), each.reshape(4, 2).astype(np.float64))
        for number, each in zip(numbers.ravel(), corners, strict=True)
    ]
    return sorted(found, key=lambda tag: tag.number)


def find_tag_near(frame: Frame, family: TagFamily, number: int, corners: Floats) -> FoundTag | None:
    """Return a tag that is near its expected corners, (4, 2) px; None if it is not there.

    It takes a hundredth of the time of searching the whole picture.
    """
    if not np.all(np.isfinite(corners)):
        return None
    left, top = np.maximum(np.floor(corners.min(axis=0)).astype(int) - _NEAR_PX, 0)
    right, bottom = np.maximum(np.ceil(corners.max(axis=0)).astype(int) + _NEAR_PX, 0)
    part = frame[top:bottom, left:right]
    if min(part.shape[:2]) < _NEAR_PX:
        return None
    found = (tag for tag in find_tags(grayed(part), family) if tag.number == number)
    tag = next(found, None)
    return tag and FoundTag(number, tag.corners + np.array([left, top]))


def grayed(frame: Frame) -> Gray:
    """Return a frame without its colours."""
    gray: Gray = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
    return gray


@lru_cache
def _dictionary(family: TagFamily) -> Any:
    return cv2.aruco.getPredefinedDictionary(_DICTIONARIES[family])


@lru_cache
def _detector(family: TagFamily) -> Any:
    parameters = cv2.aruco.DetectorParameters()
    parameters.adaptiveThreshWinSizeMin = 7
    parameters.adaptiveThreshWinSizeMax = 23
    parameters.adaptiveThreshWinSizeStep = 16
    parameters.minMarkerPerimeterRate = 0.015  # of 1920 px: sides of 7 px
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    parameters.cornerRefinementWinSize = 5
    parameters.relativeCornerRefinmentWinSize = 0.5
    return cv2.aruco.ArucoDetector(_dictionary(family), parameters)
