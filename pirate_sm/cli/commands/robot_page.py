"""`pirate robot`: writes a page on what a robot's commands mean."""

from __future__ import annotations

import sys
from pathlib import Path

from pirate_sm.cli.options.files import RobotOptions
from pirate_sm.cli.output.files import refuse_losses, write_file
from pirate_sm.drawing.robot.robot_page import robot_page
from pirate_sm.drawing.robot.written_page import html as as_html
from pirate_sm.drawing.robot.written_page import markdown
from pirate_sm.loading import library
from pirate_sm.loading.robot import load_robot
from pirate_sm.visible import visible


def write_page(options: RobotOptions) -> int:
    """Write the robot's page to the file, or to standard output; return the exit code.

    Raises:
        LoadError: The robot's files have errors.
        UsageError: There is no such robot, or the file cannot be written.
    """
    name, output = options.name, options.output
    folder = library.robots()[0] if name is None else library.find_robot(name, Path.cwd())
    if output is not None:
        refuse_losses([output], inputs=[folder], overwrite=options.overwrite)
    loaded = load_robot(folder)
    blocks = robot_page(loaded)
    note = f"Written by `pirate robot {loaded.profile.robot}` from the robot's profile and chart."
    text = as_html(blocks) if options.html else markdown(blocks, note)
    if output is None:
        sys.stdout.write(visible(text, lines=True))
        return 0
    write_file(output, text)
    return 0
