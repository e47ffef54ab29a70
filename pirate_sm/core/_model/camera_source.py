"""Where the pictures of a camera come from."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import Field, StringConstraints, Tag, model_validator

from pirate_sm.core._model.base import Frozen, by_key
from pirate_sm.core._model.quantities import Count, Frequency
from pirate_sm.core._model.synthetic_camera import SyntheticView

FrameSize: TypeAlias = tuple[
    Annotated[Count, Field(ge=32, le=8192)], Annotated[Count, Field(ge=32, le=8192)]
]
Text = Annotated[str, StringConstraints(min_length=1)]


class _Pictures(Frozen):
    """What every source has.

    Attributes:
        size: Width and height of its pictures, in pixels. The lens is valid for these only.
        rate: How many pictures it takes.
    """

    size: FrameSize
    rate: Annotated[Frequency, Field(gt=0, le=1000)] = 30.0


class DeviceSource(_Pictures):
    """A camera of this computer.

    Attributes:
        device: Its number, as in ``/dev/video0``.
        codec: Its format on the wire: four letters.
    """

    device: Count
    codec: Annotated[str, StringConstraints(pattern="^[A-Z0-9]{4}$")] = "MJPG"


class FileSource(_Pictures):
    """A video in a file.

    Attributes:
        file: Path of the video, relative to the camera's file.
    """

    file: Text


class UrlSource(_Pictures):
    """A camera in the network.

    Attributes:
        url: Its address, such as ``rtsp://camera/stream``.
    """

    url: Annotated[str, StringConstraints(pattern=r"^[a-z]+://.+")]


class ImagesSource(_Pictures):
    """Pictures in files, in the order of their names.

    Attributes:
        images: Their paths with wildcards, relative to the camera's file, such as ``seen/*.png``.
    """

    images: Text


class SyntheticSource(_Pictures):
    """A camera whose pictures are drawn from the truth of the simulator.

    Attributes:
        synthetic: The light, the view and the errors.
    """

    synthetic: SyntheticView

    @model_validator(mode="after")
    def _shuts_in_time(self) -> SyntheticSource:
        if self.synthetic.camera.shutter * self.rate > 1:
            raise ValueError("the `shutter` is open for longer than from picture to picture")
        return self


CameraSource: TypeAlias = Annotated[
    Annotated[DeviceSource, Tag("device")]
    | Annotated[FileSource, Tag("file")]
    | Annotated[UrlSource, Tag("url")]
    | Annotated[ImagesSource, Tag("images")]
    | Annotated[SyntheticSource, Tag("synthetic")],
    by_key(
        ("device", "file", "url", "images", "synthetic"),
        custom_error_type="source",
        custom_error_message="expected one of device, file, url, images or synthetic",
    ),
]
