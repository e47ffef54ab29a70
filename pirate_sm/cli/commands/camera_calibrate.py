"""`pirate camera calibrate`: measures the lens by a chessboard."""

from __future__ import annotations

import time
from pathlib import Path

from pirate_sm.cli.commands.camera_pictures import find_camera, opened, refuse_shipped
from pirate_sm.cli.options.cameras import CalibrateCameraOptions
from pirate_sm.cli.options.values import read_board
from pirate_sm.cli.output.files import write_file
from pirate_sm.cli.output.progress import progress
from pirate_sm.errors import UsageError
from pirate_sm.loading.camera_text import lens_line, with_lens
from pirate_sm.model.camera import Camera
from pirate_sm.model.camera_source import SyntheticSource
from pirate_sm.visible import visible
from pirate_sm.vision.calibration import calibrate
from pirate_sm.vision.chessboard import Board, find_board, is_another, is_sharp
from pirate_sm.vision.picture_arrays import Floats, Frame
from pirate_sm.vision.tags import grayed

UNKNOWN = 1


def calibrate_camera(options: CalibrateCameraOptions) -> int:
    """Collect boards, print the lens and write it into the camera's file; return the exit code.

    Raises:
        LoadError: The camera's file has faults.
        UsageError: There are no pictures, or the file cannot be written.
    """
    camera, path = find_camera(options.camera)
    if options.write:
        refuse_shipped(path)
    if isinstance(camera.source, SyntheticSource) and options.images is None:
        raise UsageError("a synthetic camera has no lens to measure: give pictures with --images")
    board = Board(*read_board(options.board, options.square))
    found = _collect(camera, path, board, options)
    model = options.model or (camera.lens.model if camera.lens else "fisheye")
    result = calibrate(found, board, camera.source.size, model)
    if isinstance(result, str):
        print(visible(f"nothing is measured: {result}"))
        return UNKNOWN
    print(f"{len(found)} boards, off by {result.rms_px:.2f} px (rms)")
    print(lens_line(result.lens))
    if options.write:
        write_file(path, with_lens(path, result.lens))
        print(visible(f"written into {path}; the camera must be surveyed with this lens"))
    return 0


def _collect(
    camera: Camera, path: Path, board: Board, options: CalibrateCameraOptions
) -> list[Floats]:
    """Return the corners of boards at different places, as many as are wanted or found."""
    width = camera.source.size[0]
    until_s = time.monotonic() + options.seconds
    boards: list[Floats] = []
    with (
        opened(camera, path, options.images) as (capture, first),
        progress("looking for boards: hold it into all parts, tilted to each side") as watch,
    ):
        frame: Frame | None = first
        while frame is not None and len(boards) < options.boards and time.monotonic() < until_s:
            gray = grayed(frame)
            corners = find_board(gray, board)
            if (
                corners is not None
                and is_another(corners, boards, width)
                and is_sharp(gray, corners, board)
            ):
                boards.append(corners)
                watch(len(boards) / options.boards)
            frame = capture.read()
    return boards
