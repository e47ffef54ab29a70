"""The commands about recordings and their options."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

_RECORDING = typer.Argument(metavar="RUN.mcap", help="A recording.")
_DEBUG = typer.Option("--debug", help="Show tracebacks.")


def replay(
    recording: Annotated[str, _RECORDING],
    mission: Annotated[
        str | None,
        typer.Option(metavar="MISSION", help="In place of the one in the recording."),
    ] = None,
    robot: Annotated[
        str | None, typer.Option(metavar="NAME", help="With --mission: the robot.")
    ] = None,
    pipe: Annotated[
        str | None, typer.Option(metavar="NAME", help="With --mission: the pipe.")
    ] = None,
    from_: Annotated[
        str | None,
        typer.Option("--from", metavar="TIME", help="Begin at the checkpoint before this time."),
    ] = None,
    until: Annotated[str | None, typer.Option(metavar="TIME", help="End at this time.")] = None,
    jobs: Annotated[
        int | None,
        typer.Option("--jobs", "-j", min=1, help="Processes; all processors where it is long."),
    ] = None,
    debug: Annotated[bool, _DEBUG] = False,
) -> None:
    """Execute a recording again and tell whether the same comes out.

    Exit codes: 0 the same, 1 something else, 2 it cannot be read or holds nothing to execute.
    """
    from pirate_sm.cli.guard import guarded

    def work() -> int:
        from pirate_sm.cli.recordings import Changed, Stretch, run_replay

        return run_replay(recording, Changed(mission, robot, pipe), Stretch.of(from_, until), jobs)

    raise typer.Exit(guarded(work, debug))


def compare(
    first: Annotated[str, typer.Argument(metavar="A.mcap", help="A recording.")],
    second: Annotated[str, typer.Argument(metavar="B.mcap", help="Another one.")],
    debug: Annotated[bool, _DEBUG] = False,
) -> None:
    """Lay two runs side by side by what the mission has come to.

    Exit codes: 0 both took one course, 1 they part, 2 one cannot be read.
    """
    from pirate_sm.cli.guard import guarded

    def work() -> int:
        from pirate_sm.cli.recordings import run_compare

        return run_compare(first, second)

    raise typer.Exit(guarded(work, debug))


def export(
    recording: Annotated[str, _RECORDING],
    csv: Annotated[
        str | None, typer.Option(metavar="DIR", help="One table for each topic, SI units.")
    ] = None,
    urdf: Annotated[
        str | None, typer.Option(metavar="FILE", help="The robot, from its profile.")
    ] = None,
    lichtblick: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="A layout for Lichtblick and Foxglove, for this robot."),
    ] = None,
    plotjuggler: Annotated[
        str | None, typer.Option(metavar="FILE", help="A layout for PlotJuggler, for this robot.")
    ] = None,
    debug: Annotated[bool, _DEBUG] = False,
) -> None:
    """Write a recording for other programs."""
    from pirate_sm.cli.guard import guarded

    def work() -> int:
        from pirate_sm.cli.recordings import Wanted, run_export

        return run_export(recording, Wanted(csv, urdf, lichtblick, plotjuggler))

    raise typer.Exit(guarded(work, debug))


def repair(
    recording: Annotated[str, _RECORDING],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="OUT.mcap", help="RUN.repaired.mcap otherwise."),
    ] = None,
    debug: Annotated[bool, _DEBUG] = False,
) -> None:
    """Give a recording that was cut short its end and its index, in a new file.

    Exit codes: 0 written, or it is whole already; 2 it cannot be read or the file not be written.
    """
    from pirate_sm.cli.guard import guarded

    def work() -> int:
        from pirate_sm.cli.repairing import run_repair

        return run_repair(recording, output)

    raise typer.Exit(guarded(work, debug))
