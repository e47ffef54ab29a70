"""Write into a picture what was found in it."""

from __future__ import annotations

from math import cos, sin

import numpy as np

from pirate_sm.core.events import SeenMark, Sighting
from pirate_sm.robot.vision.opencv import cv2
from pirate_sm.robot.vision.picture_arrays import Floats, Frame
from pirate_sm.robot.vision.plane import raised
from pirate_sm.robot.vision.seeing import Eye, setup_tag_points

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
        _mark(drawn, eye, mark)
    for name, end in (("x", (_AXIS_M, 0.0)), ("y", (0.0, _AXIS_M))):
        ends = eye.view.project(raised(np.array([(0.0, 0.0), end]), 0.0))
        _line(drawn, ends, _AXES)
        _label(drawn, ends[1], name, _AXES)
    return drawn


def _mark(frame: Frame, eye: Eye, mark: SeenMark) -> None:
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
