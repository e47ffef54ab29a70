"""`pirate page`: serves the page of a run, during it or after it, or of two runs."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from pirate_sm.cli.commands.replay import opened_recording
from pirate_sm.cli.options.recordings import PageOptions
from pirate_sm.core.errors import ExitCode, RecordingError, UsageError, not_installed
from pirate_sm.core.on_disk import why_hidden

if TYPE_CHECKING:
    from pirate_sm.views.report.contents import Report


def serve_page(options: PageOptions) -> int:
    """Serve the page until Ctrl-C; return the exit code.

    Raises:
        RecordingError: A recording cannot be read.
        UsageError: It cannot be served.
    """
    try:
        from pirate_sm.views.report.page_server import serve
    except ModuleNotFoundError:
        raise not_installed("the page", "tornado", "page") from None
    if len(options.recordings) > 2:
        raise UsageError("a page shows one run, or two to be compared")
    paths = [Path(each) for each in options.recordings]
    for path in paths:
        if why := why_hidden(path):
            raise RecordingError(f"{path} cannot be read: {why}")

    def say(address: str) -> None:
        print(f"open {address} in a browser; Ctrl-C ends it", flush=True)

    with suppress(KeyboardInterrupt):
        shown = paths[0] if len(paths) == 1 else _compared(options.recordings)
        asyncio.run(serve(shown, options.port, say, lambda _: asyncio.Event().wait()))
    return ExitCode.SUCCEEDED


def _compared(places: list[str]) -> Report:
    from pirate_sm.views.report.compared_report import compared_report

    with opened_recording(places[0]) as first, opened_recording(places[1]) as second:
        return compared_report(first, second)
