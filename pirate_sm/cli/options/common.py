"""Options that several commands share, each written once.

Each is called for a field: ``debug: bool = common.debug()``.
"""

from __future__ import annotations

from functools import partial

import typer

from pirate_sm import __version__
from pirate_sm.cli.completion import candidates, named_files
from pirate_sm.cli.options.declaring import argument, declared, flag, option


def _print_version(wanted: bool) -> None:
    if wanted:
        from typing import get_args

        from pirate_sm.cli.output.json_lines import FORMAT as LINES
        from pirate_sm.core.events import ALPHABET_VERSION
        from pirate_sm.core.profile import Format
        from pirate_sm.running.recording.format.header import FORMAT as RECORDING

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
at = partial(option, "PHASE", candidates.phases, "With --resume: continue with this phase.", "--at")
port = partial(option, "PORT", candidates.ports, "/dev/ttyACM0, or a pyserial URL.")

recording = partial(argument, "RUN.mcap", named_files.recordings, "A recording.")
output = partial(option, "OUT", named_files.files, "Write to this file.", "--output", "-o")
overwrite = partial(flag, "Replace files that this program did not write.", "--overwrite")
