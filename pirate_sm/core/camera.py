"""Cameras as they are written: sources, lenses, places, tags."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._model.camera import (
    FEWEST_POINTS,
    Camera,
    CameraPose,
    Lens,
    MarkedRobot,
    Marker,
    RobotTags,
    TagFamily,
)
from pirate_sm.core._model.camera_source import (
    CameraSource,
    DeviceSource,
    FileSource,
    FrameSize,
    ImagesSource,
    SyntheticSource,
    UrlSource,
)
from pirate_sm.core._model.synthetic_camera import (
    Imperfections,
    LampColour,
    Lighting,
    SyntheticView,
)
