"""The command that makes a page of a recording, and its options."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def report(
    recording: Annotated[str, typer.Argument(metavar="RUN.mcap", help="A recording.")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="OUT.html", help="As the recording, with .html."),
    ] = None,
    debug: Annotated[bool, typer.Option("--debug", help="Show tracebacks.")] = False,
) -> None:
    """Tell a recorded run on one page that opens anywhere, offline.

    Exit codes: 0 written, 2 the recording cannot be read or the page not be written.
    """
    from pirate_sm.cli.guard import guarded

    def work() -> int:
        from pirate_sm.cli.report import write_report

        return write_report(recording, output)

    raise typer.Exit(guarded(work, debug))
