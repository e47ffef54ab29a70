"""See the robot in a frame: the whole way from pixels to places, as one pure function."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import atan2
from zlib import crc32

import numpy as np

from pirate_sm.core.camera import Camera, MarkedRobot, RobotTags
from pirate_sm.core.errors import UsageError
from pirate_sm.core.events import SeenMark, Sighting
from pirate_sm.robot.vision.lens import LensModel
from pirate_sm.robot.vision.marker import MarkerFinder
from pirate_sm.robot.vision.picture_arrays import Floats, Frame
from pirate_sm.robot.vision.plane import View, find_view, raised, rms
from pirate_sm.robot.vision.tags import FoundTag, find_tag_near, find_tags, grayed, tag_corners

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
                best[number] = error, _mark(robot.on[number], corners)
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


def _mark(on: str, corners: Floats) -> SeenMark:
    """Return the mark of a tag whose corners are at these places."""
    x, y = corners.mean(axis=0)
    ahead_x, ahead_y = corners[:2].mean(axis=0) - corners[2:].mean(axis=0)
    return SeenMark(on, (float(x), float(y)), atan2(ahead_y, ahead_x))
