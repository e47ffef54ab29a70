"""The light of a synthetic camera and the errors of its sensor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from pirate_sm.core.camera import FrameSize, Imperfections, LampColour, Lighting
from pirate_sm.robot.vision.opencv import cv2
from pirate_sm.robot.vision.picture_arrays import Frame

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
        """Return a drawn picture in the light on the setup."""
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
