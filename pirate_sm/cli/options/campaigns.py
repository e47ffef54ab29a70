"""Options of `pirate campaign`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from pirate_sm.cli.completion import candidates, named_files
from pirate_sm.cli.options import common
from pirate_sm.cli.options.declaring import argument, flag, option, typed
from pirate_sm.cli.options.of_runs import of_run

_MOST_SEEDS = 10**9
"""As in a campaign file, whose model a help text does not import."""


@dataclass(frozen=True, kw_only=True)
class CampaignOptions:
    """Run missions many times and count successes.

    A success counts if the ground truth agrees. A campaign file says which missions, pipes,
    defects and parameters; of a mission, --seeds says how often. Results are kept in a folder,
    which the last line names: `pirate report FOLDER` writes a page of them, `pirate compare A B`
    says whether B is worse.

    Exit codes: 0 as expected, 1 a cell is not as expected or this program has a fault, 2 invalid
    files or arguments, or results cannot be kept, 3 the workers are lost, 130 interrupted.
    """

    campaign: str = argument(
        "FILE|MISSION", named_files.campaigns, "A campaign file, or a mission: name or file."
    )
    seeds: int | None = typed(
        "Seeds 0 to N-1, instead of the file's.", min=1, max=_MOST_SEEDS, metavar="N"
    )
    cells: list[str] | None = option(
        "NAME", candidates.cells, "Only the cells of this name. Repeatable.", "--cell"
    )
    workers: int | None = typed(
        "Processes that are started; one each processor.", min=1, metavar="N"
    )
    scheduler: str | None = option("ADDRESS", None, "An existing Dask cluster: tcp://host:8786.")
    resume: bool = flag("Keep existing results and run what is missing.", "--resume")
    output: Path | None = option(
        "FOLDER", named_files.folders, "For the results; runs/NAME.campaign.", "--output", "-o"
    )
    record: Literal["first", "all", "none"] = typed(
        "Which failed runs are repeated with a recording: first of each cause.",
        "--record",
        default="first",
    )
    format: Literal["text", "json", "junit"] = typed(
        "What is written to standard output.", "--format", default="text"
    )
    check: bool = of_run("check")
    debug: bool = common.debug()
