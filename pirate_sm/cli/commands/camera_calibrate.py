"""`pirate camera calibrate`: measures the lens by a chessboard."""

from __future__ import annotations

import time
from math import inf
from pathlib import Path

from pirate_sm.cli.commands.camera_pictures import find_camera, opened, refuse_shipped
from pirate_sm.cli.options.cameras import CalibrateCameraOptions
from pirate_sm.cli.options.values import read_board
from pirate_sm.cli.output.files import write_file
from pirate_sm.cli.output.progress import progress
from pirate_sm.errors import UsageError
from pirate_sm.loading.camera_text import lens_line, with_lens
from pirate_sm.model.camera import Camera
from pirate_sm.model.camera_source import DeviceSource, SyntheticSource, UrlSource
from pirate_sm.visible import visible
from pirate_sm.vision.calibration import calibrate
from pirate_sm.vision.captures import ImageCapture
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
    used = len(found) - len(result.left_out)
    print(f"{used} boards, off by {result.rms_px:.2f} px (rms)")
    for name, off_px in result.left_out.items():
        print(visible(f"{name} is left out: its corners are off by {off_px:.1f} px"))
    print(lens_line(result.lens))
    if options.write:
        write_file(path, with_lens(path, result.lens))
        print(visible(f"written into {path}; the camera must be surveyed with this lens"))
    return 0


def _collect(
    camera: Camera, path: Path, board: Board, options: CalibrateCameraOptions
) -> dict[str, Floats]:
    """Return the corners of boards at different places, by name, as many as are wanted or found."""
    width = camera.source.size[0]
    is_live = options.images is None and isinstance(camera.source, DeviceSource | UrlSource)
    until_s = time.monotonic() + options.seconds if is_live else inf
    boards: dict[str, Floats] = {}
    with (
        opened(camera, path, options.images) as (capture, first),
        progress("looking for boards: hold it into all parts, tilted to each side") as watch,
    ):
        frame: Frame | None = first
        names = iter(capture.names if isinstance(capture, ImageCapture) else ())
        while frame is not None and len(boards) < options.boards and time.monotonic() < until_s:
            name = next(names, f"board {len(boards) + 1}")
            gray = grayed(frame)
            corners = find_board(gray, board)
            if (
                corners is not None
                and is_another(corners, list(boards.values()), width)
                and is_sharp(gray, corners, board)
            ):
                boards[name] = corners
                watch(len(boards) / options.boards)
            frame = capture.read()
    return boards
