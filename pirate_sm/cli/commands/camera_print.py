"""`pirate camera print`: writes the chessboard and the tags of a camera as sheets to print."""

from __future__ import annotations

from collections.abc import Iterator

from pirate_sm.cli.commands.camera_pictures import find_camera
from pirate_sm.cli.options.cameras import PrintOptions
from pirate_sm.cli.options.values import read_board
from pirate_sm.cli.output.files import refuse_losses, write_file
from pirate_sm.errors import UsageError
from pirate_sm.model.camera import Camera, RobotTags
from pirate_sm.visible import visible
from pirate_sm.vision.chessboard import Board
from pirate_sm.vision.printing import board_sheet, tag_sheets


def print_sheets(options: PrintOptions) -> int:
    """Write the sheets and print their names; return the exit code.

    Raises:
        LoadError: The camera's file has faults.
        UsageError: A file cannot be written, or would overwrite somebody's work.
    """
    camera, _ = find_camera(options.camera)
    board = Board(*read_board(options.board, options.square))
    sheets = {
        options.output / f"{camera.camera}_{name}.svg": sheet
        for name, sheet in _sheets(camera, board)
    }
    refuse_losses(sheets, overwrite=options.overwrite)
    try:
        options.output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"'{options.output}' cannot be made: {error.strerror}") from None
    for place, sheet in sheets.items():
        write_file(place, sheet)
        print(visible(str(place)))
    return 0


def _sheets(camera: Camera, board: Board) -> Iterator[tuple[str, str]]:
    yield "board", board_sheet(board)
    setup, robot = camera.setup, camera.robot
    if setup.tags is not None and setup.size is not None:
        tags = [
            (number, ", ".join(f"{1000 * each:g}" for each in place) + " mm")
            for number, place in setup.at.items()
        ]
        for page, sheet in enumerate(tag_sheets(setup.tags, setup.size, tags), start=1):
            yield f"setup_{page}", sheet
    if isinstance(robot, RobotTags):
        for page, sheet in enumerate(
            tag_sheets(robot.tags, robot.size, list(robot.on.items())), start=1
        ):
            yield f"robot_{page}", sheet
