"""The commands about recordings and their options."""

from __future__ import annotations

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
    debug: Annotated[bool, _DEBUG] = False,
) -> None:
    """Execute a recording again and tell whether the same comes out.

    Exit codes: 0 the same, 1 something else, 2 it cannot be read.
    """
    from pirate_sm.cli.guard import guarded

    def work() -> int:
        from pirate_sm.cli.recordings import Changed, run_replay

        return run_replay(recording, Changed(mission, robot, pipe))

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
