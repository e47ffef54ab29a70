"""Options of `pirate camera`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Literal

from pirate_sm.cli.completion import named_files
from pirate_sm.cli.options import common
from pirate_sm.cli.options.declaring import argument, flag, option, typed

camera_file = partial(argument, "CAMERA", named_files.cameras, "Name or path of a camera's file.")
inside = partial(option, "NxM", None, "Corners inside of the chessboard.", "--board", default="9x6")
square_sides = partial(option, "LENGTH", None, "Sides of its squares.", default="25 mm")
pictures = partial(
    option, "FILES", named_files.files, "Images instead of the camera, such as 'seen/*.png'."
)
writes = partial(flag, "Write it into the camera's file.", "--write/--no-write", default=True)


@dataclass(frozen=True, kw_only=True)
class PrintOptions:
    """Write the chessboard and the tags as sheets to print.

    Exit codes: 0 written, 2 invalid files or arguments.
    """

    camera: str = camera_file()
    output: Path = option(
        "FOLDER", named_files.files, "Where they are written.", "--output", "-o", default=Path()
    )
    board: str = inside()
    square: str = square_sides()
    overwrite: bool = common.overwrite()
    debug: bool = common.debug()


@dataclass(frozen=True, kw_only=True)
class CalibrateCameraOptions:
    """Measure the lens by a chessboard held before the camera.

    It wants at least 15 sharp boards in all parts of the picture, tilted to each side.

    Exit codes: 0 measured, 1 these boards are not enough, 2 invalid files or arguments.
    """

    camera: str = camera_file()
    images: str | None = pictures()
    board: str = inside()
    square: str = square_sides()
    model: Literal["fisheye", "brown"] | None = typed(
        "Of the lens; otherwise that in the file, else fisheye."
    )
    boards: int = typed("How many to collect.", min=15, default=25)
    seconds: float = typed("How long a live camera looks for them.", min=1.0, default=180.0)
    write: bool = writes()
    debug: bool = common.debug()


@dataclass(frozen=True, kw_only=True)
class SurveyOptions:
    """Find where the camera hangs, by tags or points.

    Exit codes: 0 found, 1 what is seen fits no place of it, 2 invalid files or arguments.
    """

    camera: str = camera_file()
    images: str | None = pictures()
    write: bool = writes()
    debug: bool = common.debug()


@dataclass(frozen=True, kw_only=True)
class LookOptions:
    """Show what is found in a picture of the camera.

    Exit codes: 0 the robot is seen, 1 it is not, 2 invalid files or arguments.
    """

    camera: str = camera_file()
    images: str | None = pictures()
    robot: str | None = common.one_robot()
    pipe: str = common.a_pipe("In which a synthetic camera sees the robot.", default="mitre_90")
    output: Path | None = option(
        "OUT", named_files.files, "Write the picture: .png or .jpg.", "--output", "-o"
    )
    overwrite: bool = common.overwrite()
    debug: bool = common.debug()
