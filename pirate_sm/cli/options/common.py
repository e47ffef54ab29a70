"""Options that several commands share, each written once.

An option is an annotated type: the type of its value, its name if that differs from the field's,
and its help text.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pirate_sm import __version__
from pirate_sm.cli.completion import candidates, named_files
from pirate_sm.model.fidelity import Fidelity


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


Version = Annotated[
    bool,
    typer.Option(
        "--version",
        callback=_print_version,
        is_eager=True,
        help="Print the versions of program and formats.",
    ),
]
Debug = Annotated[bool, typer.Option("--debug", help="Show tracebacks.")]


Backend = Annotated[
    str,
    typer.Option(
        metavar="NAME",
        autocompletion=candidates.backends,
        help="sim: the kinematic simulator; physics: MuJoCo; bay: the serial link to an emulated "
        "robot; trace: nothing moves; serial: the real robot; others: pirate list backends.",
    ),
]
RobotOfMission = Annotated[
    str | None,
    typer.Option(
        "--robot",
        metavar="NAME",
        autocompletion=named_files.robots,
        help="In place of the mission's own.",
    ),
]
PipeOfMission = Annotated[
    str | None,
    typer.Option(
        "--pipe",
        metavar="NAME",
        autocompletion=named_files.pipes,
        help="In place of the mission's own.",
    ),
]
RobotOfMissions = Annotated[
    str | None,
    typer.Option(
        "--robot",
        metavar="NAME",
        autocompletion=named_files.robots,
        help="In place of the missions' own.",
    ),
]
PipeOfMissions = Annotated[
    str | None,
    typer.Option(
        "--pipe",
        metavar="NAME",
        autocompletion=named_files.pipes,
        help="In place of the missions' own.",
    ),
]
OneRobot = Annotated[
    str | None,
    typer.Option(
        "--robot",
        metavar="NAME",
        autocompletion=named_files.robots,
        help="Which robot; the first one shipped.",
    ),
]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        autocompletion=candidates.parameters,
        help="A parameter's value. Repeatable.",
    ),
]
States = Annotated[
    list[str] | None,
    typer.Option(
        "--state",
        metavar="REGION=STATE",
        autocompletion=candidates.states,
        help="The robot is in this state, in place of starts_in.",
    ),
]
Seed = Annotated[int, typer.Option(min=0, help="Seed of all random numbers.")]
Defects = Annotated[
    list[str] | None,
    typer.Option(
        "--defect",
        metavar="NAME[:KEY=VALUE,…]",
        autocompletion=candidates.defects,
        help="Switch on a known defect, such as NAME:friction=0.5Nm,after=2s. Repeatable.",
    ),
]
FidelityOfSim = Annotated[
    Fidelity,
    typer.Option("--fidelity", help="Of sim; fast computes half the iterations and is coarser."),
]
Jitter = Annotated[
    list[str] | None,
    typer.Option(
        "--jitter",
        metavar="NAME=VALUE",
        autocompletion=candidates.words("start=", "friction=", "diameter="),
        help="How far a simulated run may differ: start=20mm, friction=20%, diameter=2mm.",
    ),
]
LineFault = Annotated[
    list[str] | None,
    typer.Option(
        "--line",
        metavar="NAME=VALUE",
        autocompletion=candidates.words(
            "loss_in=",
            "loss_out=",
            "corruption=",
            "delay=",
            "jitter=",
            "reset_every=",
            "cut_after=",
        ),
        help="Of bay: loss_in, loss_out, corruption, delay, jitter, reset_every, cut_after.",
    ),
]
View = Annotated[
    bool, typer.Option("--view", help="Show the backend physics in MuJoCo's own viewer.")
]
Port = Annotated[
    str | None,
    typer.Option(
        metavar="PORT", autocompletion=candidates.ports, help="/dev/ttyACM0, or a pyserial URL."
    ),
]
PortOfRobot = Annotated[
    str | None,
    typer.Option(
        "--port",
        metavar="PORT",
        autocompletion=candidates.ports,
        help="Of the real robot: /dev/ttyACM0, or a pyserial URL.",
    ),
]
Baud = Annotated[int | None, typer.Option(min=1, help="In place of the robot's own rate.")]
GuardFor = Annotated[
    str | None,
    typer.Option(
        metavar="DURATION",
        help="How long the port is guarded if the robot does not confirm that it has stopped; "
        "10 min.",
    ),
]
Detector = Annotated[
    str | None,
    typer.Option(
        metavar="sim|odometry|vision:CAMERA|NAME",
        autocompletion=candidates.detectors,
        help="What reports where the robot is. For sim: sim, for serial: odometry.",
    ),
]
Also = Annotated[
    str | None,
    typer.Option(
        metavar="DETECTOR",
        autocompletion=candidates.detectors,
        help="A second detector, to compare: its words are logged and do nothing.",
    ),
]
Panel = Annotated[
    str | None,
    typer.Option(
        "--panel",
        metavar="NAME[:DEVICE]",
        autocompletion=named_files.panels,
        help="A MIDI control panel, with its stop; others: pirate panel.",
    ),
]
Ruler = Annotated[
    bool,
    typer.Option("--ruler", help="In sim: a ruler outside measures the robot's speed, for slip."),
]
StartAt = Annotated[
    str | None,
    typer.Option(metavar="LENGTH", help="Where the first wheel begins, for odometry."),
]
Calibration = Annotated[
    bool,
    typer.Option("--calibration/--no-calibration", help="Whether its joint zeros are used."),
]
Check = Annotated[
    bool, typer.Option("--check/--no-check", help="Whether a faulty mission is refused.")
]
Twin = Annotated[
    str | None,
    typer.Option(
        "--twin",
        metavar="FILE",
        autocompletion=named_files.twins,
        help="Numbers of the simulated robot, from pirate fit --robot.",
    ),
]
NoRecord = Annotated[bool, typer.Option("--no-record", help="Record nothing.")]

Recording = Annotated[
    str,
    typer.Argument(metavar="RUN.mcap", autocompletion=named_files.recordings, help="A recording."),
]
Output = Annotated[
    Path | None,
    typer.Option(
        "--output",
        "-o",
        metavar="OUT",
        autocompletion=named_files.files,
        help="Write to this file.",
    ),
]
Overwrite = Annotated[
    bool, typer.Option("--overwrite", help="Write over files that may be somebody's work.")
]
