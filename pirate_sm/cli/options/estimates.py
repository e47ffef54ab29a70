"""Options of the commands that estimate and compare: `fit`, `experiment`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from pirate_sm.cli.completion import candidates, named_files
from pirate_sm.cli.options import common


@dataclass(frozen=True, kw_only=True)
class FitOptions:
    """Fit curves of slip and friction to recordings.

    Of each wheel: static and kinetic friction directly, a Magic formula, a Gaussian process, with
    95 % intervals; what the data cannot say is refused with the reason. {} stands for the number of
    a wheel. Several recordings count as one.

    Exit codes: 0 something could be estimated, 1 nothing could, 2 a file cannot be used.
    """

    runs: Annotated[
        list[str],
        typer.Argument(
            metavar="RUN...",
            autocompletion=named_files.recordings_or_tables,
            help="Recordings (.mcap) or tables of signals (.csv).",
        ),
    ]
    robot: Annotated[
        bool,
        typer.Option("--robot", help="Estimate the robot's motors and friction instead."),
    ] = False
    slip: Annotated[
        str,
        typer.Option(
            metavar="SIGNAL", autocompletion=candidates.signals, help="Slip speeds of the wheels."
        ),
    ] = "slip_speed_{}"
    friction: Annotated[
        str,
        typer.Option(
            metavar="SIGNAL",
            autocompletion=candidates.signals,
            help="Friction in use; otherwise |torque| / (r normal).",
        ),
    ] = ""
    torque: Annotated[
        str,
        typer.Option(
            metavar="SIGNAL", autocompletion=candidates.signals, help="Torques of the wheels."
        ),
    ] = "wheel_torque_{}"
    normal: Annotated[
        str,
        typer.Option(
            metavar="SIGNAL", autocompletion=candidates.signals, help="Normal forces of the wheels."
        ),
    ] = "normal_force_{}"
    radius: Annotated[
        str | None,
        typer.Option(metavar="LENGTH", help="Of the wheels; for a recording, its robot's."),
    ] = None
    threshold: Annotated[
        str | None,
        typer.Option(
            metavar="SPEED", help="Slip speed of static friction; otherwise where it is highest."
        ),
    ] = None
    write: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            autocompletion=named_files.files,
            help="Write friction into this pipe file; with --robot: numbers for --twin.",
        ),
    ] = None
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="OUT.html",
            autocompletion=named_files.files,
            help="A page with plots.",
        ),
    ] = None
    csv: Annotated[
        Path | None,
        typer.Option(
            metavar="OUT.csv", autocompletion=named_files.files, help="A table of what was found."
        ),
    ] = None
    overwrite: common.Overwrite = False
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class ExperimentOptions:
    """Repeat the experiments of the thesis.

    Its values are printed beside ours. Each row has a verdict: reproduced, shape only, or not
    reproducible, with the reason.

    Exit codes: 0 every value that can be reproduced is, 1 one is not, 2 a file cannot be used.
    """

    which: Annotated[
        list[str],
        typer.Argument(
            metavar="WHICH...",
            autocompletion=candidates.experiments,
            help="1, 2, 3, one part of them such as 3c, or all.",
        ),
    ]
    robot: common.OneRobot = None
    noise: Annotated[
        str | None, typer.Option(metavar="LEVEL", help="Only this level of noise, such as clean.")
    ] = None
    seeds: Annotated[
        int, typer.Option(min=1, help="Runs of everything random; medians are shown.")
    ] = 3
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="OUT.html",
            autocompletion=named_files.files,
            help="A page with figures.",
        ),
    ] = None
    csv: Annotated[
        Path | None,
        typer.Option(
            metavar="OUT.csv", autocompletion=named_files.files, help="A table of every row."
        ),
    ] = None
    overwrite: common.Overwrite = False
    debug: common.Debug = False
