"""`pirate robot`: what a robot's commands mean, as a page."""

from __future__ import annotations

import sys
from pathlib import Path

from pirate_sm.drawing.page import html as as_html
from pirate_sm.drawing.page import markdown
from pirate_sm.drawing.robot_page import robot_page
from pirate_sm.errors import UsageError
from pirate_sm.loading import library
from pirate_sm.loading.robot import load_robot
from pirate_sm.visible import visible


def write_page(name: str | None, output: Path | None, *, html: bool = False) -> int:
    """The page stands in the file, or on standard output.

    Args:
        name: Name or path of the robot; None for the first one that is shipped.
        output: The file; None for standard output.
        html: Whether it is written as HTML.

    Raises:
        LoadError: The robot's files have faults.
        UsageError: There is no such robot, or the file cannot be written.
    """
    folder = library.robots()[0] if name is None else library.find_robot(name, Path.cwd())
    loaded = load_robot(folder)
    blocks = robot_page(loaded)
    note = f"Written by `pirate robot {loaded.profile.robot}` from the robot's profile and chart."
    text = as_html(blocks) if html else markdown(blocks, note)
    if output is None:
        sys.stdout.write(visible(text, lines=True))
        return 0
    try:
        output.write_text(text, encoding="utf-8")
    except OSError as error:
        raise UsageError(f"'{output}' cannot be written: {error.strerror}") from None
    return 0
