"""See the robot in a frame: the whole way from pixels to places, as one pure function.

A round marker is found by its colour, by one of three finders: ``components`` labels the picture
as it is and corrects the distortion of the found points alone; ``blob`` and ``hough`` work on the
picture without distortion, as the thesis does (section 5-4: threshold of hue, saturation and value,
Gaussian blur, then SimpleBlobDetector or HoughCircles).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import atan2, cos, sin
from zlib import crc32

import numpy as np

from pirate_sm.core.errors import UsageError
from pirate_sm.core.events import SeenMark, Sighting
from pirate_sm.robot.camera import Camera, FrameSize, MarkedRobot, Marker, RobotTags
from pirate_sm.robot.vision.opencv import Floats, Frame, Gray, cv2
from pirate_sm.robot.vision.projection import (
    LensModel,
    UndistortedView,
    View,
    find_view,
    raised,
    rms,
)
from pirate_sm.robot.vision.targets import FoundTag, find_tag_near, find_tags, grayed, tag_corners

# --- a marker -------------------------------------------------------------------------------------


WINDOW_PX = 60
"""Half the side of the window around the last place: 0.4 s of travel at 0.15 m/s and 1 px/mm."""

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
        """Return the best place by every second pixel that fits by all pixels, too; or none."""
        small = cv2.resize(frame, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_NEAREST)
        spots = 2 * _components(self._mask(small))
        for x, y in self._fitting(spots, self.view.lens.rays, None):
            found = self._around(frame, (float(x), float(y)))[:1]
            if len(found):
                return found
        return np.empty((0, 2))

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


# --- the robot ------------------------------------------------------------------------------------


_SAMPLE = 32
"""Every 32nd pixel of every 32nd line is enough for light and checksum."""

_SIZE_ERROR = 0.35
"""Of the size of a tag, the largest error; noise makes 10 %, a tag at another height 8 %."""

_FEWEST_SETUP_TAGS = 2


@dataclass(frozen=True)
class Eye:
    """Sees the robot in the frames of one camera.

    Attributes:
        camera: What the camera's file says.
        view: Its lens at its place.
    """

    camera: Camera
    view: View

    def see(
        self, frame: Frame, captured_s: float, near: tuple[float, float] | None = None
    ) -> Sighting:
        """Return what a frame shows.

        Args:
            frame: The picture, of the size in the camera's file.
            captured_s: When the light fell on the sensor, s.
            near: Where the marker was last, m; tags need no such help.
        """
        sample = np.ascontiguousarray(frame[::_SAMPLE, ::_SAMPLE])
        dark, bright = np.percentile(grayed(sample), (5, 95))
        if self._finder is not None:
            marks = _marker(self._finder, frame, near)
            rms_px = self._moved_px(self._setup_tags(frame))
        else:
            tags = self._tags(frame)
            marks = self._marks(tags)
            rms_px = self._moved_px(tags.get(self.camera.setup.tags or "", ()))
        return Sighting(captured_s, marks, rms_px, float(bright - dark), crc32(sample.tobytes()))

    @cached_property
    def _finder(self) -> MarkerFinder | None:
        robot = self.camera.robot
        if not isinstance(robot, MarkedRobot):
            return None
        return MarkerFinder(robot.marker, self.view, self.camera.source.size)

    def _tags(self, frame: Frame) -> dict[str, list[FoundTag]]:
        """Return what is found of each family in use."""
        gray = grayed(frame)
        robot, setup = self.camera.robot, self.camera.setup
        families = {robot.tags} if isinstance(robot, RobotTags) else set()
        families |= {setup.tags} if setup.tags else set()
        return {family: find_tags(gray, family) for family in sorted(families)}

    def _marks(self, tags: dict[str, list[FoundTag]]) -> tuple[SeenMark, ...]:
        """Return the tags of the robot, each where it fits its size best."""
        robot = self.camera.robot
        assert isinstance(robot, RobotTags)
        best: dict[str, tuple[float, SeenMark]] = {}
        for tag in tags[robot.tags]:
            number = str(tag.number)
            if number not in robot.on:
                continue
            corners = self.view.on_plane(tag.corners, robot.height)
            error = _size_error(corners, robot.size)
            if error < min(_SIZE_ERROR, best.get(number, (np.inf,))[0]):
                best[number] = error, _seen_mark(robot.on[number], corners)
        return tuple(best[number][1] for number in robot.on if number in best)

    def _setup_tags(self, frame: Frame) -> Sequence[FoundTag]:
        """Return the setup's tags that are near their places; from everywhere if hardly any is."""
        setup = self.camera.setup
        if setup.tags is None:
            return ()
        near = [
            find_tag_near(frame, setup.tags, int(number), self.view.project(corners))
            for number in setup.at
            for corners in [setup_tag_points(self.camera, number)]
        ]
        found = [tag for tag in near if tag is not None]
        return found if len(found) >= _FEWEST_SETUP_TAGS else find_tags(grayed(frame), setup.tags)

    def _moved_px(self, tags: Sequence[FoundTag]) -> float | None:
        """Return how far the setup's tags are from where the survey expects them, px."""
        found = [tag for tag in tags if str(tag.number) in self.camera.setup.at]
        if len(found) < _FEWEST_SETUP_TAGS:
            return None
        points = np.vstack([setup_tag_points(self.camera, str(tag.number)) for tag in found])
        pixels = np.vstack([tag.corners for tag in found])
        return rms(self.view.residuals(points, pixels))


