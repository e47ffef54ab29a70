"""`pirate explain`: prints what a code means, or what a control of a robot does."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.checking import catalogue
from pirate_sm.checking.reports.text import explained, listed
from pirate_sm.cli.options.checks import ExplainOptions
from pirate_sm.cli.output.terminal import writable
from pirate_sm.core import library
from pirate_sm.core.errors import UsageError
from pirate_sm.core.events import BUILT_IN_FAULTS
from pirate_sm.core.loading import load_robot
from pirate_sm.core.models import Profile
from pirate_sm.core.spelling import meant
from pirate_sm.core.visible import visible
from pirate_sm.views.drawing.robot_page import control_text


def explain_code(options: ExplainOptions) -> int:
    """Print the text on a code or a control, or the titles of all codes; return the exit code.

    Raises:
        LoadError: The robot has faults; holds all of them.
        UsageError: There is no such code, control or robot.
    """
    code = options.code
    if code is None:
        print(writable(listed()))
        return 0
    known = {**catalogue.entries(), **BUILT_IN_FAULTS}
    if code in known:
        print(writable(explained(code)))
        return 0
    profiles = _profiles(options.robot)
    texts = [control_text(each, code) for each in profiles if code in each.controls]
    if not texts:
        controls = {name for each in profiles for name in each.controls}
        hint = meant(code, {*known, *controls}, "`pirate explain` lists them all")
        raise UsageError(f"there is no code and no control '{code[:100]}': {hint}")
    print(visible("\n\n".join(texts), lines=True))
    return 0


def _profiles(robot: str | None) -> list[Profile]:
    """Return the profile of a robot, or of every shipped one."""
    folders = library.robots() if robot is None else [library.find_robot(robot, Path.cwd())]
    return [load_robot(folder).profile for folder in folders]
