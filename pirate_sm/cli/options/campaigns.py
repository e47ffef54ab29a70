"""Options of `pirate campaign`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import typer

from pirate_sm.cli.completion import candidates, named_files
from pirate_sm.cli.options import common
from pirate_sm.cli.options.declaring import argument, flag, option

_MOST_SEEDS = 10**9
"""As in a campaign file, whose model a help text does not import."""


@dataclass(frozen=True, kw_only=True)
class CampaignOptions:
    """Run missions many times and count successes.

    A success counts if the simulator's truth agrees. A campaign file says which missions, pipes,
    defects and parameters; of a mission, --seeds says how often. Results are kept in a folder,
    which the last line names: `pirate report FOLDER` writes a page of them, `pirate compare A B`
    says whether B is worse.

    Exit codes: 0 as expected, 1 a cell is not as expected or this program has a fault, 2 invalid
    files or arguments, or results cannot be kept, 3 the workers are lost, 130 interrupted.
    """

    campaign: Annotated[
        str,
        argument(
            "FILE|MISSION", named_files.campaigns, "A campaign file, or a mission: name or file."
        ),
    ]
    seeds: Annotated[
        int | None,
        typer.Option(
            min=1, max=_MOST_SEEDS, metavar="N", help="Seeds 0 to N-1, in place of the file's."
        ),
    ] = None
    cells: Annotated[
        list[str] | None,
        option("NAME", candidates.cells, "Only the cells of this name. Repeatable.", "--cell"),
    ] = None
    workers: Annotated[
        int | None,
        typer.Option(min=1, metavar="N", help="Processes that are started; one each processor."),
    ] = None
    scheduler: Annotated[
        str | None, option("ADDRESS", None, "An existing Dask cluster: tcp://host:8786.")
    ] = None
    resume: Annotated[bool, flag("Go on with the results that are there.", "--resume")] = False
    output: Annotated[
        Path | None,
        option(
            "FOLDER", named_files.folders, "For the results; runs/NAME.campaign.", "--output", "-o"
        ),
    ] = None
    record: Annotated[
        Literal["first", "all", "none"],
        typer.Option(
            "--record", help="Which failed runs are repeated with a recording: first of each cause."
        ),
    ] = "first"
    format: Annotated[
        Literal["text", "json", "junit"],
        typer.Option("--format", help="What is written to standard output."),
    ] = "text"
    check: common.Check = True
    debug: common.Debug = False
