"""A camera over the setup: where its pictures come from, its lens, its place, what it looks for."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, StringConstraints, Tag, model_validator

from pirate_sm.core.fields import (
    Angle,
    Count,
    Duration,
    Format,
    Frequency,
    Frozen,
    Length,
    Name,
    Number,
    Pixels,
    PositiveLength,
    Ratio,
    by_key,
)

LampColour = Literal["neutral", "warm", "cold"]


class Lighting(Frozen):
    """The light on the setup.

    Attributes:
        gain: Brightness of the picture; 1 is well exposed, more than 1.5 overexposed.
        lamp: Colour of the lamp; the camera's white balance stays as for ``neutral``.
        uneven: How much darker the picture is at its darkest edge than at its brightest.
        glare: Whether the robot's own lamps shine on the pipe.
    """

    gain: Annotated[Ratio, Field(gt=0, le=10)] = 1.0
    lamp: LampColour = "neutral"
    uneven: Annotated[Ratio, Field(ge=0, lt=1)] = 0.25
    glare: bool = False


class Imperfections(Frozen):
    """The errors of a camera.

    Attributes:
        noise: Standard deviation of the noise of each pixel, of 255.
        blur: Standard deviation of the blur of the lens, in pixels.
        shutter: How long the shutter is open; what moves is smeared.
        jpeg: Quality of the JPEG compression, 100 for the best; 0 for none.
        lost: Share of frames that are lost.
    """

    noise: Annotated[float, Field(ge=0, le=50)] = 3.0
    blur: Annotated[float, Field(ge=0, le=20)] = 0.6
    shutter: Annotated[Duration, Field(ge=0, le=1)] = 0.01
    jpeg: Annotated[Count, Field(le=100)] = 90
    lost: Annotated[Ratio, Field(ge=0, lt=1)] = 0.0


class Hand(Frozen):
    """Something that covers a part of the picture, such as a hand.

    Attributes:
        at: Where its middle is in the plane of the setup.
        size: Its diameter.
    """

    at: tuple[Length, Length]
    size: PositiveLength


class SyntheticView(Frozen):
    """A camera that draws its pictures from the truth of the simulator.

    Attributes:
        light: The light on the setup.
        camera: The errors of the camera.
        through: What the robot is seen through: ``air`` between open walls, or ``pvc``, a clear
            pipe with reflections.
        hides: What covers a part of the picture.
        seed: Of noise and lost frames, beside the seed of the run.
    """

    light: Lighting = Lighting()
    camera: Imperfections = Imperfections()
    through: Literal["air", "pvc"] = "air"
    hides: tuple[Hand, ...] = ()
    seed: Count = 0


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


Point: TypeAlias = tuple[Length, Length, Length]
TagFamily = Literal["aruco_4x4_50", "apriltag_36h11"]
TagNumber = Annotated[str, StringConstraints(pattern=r"^(0|[1-9]\d{0,2})$")]
Hue = Annotated[Count, Field(le=179)]
Level = Annotated[Count, Field(le=255)]
Hsv: TypeAlias = tuple[Hue, Level, Level]
Finder = Literal["components", "blob", "hough"]


FEWEST_POINTS = 4
"""A pose has six unknowns; each point gives two equations, and one more judges the others."""


class Lens(Frozen):
    """The lens and the sensor, as `pirate camera calibrate` measures them.

    Attributes:
        model: ``fisheye``, or ``brown`` (the thesis's, eq. C-3), for lenses of small angles.
        f: Focal lengths along the width and the height, in pixels.
        centre: Where the axis of the lens meets the picture, in pixels.
        k: Distortion: of a fisheye k1 k2 k3 k4, of brown k1 k2 p1 p2 k3.
    """

    model: Literal["fisheye", "brown"]
    f: tuple[Annotated[Number, Field(gt=0)], Annotated[Number, Field(gt=0)]]
    centre: tuple[Number, Number]
    k: Annotated[tuple[Number, ...], Field(min_length=4, max_length=5)]

    @model_validator(mode="after")
    def _has_its_coefficients(self) -> Lens:
        wanted = 4 if self.model == "fisheye" else 5
        if len(self.k) != wanted:
            raise ValueError(f"`k` of a {self.model} lens has {wanted} numbers, not {len(self.k)}")
        return self


class SeenPoint(Frozen):
    """A point of the setup whose place is known, and where it is seen.

    Attributes:
        at: Its place: x along the first leg and y to side A from the inner corner of the bend, z
            above the plate.
        seen: Where it is in the picture, in pixels from the upper left corner.
    """

    at: Point
    seen: tuple[Number, Number]


class CameraPose(Frozen):
    """Where the camera hangs, as `pirate camera survey` measures it.

    Attributes:
        at: Its place over the setup.
        turn: Rotation from the axes of the setup to those of the camera (x right, y down and z
            ahead in the picture): the axis of the rotation, as long as its angle.
    """

    at: Point
    turn: tuple[Angle, Angle, Angle]


class Setup(Frozen):
    """What is known of the setup: tags or points on it.

    Attributes:
        tags: Family of the tags on the setup.
        size: Length of their sides.
        at: Place of the middle of each tag, by its number. Its upper edge points along x.
        points: Measured points, instead of tags.
        pose: Where the camera hangs.
    """

    tags: TagFamily | None = None
    size: PositiveLength | None = None
    at: Annotated[dict[TagNumber, Point], Field(max_length=100)] = {}
    points: Annotated[tuple[SeenPoint, ...], Field(max_length=100)] = ()
    pose: CameraPose | None = None

    @model_validator(mode="after")
    def _is_known(self) -> Setup:
        if self.tags is not None and (self.size is None or not self.at):
            raise ValueError("with `tags` give their `size`, and in `at` where each of them is")
        if self.tags is None and (self.size is not None or self.at):
            raise ValueError("`size` and `at` are for `tags`: name their family")
        return self


class Marker(Frozen):
    """A round marker on the robot, found by its colour.

    Attributes:
        hsv: Lower and upper limit of hue (0–179), saturation and value (0–255). A lower hue above
            the upper one goes through red.
        finder: ``components`` of the picture as it is, or on the picture without distortion
            ``blob`` or ``hough``, as the thesis does (section 5-4).
        blur: Size of the Gaussian blur of ``blob`` and ``hough``.
        size: Diameter of the marker.
        height: Its height above the plate.
        on: The module that it is fixed to, in its middle.
    """

    hsv: tuple[Hsv, Hsv]
    finder: Finder = "components"
    blur: Annotated[Pixels, Field(ge=1, le=51)] = 5.0
    size: PositiveLength
    height: Annotated[Length, Field(ge=0)]
    on: Name


class RobotTags(Frozen):
    """Tags on the modules of the robot.

    Attributes:
        tags: Family of the tags.
        size: Length of their sides.
        height: Their height above the plate.
        on: The module that each tag is fixed to, in its middle, by the number of the tag. Its upper
            edge points ahead.
    """

    tags: TagFamily
    size: PositiveLength
    height: Annotated[Length, Field(ge=0)]
    on: Annotated[dict[TagNumber, Name], Field(min_length=1)]


class MarkedRobot(Frozen):
    """One marker on the robot.

    Attributes:
        marker: The marker.
    """

    marker: Marker


RobotMarks: TypeAlias = Annotated[
    Annotated[RobotTags, Tag("tags")] | Annotated[MarkedRobot, Tag("marker")],
    by_key(
        ("tags", "marker"),
        custom_error_type="marks",
        custom_error_message="expected what is on the robot: tags, or a marker",
    ),
]


class Camera(Frozen):
    """A camera over the setup.

    Attributes:
        format: Version of this format.
        camera: Name of the camera.
        description: One-line description.
        source: Where its pictures come from.
        lens: The lens; without it nothing can be measured.
        setup: What is known of the setup.
        robot: What is on the robot.
        latency: How late a picture arrives; taken off the time of its arrival.
        speed: The robot's outside signal that gets the speed along the pipe, which slip is
            measured against.
    """

    format: Format
    camera: Name
    description: str = ""
    source: CameraSource
    lens: Lens | None = None
    setup: Setup
    robot: RobotMarks
    speed: Name | None = None
    latency_s: Annotated[Duration, Field(alias="latency", ge=0, le=2)] = 0.0

    @property
    def marks(self) -> RobotTags | Marker:
        """Return what is on the robot."""
        return self.robot if isinstance(self.robot, RobotTags) else self.robot.marker

    @property
    def modules(self) -> tuple[str, ...]:
        """Return the modules of the robot that it looks for."""
        on = self.marks.on
        return (on,) if isinstance(on, str) else tuple(on.values())
