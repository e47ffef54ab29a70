"""Options that several commands share, each written once.

Each is called for a field: ``debug: bool = common.debug()``.
"""

from __future__ import annotations

from functools import partial

import typer

from pirate_sm import __version__
from pirate_sm.cli.completion import candidates, named_files
from pirate_sm.cli.options.declaring import argument, declared, flag, option, typed


def _print_version(wanted: bool) -> None:
    if wanted:
        from typing import get_args

        from pirate_sm.cli.output.json_lines import FORMAT as LINES
        from pirate_sm.model.base import Format
        from pirate_sm.model.events import ALPHABET_VERSION
        from pirate_sm.recording.format.header import FORMAT as RECORDING

        (number,) = get_args(get_args(Format)[0])
        others = f"JSON {LINES}, recordings {RECORDING}, events {ALPHABET_VERSION}"
        typer.echo(f"pirate-sm {__version__}")
        typer.echo(f"formats: files {number}, {others}")
        raise typer.Exit


VERSION = typer.Option(
    "--version",
    callback=_print_version,
    is_eager=True,
    help="Print the versions of program and formats.",
)
version = partial(declared, VERSION, False)
debug = partial(flag, "Show tracebacks.", "--debug")

a_robot = partial(option, "NAME", named_files.robots)
a_pipe = partial(option, "NAME", named_files.pipes)
robot_of_missions = partial(a_robot, "Robot to use instead of the missions'.", "--robot")
pipe_of_missions = partial(a_pipe, "Pipe to use instead of the missions'.", "--pipe")
one_robot = partial(a_robot, "Robot (default: the first bundled one).", "--robot")
a_speed = partial(option, "max|realtime|FACTOR", candidates.words("max", "realtime"))
settings = partial(
    option, "NAME=VALUE", candidates.parameters, "A parameter's value. Repeatable.", "--set"
)
seed = partial(typed, "Seed of all random numbers.", min=0, default=0)
defects = partial(
    option,
    "NAME[:KEY=VALUE,…]",
    candidates.defects,
    "Switch on a known defect, such as NAME:friction=0.5Nm,after=2s. Repeatable.",
    "--defect",
)
a_port = partial(option, "PORT", candidates.ports)
port = partial(a_port, "/dev/ttyACM0, or a pyserial URL.")
baud = partial(typed, "Rate to use instead of the robot's.", min=1)
guard_for = partial(
    option,
    "DURATION",
    None,
    "How long the port is guarded if the robot does not confirm that it has stopped; 10 min.",
)
calibration = partial(flag, "Use its joint zeros.", "--calibration/--no-calibration", default=True)
check = partial(flag, "Reject missions with errors.", "--check/--no-check", default=True)

recording = partial(argument, "RUN.mcap", named_files.recordings, "A recording.")
output = partial(option, "OUT", named_files.files, "Write to this file.", "--output", "-o")
overwrite = partial(flag, "Replace files that this program did not write.", "--overwrite")
