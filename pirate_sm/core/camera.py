"""Cameras as they are written: sources, lenses, places, tags."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._model.camera import (
    FEWEST_POINTS,
    Camera,
    CameraPose,
    CameraSource,
    DeviceSource,
    FileSource,
    FrameSize,
    ImagesSource,
    Imperfections,
    LampColour,
    Lens,
    Lighting,
    MarkedRobot,
    Marker,
    RobotTags,
    SyntheticSource,
    SyntheticView,
    TagFamily,
    UrlSource,
)
