"""Find a round marker by its colour.

Three finders: ``components`` labels the picture as it is and corrects the distortion of the found
points alone; ``blob`` and ``hough`` work on the picture without distortion, as the thesis does
(section 5-4: threshold of hue, saturation and value, Gaussian blur, then SimpleBlobDetector or
HoughCircles).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pirate_sm.core.camera import FrameSize, Marker
from pirate_sm.robot.vision.lens import UndistortedView
from pirate_sm.robot.vision.opencv import cv2
from pirate_sm.robot.vision.picture_arrays import Floats, Frame, Gray
from pirate_sm.robot.vision.plane import View, raised

WINDOW_PX = 60
"""Half the side of the window around the last place: 0.1 m/s and 1 px/mm are 50 px in 0.5 s."""

_SMALLEST, _LARGEST = 0.5, 1.6
"""Of a marker's diameter, what is taken for it: a part of it may be covered."""

_EDGES = np.array([(0.0, 0.0), (-0.5, 0.0), (0.5, 0.0), (0.0, -0.5), (0.0, 0.5)])
"""The middle of a disc and its edges, in diameters."""

_NOTHING = np.empty((0, 3))


@dataclass(frozen=True)
class MarkerFinder:
    """Finds one marker over the setup.

    Attributes:
        marker: The marker.
        view: The camera's lens and place.
        size: Width and height of the pictures.
    """

    marker: Marker
    view: View
    size: FrameSize

    def places(self, frame: Frame, near: tuple[float, float] | None = None) -> Floats:
        """Return the places of what may be the marker in its plane, (N, 2) in m, best first.

        Args:
            frame: The picture.
            near: The last place, m: what is nearest to it is best, and ``components`` searches
                around it only.
        """
        if self.marker.finder == "components":
            return self._everywhere(frame) if near is None else self._around(frame, near)
        mask = self._mask(self._flat.of(frame))
        width = int(self.marker.blur) | 1  # OpenCV wants an odd number
        blurred = cv2.GaussianBlur(mask, (width, width), 0)
        spots = _blobs(blurred) if self.marker.finder == "blob" else _circles(blurred)
        return self._fitting(spots, self._flat.rays, near)

    @cached_property
    def _flat(self) -> UndistortedView:
        return UndistortedView(self.view.lens, self.size)

    def _everywhere(self, frame: Frame) -> Floats:
        """Return the places that fit in every second pixel; the best one from all pixels."""
        small = cv2.resize(frame, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_NEAREST)
        spots = 2 * _components(self._mask(small))
        places = self._fitting(spots, self.view.lens.rays, None)
        if len(places):
            x, y = places[0]
            places[:1] = self._around(frame, (float(x), float(y)))[:1]
        return places

    def _around(self, frame: Frame, near: tuple[float, float]) -> Floats:
        """Return the places that fit in a window around a place."""
        at = self.view.project(raised(np.array([near]), self.marker.height))[0]
        if not np.all(np.isfinite(at)):
            return np.empty((0, 2))
        left, top = (max(int(each) - WINDOW_PX, 0) for each in at)
        right, bottom = (max(int(each) + WINDOW_PX, 0) for each in at)
        part = frame[top:bottom, left:right]
        spots = _components(self._mask(part)) if part.size else _NOTHING.copy()
        spots[:, :2] += (left, top)
        return self._fitting(spots, self.view.lens.rays, near)

    def _mask(self, frame: Frame) -> Gray:
        """Return where the colour of a picture is that of the marker: 0 or 255."""
        hsv = cv2.cvtColor(frame, cv2.COLOR_BGR2HSV)
        low, high = self.marker.hsv
        if low[0] <= high[0]:
            within: Gray = cv2.inRange(hsv, low, high)
            return within
        above = cv2.inRange(hsv, low, (179, *high[1:]))
        below = cv2.inRange(hsv, (0, *low[1:]), high)
        both: Gray = cv2.bitwise_or(above, below)
        return both

    def _fitting(
        self, spots: Floats, rays: Callable[[Floats], Floats], near: tuple[float, float] | None
    ) -> Floats:
        """Return the places of spots that have the size of the marker in its plane, best first.

        Args:
            spots: (N, 3): middle and diameter, px.
            rays: Returns the directions of pixels.
            near: The last place, m.
        """
        edges = spots[:, None, :2] + _EDGES * spots[:, None, 2:]
        places = self.view.cut(rays(edges.reshape(-1, 2)), self.marker.height).reshape(-1, 5, 2)
        across = np.linalg.norm(places[:, 2] - places[:, 1], axis=1)
        down = np.linalg.norm(places[:, 4] - places[:, 3], axis=1)
        ratio = np.nan_to_num(np.sqrt(across * down) / self.marker.size)
        fits = (ratio > _SMALLEST) & (ratio < _LARGEST)
        middles, ratio = places[fits, 0], ratio[fits]
        if near is None:
            return middles[np.argsort(np.abs(np.log(ratio)))]
        return middles[np.argsort(np.linalg.norm(middles - np.array(near), axis=1))]


def _components(mask: Gray) -> Floats:
    """Return middle and diameter of the connected parts of a mask, (N, 3), px."""
    _, _, stats, middles = cv2.connectedComponentsWithStats(mask, connectivity=8)
    areas = stats[1:, cv2.CC_STAT_AREA].astype(np.float64)  # the first one is the background
    large = areas >= 12  # less is noise
    diameters = np.sqrt(areas * 4 / np.pi)
    return np.column_stack([middles[1:], diameters])[large]


def _blobs(mask: Gray) -> Floats:
    """Return middle and diameter of the bright spots that are round and filled, (N, 3), px."""
    parameters = cv2.SimpleBlobDetector_Params()
    parameters.filterByColor, parameters.blobColor = True, 255
    parameters.filterByArea, parameters.minArea, parameters.maxArea = True, 12.0, 1e5
    parameters.filterByCircularity, parameters.minCircularity = True, 0.6
    parameters.filterByConvexity, parameters.minConvexity = True, 0.8
    parameters.filterByInertia = False
    parameters.minThreshold, parameters.maxThreshold, parameters.thresholdStep = 100, 160, 50
    parameters.minRepeatability = 1
    found = cv2.SimpleBlobDetector_create(parameters).detect(mask)
    return np.array([(*each.pt, each.size) for each in found]).reshape(-1, 3)


def _circles(mask: Gray) -> Floats:
    """Return middle and diameter of circles by the Hough transform, (N, 3), px."""
    found = cv2.HoughCircles(
        mask, cv2.HOUGH_GRADIENT, 2, 20, param1=100, param2=12, minRadius=4, maxRadius=40
    )
    if found is None:
        return _NOTHING
    return found.reshape(-1, 3).astype(np.float64) * np.array([1.0, 1.0, 2.0])