def eye_of(camera: Camera) -> Eye:
    """Return the eye of a camera that has been calibrated and surveyed.

    Raises:
        UsageError: It has not; or its points fit no place of the camera.
    """
    if camera.lens is None:
        what = f"the lens of '{camera.camera}' is unknown"
        raise UsageError(f"{what}: measure it with `pirate camera calibrate`")
    lens = LensModel(camera.lens)
    if camera.setup.pose is not None:
        return Eye(camera, View(lens, camera.setup.pose))
    if not camera.setup.points:
        what = f"where the camera '{camera.camera}' hangs is unknown"
        raise UsageError(f"{what}: measure it with `pirate camera survey`")
    points = np.array([point.at for point in camera.setup.points])
    view = find_view(lens, points, np.array([point.seen for point in camera.setup.points]))
    if view is None:
        what = f"the points of '{camera.camera}' fit no place of the camera"
        raise UsageError(f"{what}: measure them with `pirate camera survey`")
    return Eye(camera, view)


def setup_tag_points(camera: Camera, number: str) -> Floats:
    """Return the corners of a tag of the setup, (4, 3) in m; its upper edge points along x."""
    x, y, z = camera.setup.at[number]
    assert camera.setup.size is not None
    return raised(tag_corners((x, y), 0.0, camera.setup.size), z)


def _marker(
    finder: MarkerFinder, frame: Frame, near: tuple[float, float] | None
) -> tuple[SeenMark, ...]:
    """Return the marker: near its last place, else where it fits its size best."""
    found = finder.places(frame, near)
    if near is not None and not len(found):
        found = finder.places(frame)
    return tuple(SeenMark(finder.marker.on, (float(x), float(y))) for x, y in found[:1])


def _size_error(corners: Floats, size_m: float) -> float:
    """Return the largest error of the sides of a tag, of their length; infinite if unknown."""
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1)
    error = np.abs(sides / size_m - 1).max()
    return float(error) if np.isfinite(error) else float("inf")


def _seen_mark(on: str, corners: Floats) -> SeenMark:
    """Return the mark of a tag whose corners are at these places."""
    x, y = corners.mean(axis=0)
    ahead_x, ahead_y = corners[:2].mean(axis=0) - corners[2:].mean(axis=0)
    return SeenMark(on, (float(x), float(y)), atan2(ahead_y, ahead_x))


# --- what is drawn into a frame -------------------------------------------------------------------


_FOUND, _EXPECTED, _AXES = (60, 220, 60), (230, 140, 30), (40, 40, 230)
_ARROW_M = 0.045
_AXIS_M = 0.1


def annotated(eye: Eye, frame: Frame, sighting: Sighting) -> Frame:
    """Return a copy of a frame with what was found, the setup's tags where they should be, axes."""
    drawn = frame.copy()
    for number in eye.camera.setup.at if eye.camera.setup.tags else ():
        corners = eye.view.project(setup_tag_points(eye.camera, number))
        _line(drawn, np.vstack([corners, corners[:1]]), _EXPECTED)
        _label(drawn, corners.mean(axis=0), number, _EXPECTED)
    for mark in sighting.marks:
        _draw_mark(drawn, eye, mark)
    for name, end in (("x", (_AXIS_M, 0.0)), ("y", (0.0, _AXIS_M))):
        ends = eye.view.project(raised(np.array([(0.0, 0.0), end]), 0.0))
        _line(drawn, ends, _AXES)
        _label(drawn, ends[1], name, _AXES)
    return drawn


def _draw_mark(frame: Frame, eye: Eye, mark: SeenMark) -> None:
    """Draw a ring around a mark, and an arrow ahead."""
    robot = eye.camera.robot
    height_m = robot.height if hasattr(robot, "height") else robot.marker.height
    x, y = mark.place_m
    places = np.array([(x, y)])
    if mark.heading_rad is not None:
        ahead = _ARROW_M * cos(mark.heading_rad), _ARROW_M * sin(mark.heading_rad)
        places = np.vstack([places, places + np.array(ahead)])
    pixels = eye.view.project(raised(places, height_m))
    if not np.all(np.isfinite(pixels)):
        return
    _line(frame, pixels, _FOUND)
    cv2.circle(frame, _pixel(pixels[0]), 9, _FOUND, 2, cv2.LINE_AA)
    _label(frame, pixels[0], mark.on, _FOUND)


def _line(frame: Frame, pixels: Floats, colour: tuple[int, int, int]) -> None:
    if len(pixels) > 1 and np.all(np.isfinite(pixels)):
        cv2.polylines(frame, [np.round(pixels).astype(np.int32)], False, colour, 2, cv2.LINE_AA)


def _label(frame: Frame, at: Floats, text: str, colour: tuple[int, int, int]) -> None:
    if not np.all(np.isfinite(at)):
        return
    x, y = _pixel(at)
    for shade, width in (((0, 0, 0), 3), (colour, 1)):
        cv2.putText(
            frame, text, (x + 14, y - 8), cv2.FONT_HERSHEY_SIMPLEX, 0.6, shade, width, cv2.LINE_AA
        )


def _pixel(at: Floats) -> tuple[int, int]:
    return round(float(at[0])), round(float(at[1]))
