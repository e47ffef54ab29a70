"""Draw what a camera would see: the setup and the robot through the lens, with light and errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import atan2, cos, pi, sin
from typing import Final, TypeAlias

import numpy as np

from pirate_sm.core.geometry import Place, Route, inner_corner
from pirate_sm.core.geometry import walls as walls_of
from pirate_sm.core.models import Body
from pirate_sm.robot.camera import (
    Camera,
    FrameSize,
    Imperfections,
    LampColour,
    Lighting,
    Marker,
    RobotTags,
    SyntheticView,
    TagFamily,
)
from pirate_sm.robot.vision.opencv import Floats, Frame, cv2
from pirate_sm.robot.vision.projection import View, raised
from pirate_sm.robot.vision.targets import tag_cells, tag_corners

# --- shapes ---------------------------------------------------------------------------------------


Colour: TypeAlias = tuple[int, int, int]
"""Blue, green, red."""

_SHIFT = 4  # places of polygons have a sixteenth of a pixel
_LONGEST_M = 0.02  # a longer straight line is bent by the lens
_FINER = 4
_CELL = 8  # pixels of a tag's cell before it is seen from the camera
_CORNERS = 32


@dataclass(frozen=True)
class Brush:
    """Draws into one picture.

    Attributes:
        frame: The picture, which is changed.
        view: The lens and its place.
    """

    frame: Frame
    view: View

    def polygon(self, places: Sequence[tuple[float, float]], z_m: float, colour: Colour) -> None:
        """Draw a filled polygon that lies at a height; nothing if the lens cannot see all of it."""
        pixels = self.view.project(raised(_dense(np.array(places)), z_m))
        if not np.all(np.isfinite(pixels)) or np.abs(pixels).max() > 1e5:
            return
        corners = np.round(pixels * (1 << _SHIFT)).astype(np.int32)
        cv2.fillPoly(self.frame, [corners], colour, cv2.LINE_AA, _SHIFT)

    def bar(
        self,
        one: tuple[float, float],
        other: tuple[float, float],
        width_m: float,
        z_m: float,
        colour: Colour,
    ) -> None:
        """Draw a straight bar between two places."""
        self.polygon(bar_corners(one, other, width_m), z_m, colour)

    def disc(
        self, middle: tuple[float, float], radius_m: float, z_m: float, colour: Colour
    ) -> None:
        """Draw a filled circle."""
        x, y = middle
        turns = [2 * pi * number / _CORNERS for number in range(_CORNERS)]
        self.polygon([(x + radius_m * cos(a), y + radius_m * sin(a)) for a in turns], z_m, colour)

    def tag(
        self,
        family: TagFamily,
        number: int,
        middle: tuple[float, float],
        heading_rad: float,
        size_m: float,
        z_m: float,
    ) -> None:
        """Draw a tag with a white margin of one cell."""
        cells = np.pad(tag_cells(family, number), 1, constant_values=255)
        across = len(cells)
        whole_m = size_m * across / (across - 2)
        corners = self.view.project(raised(tag_corners(middle, heading_rad, whole_m), z_m))
        if not np.all(np.isfinite(corners)):
            return
        picture = np.kron(cells, np.ones((_CELL, _CELL), np.uint8))
        self._paste(picture, corners)

    def _paste(self, picture: Frame, corners: Floats) -> None:
        """Draw a gray picture into the quadrilateral of these corners, px."""
        height, width = self.frame.shape[:2]
        left, top = np.maximum(np.floor(corners.min(axis=0)).astype(int) - 1, 0)
        right, bottom = np.minimum(np.ceil(corners.max(axis=0)).astype(int) + 2, (width, height))
        if left >= right or top >= bottom:
            return
        side = len(picture) - 0.5
        edges = np.array([(-0.5, -0.5), (side, -0.5), (side, side), (-0.5, side)], np.float32)
        # The centre of pixel 0 is at 0, of the finer ones at fractions of it.
        finer = ((corners - (left, top) + 0.5) * _FINER - 0.5).astype(np.float32)
        size = ((right - left) * _FINER, (bottom - top) * _FINER)
        turned = cv2.getPerspectiveTransform(edges, finer)
        drawn = cv2.warpPerspective(picture, turned, size, borderMode=cv2.BORDER_REPLICATE)
        mask = np.zeros((size[1], size[0]), np.uint8)
        cv2.fillConvexPoly(mask, np.round(finer).astype(np.int32), 255)
        small = (int(right - left), int(bottom - top))
        drawn = cv2.resize(drawn, small, interpolation=cv2.INTER_AREA).astype(np.float32)
        share = cv2.resize(mask, small, interpolation=cv2.INTER_AREA).astype(np.float32) / 255
        part = self.frame[top:bottom, left:right]
        part[:] = np.round(
            part + (drawn - part.transpose(2, 0, 1)).transpose(1, 2, 0) * share[..., None]
        )


def bar_corners(
    one: tuple[float, float], other: tuple[float, float], width_m: float
) -> list[tuple[float, float]]:
    """Return the corners of a bar from one place to another."""
    ahead = np.array(other) - np.array(one)
    length = float(np.hypot(ahead[0], ahead[1])) or 1.0
    left = np.array([-ahead[1], ahead[0]]) / length * width_m / 2
    corners = (one + left, other + left, other - left, one - left)
    return [(float(x), float(y)) for x, y in corners]


def _dense(places: Floats) -> Floats:
    """Return the corners of a polygon with more corners on its long sides."""
    corners = []
    for here, there in zip(places, np.roll(places, -1, axis=0), strict=True):
        pieces = int(np.hypot(*(there - here)) // _LONGEST_M) + 1
        corners += [here + (there - here) * number / pieces for number in range(pieces)]
    return np.array(corners)


# --- light ----------------------------------------------------------------------------------------


_LAMPS: Final[Mapping[LampColour, tuple[float, float, float]]] = {
    "neutral": (1.0, 1.0, 1.0),
    "warm": (0.67, 1.0, 1.19),
    "cold": (1.33, 1.0, 0.88),
}
"""How bright blue, green and red are, with the white balance of the neutral lamp.

