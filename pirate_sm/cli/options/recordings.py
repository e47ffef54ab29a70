"""Options of the commands about recordings: replay, compare, export, map, report, repair."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from pirate_sm.cli.completion import named_files
from pirate_sm.cli.options import common
from pirate_sm.cli.options.declaring import argument, option


@dataclass(frozen=True, kw_only=True)
class ReplayOptions:
    """Replay a recording and report whether the result is the same.

    Exit codes: 0 the same, 1 different, 2 it cannot be read or contains nothing to replay.
    """

    recording: common.Recording
    mission: Annotated[
        str | None, option("MISSION", named_files.missions, "In place of the one in the recording.")
    ] = None
    robot: Annotated[
        str | None, option("NAME", named_files.robots, "With --mission: the robot.")
    ] = None
    pipe: Annotated[str | None, option("NAME", named_files.pipes, "With --mission: the pipe.")] = (
        None
    )
    begin: Annotated[
        str | None, option("TIME", None, "Begin at the checkpoint before this time.", "--from")
    ] = None
    until: Annotated[str | None, option("TIME", None, "End at this time.")] = None
    jobs: Annotated[
        int | None,
        typer.Option("--jobs", "-j", min=1, help="Processes; all processors where it is long."),
    ] = None
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class CompareOptions:
    """Compare two recorded runs, or two campaigns.

    Runs are aligned by the mission's progress. Campaigns, folders with their results, are compared
    cell by cell with Fisher's exact test.

    Exit codes: 0 the same course, or B is not worse; 1 they part, or B is worse; 2 one cannot be
    read, or results of a campaign are damaged.
    """

    first: Annotated[
        str,
        argument(
            "A", named_files.recordings, "A recording, or the folder of a campaign's results."
        ),
    ]
    second: Annotated[str, argument("B", named_files.recordings, "Another one.")]
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class ExportOptions:
    """Write a recording for other programs."""

    recording: common.Recording
    csv: Annotated[
        str | None, option("DIR", named_files.folders, "One table for each topic, SI units.")
    ] = None
    parquet: Annotated[
        str | None, option("DIR", named_files.folders, "The same tables as Parquet files.")
    ] = None
    viewers: Annotated[
        str | None,
        option("OUT.mcap", named_files.files, "The recording with all that viewers can show."),
    ] = None
    ros2: Annotated[
        str | None, option("DIR", named_files.folders, "A bag of ROS 2: joints, frames, log, URDF.")
    ] = None
    urdf: Annotated[
        str | None, option("FILE", named_files.files, "The robot, from its profile.")
    ] = None
    lichtblick: Annotated[
        str | None,
        option("FILE", named_files.files, "A layout for Lichtblick and Foxglove, for this robot."),
    ] = None
    plotjuggler: Annotated[
        str | None, option("FILE", named_files.files, "A layout for PlotJuggler, for this robot.")
    ] = None
    overwrite: common.Overwrite = False
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class MapOptions:
    """Write the pipe that a recorded robot has driven through.

    It is mapped from the robot's signals and words alone: straights by the wheels, bends by the
    joint angles, rolls and pitches by gravity, diameters by the clamped parts. Comments in the file
    say what is not known.

    Exit codes: 0 written, 1 written, but the robot's place was lost on the way, 2 the recording
    cannot be read.
    """

    recording: common.Recording
    output: common.Output = None
    overwrite: common.Overwrite = False
    start_at: Annotated[
        str | None,
        option("LENGTH", None, "Where the first wheel began; else the pipe begins at the last."),
    ] = None
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class ReportOptions:
    """Write a recorded run as one HTML page that works offline.

    Of several recordings, or of a folder, each has its page beside it, and index.html lists them.
    Pages of a folder that is read-only stand beside the list: name that with --output.
    Of a folder with the results of a campaign, index.html shows all cells and why runs failed.
    Pages that are newer than their recording are kept.

    Exit codes: 0 written, 1 written, but a recording or results of the campaign cannot be read, 2
    no recording can be read or a page not be written.
    """

    recordings: Annotated[
        list[str],
        argument(
            "RUN.mcap|FOLDER",
            named_files.recordings,
            "A recording, several, a folder of them, or the folder of a campaign's results.",
        ),
    ]
    output: Annotated[
        Path | None,
        option("OUT.html", named_files.files, "RUN.html; of many, index.html.", "--output", "-o"),
    ] = None
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class RepairOptions:
    """Complete a recording that was cut short, in a new file.

    Exit codes: 0 written, or it is whole already; 2 it cannot be read or the file not be written.
    """

    recording: common.Recording
    output: Annotated[
        Path | None,
        option("OUT.mcap", named_files.files, "RUN.repaired.mcap otherwise.", "--output", "-o"),
    ] = None
    debug: common.Debug = False
