"""`pirate page`: serves the page of a run, during it or after it, or of two runs."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Awaitable, Callable, Iterable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from pirate_sm.cli.commands.replay import opened_recording
from pirate_sm.cli.options.recordings import PageOptions
from pirate_sm.cli.settings import runs
from pirate_sm.core import library
from pirate_sm.core.errors import ExitCode, RecordingError, UsageError, not_installed
from pirate_sm.core.on_disk import why_hidden

if TYPE_CHECKING:
    from pirate_sm.views.report.contents import Report
    from pirate_sm.views.report.figure_page import FigureSection
    from pirate_sm.views.report.page_server import Shown


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

    def say(address: str) -> None:
        print(f"open {address} in a browser; Ctrl-C ends it", flush=True)

    def ended(_: object) -> Awaitable[object]:
        return asyncio.Event().wait()

    shown, forecast = _shown(options), options.forecast
    if forecast is not None and not isinstance(shown, Path):
        raise UsageError("--forecast is for the page of one run")
    with suppress(KeyboardInterrupt):
        asyncio.run(serve(shown, options.port, say, ended, forecast=forecast))
    return ExitCode.SUCCEEDED


def _shown(options: PageOptions) -> Shown:
    """Return what the page shows.

    Raises:
        RecordingError: A recording cannot be read.
        UsageError: The options do not fit, or there is no such mission.
    """
    places = options.recordings
    if any(map(_is_mission, places)):
        from pirate_sm.views.report.mission_page import mission_page

        if len(places) > 1:
            raise UsageError("a page shows one mission, one run, or two runs to be compared")
        mission = library.find_mission(places[0])
        for find, name in ((library.find_robot, options.robot), (library.find_pipe, options.pipe)):
            if name is not None:
                find(name, Path.cwd())
        return partial(mission_page, mission, options.robot, options.pipe, _known(mission, options))
    if (options.robot, options.pipe, options.margins) != (None, None, None):
        raise UsageError("--robot, --pipe and --margins are for the page of a mission")
    if len(places) > 2:
        raise UsageError("a page shows one run, or two to be compared")
    for place in places:
        if why := why_hidden(Path(place)):
            raise RecordingError(f"{place} cannot be read: {why}")
    return Path(places[0]) if len(places) == 1 else _compared(places)


def _known(mission: Path, options: PageOptions) -> Callable[[], Iterable[FigureSection]]:
    """Return what looks up how far the mission holds, each time that the page is made.

    Raises:
        UsageError: The folder that was named has no results of margins.
    """
    from pirate_sm.cli.commands.campaign import results_folder
    from pirate_sm.lab.campaign.campaign_file import campaign_of_one
    from pirate_sm.lab.campaign.conductor import stored_plan
    from pirate_sm.lab.campaign.known_margins import known_margins
    from pirate_sm.lab.campaign.store import Store, is_store
    from pirate_sm.running.wiring import Order

    folder = options.margins
    if folder is None:
        folder = results_folder(campaign_of_one(mission), runs())
    elif stored_plan(Store(folder)).margins is None:
        raise UsageError(f"the results in '{folder}' are of a campaign without margins")
    order = Order(str(mission), robot=options.robot, pipe=options.pipe)
    return lambda: known_margins(folder, order) if is_store(folder) else ()


def _is_mission(place: str) -> bool:
    """Return whether this names a mission: a file of YAML, or a shipped one."""
    known = {path.stem for path in library.missions()}
    return Path(place).suffix in (".yaml", ".yml") or (
        place in known and not os.path.lexists(place)
    )


def _compared(places: list[str]) -> Report:
    from pirate_sm.views.report.compared_report import compared_report

    with opened_recording(places[0]) as first, opened_recording(places[1]) as second:
        return compared_report(first, second)