Planck's law at 450, 550 and 610 nm for 4,000 K and 7,500 K, divided by that for 5,500 K, green 1.
"""

_HALF = 96  # of 255: light of strength 1 in the map of light, which so reaches 2.65
_MARGIN = 64


@dataclass(frozen=True)
class Sensor:
    """Turns a drawn picture into one that a camera would take.

    Attributes:
        light: The light on the setup.
        errors: The errors of the camera.
        size: Width and height of the pictures.
    """

    light: Lighting
    errors: Imperfections
    size: FrameSize

    def lit(self, frame: Frame) -> Frame:
        """Return a drawn picture as bright as the lamps of the setup make it."""
        return cv2.multiply(frame, self._light_map, scale=1 / _HALF)

    def taken(self, frame: Frame, chance: np.random.Generator) -> Frame:
        """Return a lit picture with blur, noise and the marks of its compression."""
        taken = frame
        if self.errors.blur > 0:
            taken = cv2.GaussianBlur(taken, (0, 0), self.errors.blur)
        if self.errors.noise > 0:
            left, top = chance.integers(0, _MARGIN, 2)
            width, height = self.size
            noise = self._noise[top : top + height, left : left + width]
            taken = cv2.addWeighted(taken, 1.0, noise, 1.0, -128.0)
        if self.errors.jpeg > 0:
            quality = [cv2.IMWRITE_JPEG_QUALITY, self.errors.jpeg]
            taken = cv2.imdecode(cv2.imencode(".jpg", taken, quality)[1], cv2.IMREAD_COLOR)
        return taken

    @cached_property
    def _light_map(self) -> Frame:
        """Return the strength of the light in each pixel: less towards the right, and lower."""
        width, height = self.size
        right = np.linspace(0.0, 1.0, width)[None, :]
        down = np.linspace(0.0, 1.0, height)[:, None]
        strength = self.light.gain * (1.0 - self.light.uneven * (0.8 * right + 0.2 * down))
        lit = strength[..., None] * np.array(_LAMPS[self.light.lamp]) * _HALF
        return np.clip(np.round(lit), 0, 255).astype(np.uint8)

    @cached_property
    def _noise(self) -> Frame:
        """Return noise around 128, with a margin: each picture takes another part of it."""
        width, height = self.size
        chance = np.random.default_rng(0)
        shape = (height + _MARGIN, width + _MARGIN, 3)
        noise = chance.standard_normal(shape, np.float32) * self.errors.noise + 128.0
        return np.clip(np.round(noise), 0, 255).astype(np.uint8)


# --- the scene ------------------------------------------------------------------------------------


Wall: TypeAlias = tuple[Place, ...]


@dataclass(frozen=True)
class ShownLink:
    """A link of the robot between two wheels; places are in the plane of the setup, m.

    Attributes:
        module: Name of its module, as in the camera's file.
        front: Place of the wheel ahead.
        rear: Place of the wheel behind.
    """

    module: str
    front: Place
    rear: Place

    @property
    def middle(self) -> Place:
        """Return the place of its middle, where its tag is."""
        return 0.5 * (self.front[0] + self.rear[0]), 0.5 * (self.front[1] + self.rear[1])

    @property
    def heading_rad(self) -> float:
        """Return the direction in which it points ahead."""
        return atan2(self.front[1] - self.rear[1], self.front[0] - self.rear[0])


@dataclass(frozen=True)
class ShownScene:
    """The robot at one moment, and what does not move.

    Attributes:
        links: Its links, front to rear.
        walls: Corners of the wall on side A and of that on side B.
        wheel_radius_m: Radius of its wheels.
        half_thickness_m: Distance from the axis of a link to its surface.
    """

    links: tuple[ShownLink, ...]
    walls: tuple[Wall, Wall]
    wheel_radius_m: float
    half_thickness_m: float

    def moved(self, before: ShownScene, share: float) -> ShownScene:
        """Return the scene between an earlier one (``share`` 0) and this one (1)."""
        links = tuple(
            ShownLink(
                now.module,
                between(then.front, now.front, share),
                between(then.rear, now.rear, share),
            )
            for then, now in zip(before.links, self.links, strict=True)
        )
        return ShownScene(links, self.walls, self.wheel_radius_m, self.half_thickness_m)


def scene_in_pipe(wheels: Sequence[Place], body: Body, route: Route) -> ShownScene:
    """Return the scene of a simulated robot.

    Args:
        wheels: Place of each wheel in the plane of the pipe, m, front to rear.
        body: The body of the robot.
        route: The route through its pipe.
    """
    x, y = inner_corner(route)
    side_a, side_b = (tuple((u - x, v - y) for u, v in wall) for wall in walls_of(route))
    places = [(u - x, v - y) for u, v in wheels]
    links = tuple(
        ShownLink(link.module, front, rear)
        for link, (front, rear) in zip(body.links, pairwise(places), strict=True)
    )
    return ShownScene(links, (side_a, side_b), body.wheel_radius, body.body_half_thickness)


def between(one: Place, other: Place, share: float) -> Place:
    """Return the place that is this share of the way from one to the other."""
    return one[0] + share * (other[0] - one[0]), one[1] + share * (other[1] - one[1])


# --- pictures -------------------------------------------------------------------------------------


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
