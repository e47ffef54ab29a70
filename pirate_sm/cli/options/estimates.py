"""Options of the commands that estimate and compare: `campaign`, `fit`, `experiment`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Literal

from pirate_sm.cli.completion import candidates
from pirate_sm.cli.options import common
from pirate_sm.cli.options.common import of_run
from pirate_sm.cli.options.declaring import CommandOptions, argument, flag, option, typed


@dataclass(frozen=True, kw_only=True)
class FitOptions(CommandOptions):
    """Fit curves of slip and friction to recordings.

    Of each wheel: static and kinetic friction directly, a Magic formula, a Gaussian process, with
    95 % intervals; what the data cannot say is refused with the reason. {} stands for the number of
    a wheel. Several recordings count as one.

    Exit codes: 0 something could be estimated, 1 nothing could, 2 a file cannot be used.
    """

    runs: list[str] = argument(
        "RUN...",
        candidates.recordings_or_tables,
        "Recordings (.mcap) or tables of signals (.csv).",
    )
    robot: bool = flag("Estimate the robot's motors and friction instead.", "--robot")
    slip: str = option(
        "SIGNAL", candidates.signals, "Slip speeds of the wheels.", default="slip_speed_{}"
    )
    friction: str = option(
        "SIGNAL",
        candidates.signals,
        "Friction in use; otherwise |torque| / (r normal).",
        default="",
    )
    torque: str = option(
        "SIGNAL", candidates.signals, "Torques of the wheels.", default="wheel_torque_{}"
    )
    normal: str = option(
        "SIGNAL", candidates.signals, "Normal forces of the wheels.", default="normal_force_{}"
    )
    radius: str | None = option("LENGTH", None, "Of the wheels; for a recording, its robot's.")
    threshold: str | None = option(
        "SPEED", None, "Slip speed of static friction; otherwise where it is highest."
    )
    write: Path | None = option(
        "FILE",
        candidates.files,
        "Write friction into this pipe file; with --robot: numbers for --twin.",
    )
    output: Path | None = option(
        "OUT.html", candidates.files, "A page with plots.", "--output", "-o"
    )
    csv: Path | None = option("OUT.csv", candidates.files, "A table of what was found.")
    predict: bool = flag(
        "With --robot: fit the first half of a recording and predict the second.", "--predict"
    )
    advise: bool = flag(
        "With --robot: list shipped missions by what a recording is expected to show.",
        "--advise",
    )
    robots: int | None = typed(
        "Robots to simulate (default: 64 for --predict, at least 19; 4 for --advise).",
        min=2, max=200, metavar="N",
    )  # fmt: skip
    workers: int | None = typed("Processes that simulate; one each processor.", min=1, metavar="N")
    format: Literal["text", "json"] = typed(
        "What --predict and --advise write to standard output.", "--format", default="text"
    )
    overwrite: bool = common.overwrite()


@dataclass(frozen=True, kw_only=True)
class ExperimentOptions(CommandOptions):
    """Repeat the experiments of the thesis.

    Its values are printed next to ours, each with the band that the thesis's own spread leaves.
    Verdicts: predicted, assumed (as predicted, by a number that was not measured),
    consistent with no effect, input, contradicted, not measured, not modelled, impossible, ours
    alone.

    Exit codes: 0 no value is contradicted or not measured, 1 one is, 2 a file cannot be used.
    """

    which: list[str] = argument(
        "WHICH...", candidates.experiments, "1, 2, 3, one part of them such as 3c, or all."
    )
    robot: str | None = common.one_robot()
    noise: str | None = option("LEVEL", None, "Only this level of noise, such as clean.")
    seeds: int = typed("Runs of everything random; medians are shown.", min=1, default=3)
    output: Path | None = option(
        "OUT.html", candidates.files, "A page with figures.", "--output", "-o"
    )
    csv: Path | None = option("OUT.csv", candidates.files, "A table of every row.")
    format: Literal["text", "json"] = typed(
        "What is written to standard output.", "--format", default="text"
    )
    overwrite: bool = common.overwrite()


_MOST_SEEDS = 10**9
"""As in a campaign file, whose model a help text does not import."""


_workers = partial(typed, "Processes that are started; one each processor.", min=1, metavar="N")
_scheduler = partial(option, "ADDRESS", None, "An existing Dask cluster: tcp://host:8786.")
_resume = partial(flag, "Keep existing results and run what is missing.", "--resume")
_results = partial(
    option, "FOLDER", candidates.folders, "For the results; runs/NAME.campaign.", "--output", "-o"
)


@dataclass(frozen=True, kw_only=True)
class CampaignOptions(CommandOptions):
    """Run missions many times and count successes.

    A success counts if the ground truth agrees. A campaign file says which missions, pipes,
    defects and parameters; of a mission, --seeds says how often. Results are kept in a folder,
    which the last line names: `pirate report FOLDER` writes a page of them, `pirate compare A B`
    says whether B is worse.

    Exit codes: 0 as expected, 1 a cell is not as expected or this program has a fault, 2 invalid
    files or arguments, or results cannot be kept, 3 the workers are lost, 130 interrupted.
    """

    campaign: str = argument(
        "FILE|MISSION", candidates.campaigns, "A campaign file, or a mission: name or file."
    )
    seeds: int | None = typed(
        "Seeds 0 to N-1, instead of the file's.", min=1, max=_MOST_SEEDS, metavar="N"
    )
    cells: list[str] | None = option(
        "NAME", candidates.cells, "Only the cells of this name. Repeatable.", "--cell"
    )
    workers: int | None = _workers()
    scheduler: str | None = _scheduler()
    resume: bool = _resume()
    output: Path | None = _results()
    record: Literal["first", "all", "none"] = typed(
        "Which failed runs are repeated with a recording: first of each cause.",
        "--record",
        default="first",
    )
    format: Literal["text", "json", "junit"] = typed(
        "What is written to standard output.", "--format", default="text"
    )
    check: bool = of_run("check")


@dataclass(frozen=True, kw_only=True)
class MarginsOptions(CommandOptions):
    """Find how far a mission holds in other conditions.

    Each factor is changed, both ways from its value in the files, until fewer than --share of the
    runs pass by the ground truth. What is tried next depends on what was found, and each value ends
    with as few runs as its test needs. The mission does not know of the change. A campaign file
    says all this with `margins`, also for several missions and pipes, and what is expected.
    `pirate report FOLDER` draws the result.

    Exit codes: 0 held as expected, 1 not, or this program has a fault, 2 invalid files or
    arguments, or results cannot be kept, 3 the workers are lost, 130 interrupted.
    """

    mission: str = argument("MISSION", candidates.missions, "Name or file.")
    pipe: str | None = common.a_pipe("Pipe to use instead of the mission's.", "--pipe")
    factors: list[str] | None = option(
        "NAME[=LOW..HIGH]",
        candidates.factors,
        "What is changed: friction, tilt=0deg..30deg, sticks:after=0s..70s. Repeatable.",
        "--factor",
    )
    pairs: list[str] | None = option(
        "NAME,NAME", None, "Make a map of two of the factors. Repeatable.", "--pair"
    )
    expects: list[str] | None = option(
        "NAME>=VALUE", None, "How far it must hold: friction>=0.35. Repeatable.", "--expect"
    )
    share: str = option("SHARE", None, "The share of runs that must pass.", default="90 %")
    confidence: str = option("SHARE", None, "How sure each edge is.", default="95 %")
    runs: int = typed("Runs at one value, at most.", default=200, min=10, max=1000, metavar="N")
    levels: int = typed(
        "Values that are tried on each side first.", default=4, min=1, max=50, metavar="N"
    )
    halvings: int = typed(
        "How often the distance behind the last one that holds is halved.",
        default=3, min=0, max=10, metavar="N",
    )  # fmt: skip
    falsify: bool = flag(
        "Instead, search for the smallest change of all factors with which it fails.", "--falsify"
    )
    budget: int = typed("With --falsify: runs, about.", default=300, min=20, metavar="N")
    within: str = option(
        "SHARE", None, "With --falsify: how much of each range is searched.", default="100 %"
    )
    seed: int = typed("With --falsify: of each run and of the search.", default=0, min=0)
    workers: int | None = _workers()
    scheduler: str | None = _scheduler()
    resume: bool = _resume()
    output: Path | None = _results()
    format: Literal["text", "json", "junit"] = typed(
        "What is written to standard output.", "--format", default="text"
    )
    check: bool = of_run("check")
