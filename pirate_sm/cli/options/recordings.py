"""Options of the commands that read recordings."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pirate_sm.cli.completion import candidates
from pirate_sm.cli.options import common
from pirate_sm.cli.options.declaring import CommandOptions, argument, flag, option, typed


@dataclass(frozen=True, kw_only=True)
class ReplayOptions(CommandOptions):
    """Replay a recording and report whether the result is the same.

    Exit codes: 0 the same, 1 different, 2 it cannot be read or contains nothing to replay.
    """

    recording: str = common.recording()
    mission: str | None = option(
        "MISSION", candidates.missions, "Mission to use instead of the recording's."
    )
    robot: str | None = common.a_robot("With --mission: the robot.")
    pipe: str | None = common.a_pipe("With --mission: the pipe.")
    begin: str | None = option("TIME", None, "Begin at the checkpoint before this time.", "--from")
    until: str | None = option("TIME", None, "End at this time.")
    jobs: int | None = typed("Processes; all processors where it is long.", "--jobs", "-j", min=1)


@dataclass(frozen=True, kw_only=True)
class CompareOptions(CommandOptions):
    """Compare two recorded runs, or two campaigns.

    Runs are aligned by the mission's progress. Campaigns, folders with their results, are compared
    cell by cell: by McNemar's exact test where seeds are the same, else by Fisher's.

    Exit codes: 0 the same course, or B is not worse; 1 they part, or B is worse; 2 one cannot be
    read, or results of a campaign are damaged.
    """

    first: str = argument(
        "A", candidates.recordings, "A recording, or the folder of a campaign's results."
    )
    second: str = argument("B", candidates.recordings, "Another one.")


@dataclass(frozen=True, kw_only=True)
class ForecastOptions(CommandOptions):
    """Say how long phases of a mission take, from earlier runs.

    Runs count that succeeded, of the same text of mission, robot and pipe as the newest recording,
    with the same parameters, on the same backend. With --rehearse, a mission or a campaign is run
    instead. `pirate run --forecast FILE` warns when a phase is slower.

    Exit codes: 0 there are enough runs, 1 too few of them for any phase, 2 nothing can be used.
    """

    paths: list[str] = argument(
        "PATH...",
        candidates.coverable,
        "Recordings and folders of them; with --rehearse a mission or a campaign.",
    )
    output: Path | None = option("FILE", candidates.files, "For --forecast.", "--output", "-o")
    rehearse: int = typed(
        "Run it in the simulator with so many seeds.", "--rehearse", min=0, default=0, metavar="N"
    )
    cell: str | None = option("NAME", candidates.cells, "Of a campaign with several.", "--cell")
    mission: str | None = option(
        "NAME", candidates.missions, "Count recordings of this mission only.", "--mission"
    )
    signals: bool = flag("Also bands of what a report plots; each run is replayed.", "--signals")
    overwrite: bool = common.overwrite()


@dataclass(frozen=True, kw_only=True)
class ExportOptions(CommandOptions):
    """Write a recording for other programs."""

    recording: str = common.recording()
    csv: str | None = option("DIR", candidates.folders, "One table for each topic, SI units.")
    parquet: str | None = option("DIR", candidates.folders, "The same tables as Parquet files.")
    viewers: str | None = option(
        "OUT.mcap", candidates.files, "The recording with all that viewers can show."
    )
    ros2: str | None = option(
        "DIR", candidates.folders, "A bag of ROS 2: joints, frames, log, URDF."
    )
    urdf: str | None = option("FILE", candidates.files, "The robot, from its profile.")
    lichtblick: str | None = option(
        "FILE", candidates.files, "A layout for Lichtblick and Foxglove, for this robot."
    )
    plotjuggler: str | None = option(
        "FILE", candidates.files, "A layout for PlotJuggler, for this robot."
    )
    overwrite: bool = common.overwrite()


@dataclass(frozen=True, kw_only=True)
class MapOptions(CommandOptions):
    """Write the pipe that a recorded robot has driven through.

    It is mapped from the robot's signals and words alone: straights by the wheels, bends by the
    joint angles, rolls and pitches by gravity, diameters by the clamped parts. Comments in the file
    say what is not known.

    Exit codes: 0 written, 1 written, but the robot's place was lost on the way, 2 the recording
    cannot be read.
    """

    recording: str = common.recording()
    output: Path | None = common.output()
    overwrite: bool = common.overwrite()
    start_at: str | None = option(
        "LENGTH", None, "Where the first wheel began; else the pipe begins at the last."
    )


@dataclass(frozen=True, kw_only=True)
class ReportOptions(CommandOptions):
    """Write a recorded run as one HTML page that works offline.

    Of several recordings, or of a folder, each gets a page next to it, and index.html lists them.
    Pages of a read-only folder are written next to the list: name that with --output.
    Of a folder with the results of a campaign, index.html shows all cells and why runs failed.
    Pages that are newer than their recording are kept.

    Exit codes: 0 written, 1 written, but a recording or results of the campaign cannot be read, 2
    no recording can be read or a page not be written.
    """

    recordings: list[str] = argument(
        "RUN.mcap|FOLDER",
        candidates.recordings,
        "A recording, several, a folder of them, or the folder of a campaign's results.",
    )
    output: Path | None = option(
        "OUT.html", candidates.files, "RUN.html; of many, index.html.", "--output", "-o"
    )
    forecast: Path | None = option(
        "FILE", candidates.checkable, "Show what pirate forecast says about the run."
    )


@dataclass(frozen=True, kw_only=True)
class PageOptions(CommandOptions):
    """Show a run in browsers, also during it, or a mission.

    The page is that of `pirate report`. Of two runs it shows both, aligned by what their missions
    have reached. Of a mission it shows what the check finds, the diagram, the pipe to scale, how
    far it holds if `pirate margins` has found that, and the lines of the file, each time that it
    is loaded. It needs the extra page. Ctrl-C ends it.

    Exit codes: 0 ended by Ctrl-C, 2 a recording cannot be read or the page not be served.
    """

    recordings: list[str] = argument(
        "RUN.mcap|MISSION",
        candidates.missions_or_recordings,
        "A recording, two to be compared, or a mission.",
    )
    robot: str | None = common.a_robot("Of a mission: the robot.")
    pipe: str | None = common.a_pipe("Of a mission: the pipe.")
    margins: Path | None = option(
        "FOLDER",
        candidates.files,
        "Of a mission: results of margins; runs/NAME.campaign otherwise.",
    )
    port: int | None = typed("Its port; 8790 otherwise, or any that is free.", min=0, max=65535)
    forecast: Path | None = option(
        "FILE", candidates.checkable, "Of a run: show what pirate forecast says about it."
    )


@dataclass(frozen=True, kw_only=True)
class RepairOptions(CommandOptions):
    """Complete a recording that was cut short, in a new file.

    Exit codes: 0 written, or it is whole already; 2 it cannot be read, holds nothing that can be
    used, or the file cannot be written.
    """

    recording: str = common.recording()
    output: Path | None = option(
        "OUT.mcap", candidates.files, "RUN.repaired.mcap otherwise.", "--output", "-o"
    )
