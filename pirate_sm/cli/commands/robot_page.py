"""`pirate robot`: draws a robot and writes a page on what its commands mean."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path

from pirate_sm.checking.findings import settle
from pirate_sm.checking.robot.check_robot import robot_findings
from pirate_sm.cli.options.files import RobotOptions
from pirate_sm.cli.output.files import refuse_losses, write_or_print
from pirate_sm.core import library
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import load_robot
from pirate_sm.core.visible import visible
from pirate_sm.views.drawing.robot_page import html as as_html
from pirate_sm.views.drawing.robot_page import markdown, robot_page
from pirate_sm.views.drawing.side_view import side_view
from pirate_sm.views.drawing.side_view_svg import side_svg


def write_page(options: RobotOptions) -> int:
    """Write the robot's page, or its picture alone, and return the exit code.

    Raises:
        LoadError: The robot's files have errors.
        UsageError: There is no such robot, or the file cannot be written.
    """
    name, output = options.name, options.output
    folder = library.find_robot(name, Path.cwd())
    refuse_losses([output], inputs=[folder], overwrite=options.overwrite)
    alone = output is not None and output.suffix.lower() == ".svg"
    if alone and options.html:
        raise UsageError(f"'{output}' is a picture, --html writes a page: leave one of them out")
    loaded = load_robot(folder)
    found = robot_findings(loaded)
    # What follows them is about the comments.
    settled = settle(found, {each.name: each.text for each in loaded.documents})[: len(found)]
    wrong = (each for each in settled if not each.allowed)
    faults = {
        place: "; ".join(f"[{each.code}] {each.message}" for each in here)
        for place, here in groupby(wrong, key=lambda each: each.place)
    }
    note = f"Written by `pirate robot {loaded.profile.robot}` from the robot's profile and chart."
    if alone:
        text = side_svg(side_view(loaded, faults))
    elif options.html:
        text = as_html(robot_page(loaded, faults))
    else:
        text = markdown(robot_page(loaded, faults), note)
    write_or_print(output, visible(text, lines=True) if output is None else text)
    return 0
