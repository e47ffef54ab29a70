"""`pirate firmware`: writes a robot's tables for the firmware of its controller."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.cli.options.files import FirmwareOptions
from pirate_sm.cli.output.files import refuse_losses, write_or_print
from pirate_sm.core import library
from pirate_sm.core.loading import load_robot
from pirate_sm.robot.backends.serial.assembly import read_plan
from pirate_sm.robot.backends.serial.firmware_tables import firmware_header


def write_tables(options: FirmwareOptions) -> int:
    """Write the header of C++, and return the exit code.

    Raises:
        LoadError: The robot's files have errors.
        UsageError: There is no such robot, the firmware cannot be its, or the file cannot be
            written.
    """
    folder = library.find_robot(options.robot, Path.cwd())
    refuse_losses([options.output], inputs=[folder], overwrite=options.overwrite)
    robot = load_robot(folder)
    plan = read_plan(robot.folder, robot.profile, robot.normal)
    write_or_print(options.output, firmware_header(robot.profile, plan))
    return 0
