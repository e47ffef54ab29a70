"""What a camera saw of the robot in one frame."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SeenMark:
    """A tag or marker of the robot, found in a frame.

    Attributes:
        on: The module that it is fixed to, as in the camera's file.
        place_m: Its centre in the plane of the setup, m. The origin is the inner corner of the
            bend, x points along the first leg of the pipe, y to side A (thesis section 5-3-2).
        heading_rad: Direction in which the module points ahead, from x towards y; None for a
            marker, which is round.
    """

    on: str
    place_m: tuple[float, float]
    heading_rad: float | None = None


@dataclass(frozen=True)
class Sighting:
    """What was found in one frame.

    Attributes:
        captured_s: Time at which the light fell on the sensor: the frame's arrival minus the
            camera's latency, s.
        marks: What was found of the robot, in the order of the camera's file.
        rms_px: How far the setup's tags are from where the survey expects them, root mean square,
            px; None if fewer than two of them are seen.
        gray_spread: Difference between the 5 % darkest and the 5 % brightest pixels, of 255.
        digest: A checksum of the pixels; equal in identical frames.
    """

    captured_s: float
    marks: tuple[SeenMark, ...]
    rms_px: float | None
    gray_spread: float
    digest: int
