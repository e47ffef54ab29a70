"""The command that makes pages of recordings, and its options."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def report(
    recordings: Annotated[
        list[str],
        typer.Argument(metavar="RUN.mcap", help="A recording, several, or a folder of them."),
    ],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="OUT.html", help="RUN.html; of many, index.html."),
    ] = None,
    debug: Annotated[bool, typer.Option("--debug", help="Show tracebacks.")] = False,
) -> None:
    """Tell a recorded run on one page that opens anywhere, offline; list many runs.

    Of several recordings, or of a folder, each has its page beside it, and index.html lists them.
    Pages of a folder that is read-only stand beside the list: name that with --output.
    Pages that are newer than their recording are kept.

    Exit codes: 0 written, 2 no recording can be read or a page not be written.
    """
    from pirate_sm.cli.guard import guarded

    def work() -> int:
        from pirate_sm.cli.report import write_reports

        return write_reports(recordings, output)

    raise typer.Exit(guarded(work, debug))
