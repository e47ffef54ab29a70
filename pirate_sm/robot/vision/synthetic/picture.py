"""Draw the pictures of a synthetic camera."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Final

import numpy as np

from pirate_sm.core.camera import Camera, Marker, RobotTags, SyntheticView
from pirate_sm.robot.vision.opencv import cv2
from pirate_sm.robot.vision.picture_arrays import Frame
from pirate_sm.robot.vision.plane import View
from pirate_sm.robot.vision.synthetic.brush import Brush, Colour
from pirate_sm.robot.vision.synthetic.lighting import Sensor
from pirate_sm.robot.vision.synthetic.shown_scene import ShownScene, between

# Blue, green, red of what is drawn, in light of strength 1.
_ROOM: Final[Colour] = (60, 62, 66)
_BIRCH: Final[Colour] = (140, 175, 200)
_WALL: Final[Colour] = (120, 118, 116)
_BODY: Final[Colour] = (72, 70, 68)
_WHEEL: Final[Colour] = (38, 36, 36)
_SKIN: Final[Colour] = (120, 150, 205)

_WALL_M, _WALL_TOP_M = 0.012, 0.06  # the bars of the setup, their width and height
_HAND_M = 0.25  # how high a hand is
_LABEL_M = 0.0015  # how far a module ends below its tag
_MOMENTS = 3  # pictures of which a smeared one is made


@dataclass(frozen=True)
class SyntheticPictures:
    """Draws pictures of a scene as one camera would take them.

    Attributes:
        camera: What the camera's file says: lens, place, what is on the setup and the robot.
        view: Its lens at its place.
        looks: The light and the errors.
    """

    camera: Camera
    view: View
    looks: SyntheticView

    def picture(
        self, scene: ShownScene, number: int, before: ShownScene | None = None, seed: int = 0
    ) -> Frame:
        """Return a picture; the same arguments give the same picture.

        Args:
            scene: The robot as the shutter closes.
            number: Number of the picture: its noise depends on it.
            before: The robot as the shutter opened; None if it stands.
            seed: Of the noise, beside that of the camera's file.
        """
        chance = np.random.default_rng((self.looks.seed, seed, number))
        shown = self._smeared(scene, before)
        brush = Brush(shown, self.view)
        if self.looks.through == "pvc":
            self._cover_with_pvc(brush, scene)
        lit = Brush(self._sensor.lit(shown), self.view)
        if self.looks.light.glare:
            _shine(lit, scene)
        for hand in self.looks.hides:
            lit.disc(hand.at, hand.size / 2, _HAND_M, _SKIN)
        return self._sensor.taken(lit.frame, chance)

    @cached_property
    def _sensor(self) -> Sensor:
        return Sensor(self.looks.light, self.looks.camera, self.camera.source.size)

    @cached_property
    def _backgrounds(self) -> dict[tuple[tuple[tuple[float, float], ...], ...], Frame]:
        return {}

    def _background(self, scene: ShownScene) -> Frame:
        """Return a new picture of the setup without the robot."""
        known = self._backgrounds.get(scene.walls)
        if known is None:
            known = self._backgrounds[scene.walls] = self._empty_setup(scene)
        return known.copy()

    def _empty_setup(self, scene: ShownScene) -> Frame:
        width, height = self.camera.source.size
        frame = np.full((height, width, 3), _ROOM, np.uint8)
        brush = Brush(frame, self.view)
        (x, y, _), reach = self.view.pose.at, 0.95
        for number in range(-9, 10):  # planks: a large polygon would leave the lens as a whole
            across = y + number * 0.1
            brush.bar((x - reach, across), (x + reach, across), 0.1005, 0.0, _grained(number))
        for wall in scene.walls:
            for one, other in pairwise(wall):
                for start, end in _along(one, other):
                    brush.bar(start, end, _WALL_M, _WALL_TOP_M, _WALL)
        setup = self.camera.setup
        if setup.tags is not None and setup.size is not None:
            for name, (tag_x, tag_y, z) in setup.at.items():
                brush.tag(setup.tags, int(name), (tag_x, tag_y), 0.0, setup.size, z)
        return frame

    def _smeared(self, scene: ShownScene, before: ShownScene | None) -> Frame:
        """Return the setup with the robot, which moves while the shutter is open."""
        if before is None or before == scene:
            return self._with_robot(self._background(scene), scene)
        total = np.zeros((*self.camera.source.size[::-1], 3), np.uint16)
        for moment in range(_MOMENTS):
            between = scene.moved(before, moment / (_MOMENTS - 1))
            total += self._with_robot(self._background(scene), between)
        return (total // _MOMENTS).astype(np.uint8)

    def _with_robot(self, frame: Frame, scene: ShownScene) -> Frame:
        """Draw the robot: its wheels, its modules on them, and on top their tags or the marker."""
        brush, robot = Brush(frame, self.view), self.camera.robot
        height_m = robot.height if isinstance(robot, RobotTags) else robot.marker.height
        for wheel in [*(link.front for link in scene.links), scene.links[-1].rear]:
            brush.disc(wheel, scene.wheel_radius_m, 0.6 * height_m, _WHEEL)
        for link in scene.links:
            width_m = 2 * scene.half_thickness_m
            brush.bar(link.front, link.rear, width_m, height_m - _LABEL_M, _BODY)
        for link in scene.links:
            if isinstance(robot, RobotTags):
                for name in (each for each, on in robot.on.items() if on == link.module):
                    size_m = robot.size
                    brush.tag(
                        robot.tags, int(name), link.middle, link.heading_rad, size_m, height_m
                    )
            elif link.module == robot.marker.on:
                marker = robot.marker
                brush.disc(link.middle, marker.size / 2, marker.height, _colour_of(marker))
        return frame

    def _cover_with_pvc(self, brush: Brush, scene: ShownScene) -> None:
        """Draw the clear pipe over the robot: a bluish haze, and a streak of reflected light."""
        veil = np.zeros_like(brush.frame)
        over = Brush(veil, self.view)
        side_a, side_b = scene.walls
        for a, b, c, d in zip(side_a, side_a[1:], side_b[1:], side_b, strict=False):
            for one, other in zip(_along(a, b), _along(d, c), strict=True):
                over.polygon([one[0], one[1], other[1], other[0]], 0.1, (28, 26, 24))
            for start, end in _along(between(a, d, 0.4), between(b, c, 0.4)):
                over.bar(start, end, 0.004, 0.11, (120, 118, 116))
        # The haze takes a part of what is behind it away.
        dimmed = cv2.addWeighted(brush.frame, 0.85, veil, 1.0, 0.0)
        np.copyto(brush.frame, dimmed, where=veil.any(axis=2, keepdims=True))


def _shine(brush: Brush, scene: ShownScene) -> None:
    """Draw the light of the lamps at the front of the robot, which is brighter than any pixel."""
    front = scene.links[0]
    ahead = (
        front.front[0] + 0.05 * np.cos(front.heading_rad),
        front.front[1] + 0.05 * np.sin(front.heading_rad),
    )
    at = brush.view.project(np.array([[*ahead, 0.04]]))[0]
    if not np.all(np.isfinite(at)):
        return
    height, width = brush.frame.shape[:2]
    spread = 0.045 * float(brush.view.scale(np.array([ahead]), 0.04)[0])
    left, top = (max(int(each - 4 * spread), 0) for each in at)
    right, bottom = min(int(at[0] + 4 * spread), width), min(int(at[1] + 4 * spread), height)
    if left >= right or top >= bottom:
        return
    across = np.arange(left, right)[None, :] - at[0]
    down = np.arange(top, bottom)[:, None] - at[1]
    glow = 400.0 * np.exp(-(across**2 + down**2) / (2 * spread**2))
    part = brush.frame[top:bottom, left:right]
    part[:] = np.minimum(part + glow[..., None], 255.0).astype(np.uint8)


def _colour_of(marker: Marker) -> Colour:
    """Return a colour for which the marker's limits were made: bright, of their middle hue."""
    (h1, s1, v1), (h2, s2, v2) = marker.hsv
    hue = (h1 + (h2 - h1) % 180 // 2) % 180
    hsv = np.array([[[hue, (s1 + 3 * s2) // 4, (v1 + 3 * v2) // 4]]], np.uint8)
    blue, green, red = (int(each) for each in cv2.cvtColor(hsv, cv2.COLOR_HSV2BGR)[0, 0])
    return blue, green, red


def _grained(number: int) -> Colour:
    """Return the colour of a plank: wood is not all the same."""
    lighter = (number * 7919) % 13 - 6
    blue, green, red = (each + lighter for each in _BIRCH)
    return blue, green, red


_Segment = tuple[tuple[float, float], tuple[float, float]]


def _along(one: tuple[float, float], other: tuple[float, float]) -> list[_Segment]:
    """Return a straight in twenty pieces: of a long one the lens may not see all."""
    places = [between(one, other, number / 20) for number in range(21)]
    return list(pairwise(places))
