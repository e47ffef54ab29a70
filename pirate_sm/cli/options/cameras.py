"""Options of `pirate camera`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import typer

from pirate_sm.cli.completion import named_files
from pirate_sm.cli.options import common
from pirate_sm.cli.options.declaring import argument, flag, option

Camera = Annotated[str, argument("CAMERA", named_files.cameras, "Name or path of a camera's file.")]
Inside = Annotated[str, option("NxM", None, "Corners inside of the chessboard.", "--board")]
Square = Annotated[str, option("LENGTH", None, "Sides of its squares.")]
Pictures = Annotated[
    str | None,
    option("FILES", named_files.files, "Pictures in place of the camera, such as 'seen/*.png'."),
]
Write = Annotated[bool, flag("Whether it is put into the camera's file.", "--write/--no-write")]


@dataclass(frozen=True, kw_only=True)
class PrintOptions:
    """Write the chessboard and the tags as sheets to print.

    Exit codes: 0 written, 2 invalid files or arguments.
    """

    camera: Camera
    output: Annotated[
        Path, option("FOLDER", named_files.files, "Where they are written.", "--output", "-o")
    ] = Path()
    board: Inside = "9x6"
    square: Square = "25 mm"
    overwrite: common.Overwrite = False
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class CalibrateCameraOptions:
    """Measure the lens by a chessboard held before the camera.

    It wants at least 15 sharp boards in all parts of the picture, tilted to each side.

    Exit codes: 0 measured, 1 these boards are not enough, 2 invalid files or arguments.
    """

    camera: Camera
    images: Pictures = None
    board: Inside = "9x6"
    square: Square = "25 mm"
    model: Annotated[
        Literal["fisheye", "brown"] | None,
        typer.Option(help="Of the lens; otherwise that in the file, else fisheye."),
    ] = None
    boards: Annotated[int, typer.Option(min=15, help="How many to collect.")] = 25
    seconds: Annotated[float, typer.Option(min=1.0, help="How long to look for them.")] = 180.0
    write: Write = True
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class SurveyOptions:
    """Find where the camera hangs, by tags or points.

    Exit codes: 0 found, 1 what is seen fits no place of it, 2 invalid files or arguments.
    """

    camera: Camera
    images: Pictures = None
    write: Write = True
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class LookOptions:
    """Show what is found in a picture of the camera.

    Exit codes: 0 the robot is seen, 1 it is not, 2 invalid files or arguments.
    """

    camera: Camera
    images: Pictures = None
    robot: common.OneRobot = None
    pipe: Annotated[
        str, option("NAME", named_files.pipes, "In which a synthetic camera sees the robot.")
    ] = "mitre_90"
    output: Annotated[
        Path | None,
        option("OUT", named_files.files, "Write the picture: .png or .jpg.", "--output", "-o"),
    ] = None
    overwrite: common.Overwrite = False
    debug: common.Debug = False
