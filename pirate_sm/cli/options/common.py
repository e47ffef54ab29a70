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
from pirate_sm.cli.options.declaring import argument, flag, option
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
Debug = Annotated[bool, flag("Show tracebacks.", "--debug")]


Backend = Annotated[
    str,
    option(
        "NAME",
        candidates.backends,
        "sim: the kinematic simulator; physics: MuJoCo; bay: the serial link to an emulated "
        "robot; trace: nothing moves; serial: the real robot; others: pirate list backends.",
    ),
]
RobotOfMission = Annotated[
    str | None, option("NAME", named_files.robots, "In place of the mission's own.", "--robot")
]
PipeOfMission = Annotated[
    str | None, option("NAME", named_files.pipes, "In place of the mission's own.", "--pipe")
]
RobotOfMissions = Annotated[
    str | None, option("NAME", named_files.robots, "In place of the missions' own.", "--robot")
]
PipeOfMissions = Annotated[
    str | None, option("NAME", named_files.pipes, "In place of the missions' own.", "--pipe")
]
OneRobot = Annotated[
    str | None, option("NAME", named_files.robots, "Which robot; the first one shipped.", "--robot")
]
Settings = Annotated[
    list[str] | None,
    option("NAME=VALUE", candidates.parameters, "A parameter's value. Repeatable.", "--set"),
]
States = Annotated[
    list[str] | None,
    option(
        "REGION=STATE",
        candidates.states,
        "The robot is in this state, in place of starts_in.",
        "--state",
    ),
]
Seed = Annotated[int, typer.Option(min=0, help="Seed of all random numbers.")]
Defects = Annotated[
    list[str] | None,
    option(
        "NAME[:KEY=VALUE,…]",
        candidates.defects,
        "Switch on a known defect, such as NAME:friction=0.5Nm,after=2s. Repeatable.",
        "--defect",
    ),
]
FidelityOfSim = Annotated[
    Fidelity,
    typer.Option("--fidelity", help="Of sim; fast computes half the iterations and is coarser."),
]
Jitter = Annotated[
    list[str] | None,
    option(
        "NAME=VALUE",
        candidates.words("start=", "friction=", "diameter="),
        "How far a simulated run may differ: start=20mm, friction=20%, diameter=2mm.",
        "--jitter",
    ),
]
LineFault = Annotated[
    list[str] | None,
    option(
        "NAME=VALUE",
        candidates.words(
            "loss_in=",
            "loss_out=",
            "corruption=",
            "delay=",
            "jitter=",
            "reset_every=",
            "cut_after=",
        ),
        "Of bay: loss_in, loss_out, corruption, delay, jitter, reset_every, cut_after.",
        "--line",
    ),
]
View = Annotated[bool, flag("Show the backend physics in MuJoCo's own viewer.", "--view")]
Port = Annotated[str | None, option("PORT", candidates.ports, "/dev/ttyACM0, or a pyserial URL.")]
PortOfRobot = Annotated[
    str | None,
    option(
        "PORT", candidates.ports, "Of the real robot: /dev/ttyACM0, or a pyserial URL.", "--port"
    ),
]
Baud = Annotated[int | None, typer.Option(min=1, help="In place of the robot's own rate.")]
GuardFor = Annotated[
    str | None,
    option(
        "DURATION",
        None,
        "How long the port is guarded if the robot does not confirm that it has stopped; 10 min.",
    ),
]
Detector = Annotated[
    str | None,
    option(
        "sim|odometry|vision:CAMERA|NAME",
        candidates.detectors,
        "What reports where the robot is. For sim: sim, for serial: odometry.",
    ),
]
Also = Annotated[
    str | None,
    option(
        "DETECTOR",
        candidates.detectors,
        "A second detector, to compare: its words are logged and do nothing.",
    ),
]
Panel = Annotated[
    str | None,
    option(
        "NAME[:DEVICE]",
        named_files.panels,
        "A MIDI control panel, with its stop; others: pirate panel.",
        "--panel",
    ),
]
Ruler = Annotated[
    bool, flag("In sim: a ruler outside measures the robot's speed, for slip.", "--ruler")
]
StartAt = Annotated[
    str | None, option("LENGTH", None, "Where the first wheel begins, for odometry.")
]
Calibration = Annotated[
    bool, flag("Whether its joint zeros are used.", "--calibration/--no-calibration")
]
Adopt = Annotated[
    bool, flag("Take a robot that is clamped already as its sensors show it.", "--adopt")
]

Check = Annotated[bool, flag("Whether a faulty mission is refused.", "--check/--no-check")]
Twin = Annotated[
    str | None,
    option(
        "FILE",
        named_files.twins,
        "Numbers of the simulated robot, from pirate fit --robot.",
        "--twin",
    ),
]
Fitted = Annotated[
    str | None,
    option("FILE", named_files.twins, "Numbers of its motors to judge it by, from pirate fit."),
]
NoRecord = Annotated[bool, flag("Record nothing.", "--no-record")]

Recording = Annotated[str, argument("RUN.mcap", named_files.recordings, "A recording.")]
Output = Annotated[
    Path | None, option("OUT", named_files.files, "Write to this file.", "--output", "-o")
]
Overwrite = Annotated[bool, flag("Write over files that may be somebody's work.", "--overwrite")]
