"""`pirate report`: writes a page of a recording, or a list of many with a page for each."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from urllib.parse import quote

from pirate_sm import __version__
from pirate_sm.cli.errors import say
from pirate_sm.cli.options.recordings import ReportOptions
from pirate_sm.cli.output.files import HEAD, begins, is_recording, write_and_name
from pirate_sm.cli.output.terminal import progress
from pirate_sm.core.errors import RecordingError, UsageError
from pirate_sm.core.on_disk import is_folder, why_hidden
from pirate_sm.core.visible import visible
from pirate_sm.lab.campaign.store import RECORDINGS, is_store
from pirate_sm.running.recording.forecast_file import forecast_of, read_forecast
from pirate_sm.running.recording.read.reader import Recording, read_recording
from pirate_sm.views.report import GENERATOR
from pirate_sm.views.report.recording_report import report_of
from pirate_sm.views.report.report_page import html
from pirate_sm.views.report.run_list import ListedRun, index_html, listed, unreadable

WRITTEN, UNREADABLE = 0, 1

_INDEX = "index.html"


def write_reports(options: ReportOptions) -> int:
    """Write the page of a recording; for several, or a folder, also a list.

    Raises:
        RecordingError: The recording cannot be read; for several: none can be read.
        UsageError: A page cannot be written.
    """
    places, output, forecast = options.recordings, options.output, options.forecast
    if forecast is not None and (len(places) > 1 or is_folder(Path(places[0]))):
        raise UsageError("--forecast is for the page of one recording")
    if len(places) == 1 and is_store(Path(places[0])):
        return _write_campaign(Path(places[0]), output)
    paths = tuple(dict.fromkeys(found for place in places for found in _recordings(Path(place))))
    if len(places) == 1 and paths == (Path(places[0]),):
        return _write_report(paths[0], output or paths[0].with_suffix(".html"), forecast)
    return _write_index(paths, output or paths[0].parent / _INDEX)


def _write_campaign(folder: Path, output: Path | None) -> int:
    """Write the page of a campaign, in the folder of its results; return the exit code."""
    from pirate_sm.lab.campaign.conductor import stored
    from pirate_sm.lab.campaign.page import page_of
    from pirate_sm.lab.campaign.results import result_of

    place = output or folder / _INDEX
    _refuse_read_only(place)
    _refuse_foreign(place)
    recordings = folder / RECORDINGS
    link = Path(os.path.relpath(recordings.resolve(), place.resolve().parent))
    plan, tallies, damaged, margins = stored(folder)
    result = result_of(plan, tallies, folder, margins)
    recorded = [
        Path(each)
        for cell in result.cells
        for cause in cell.causes
        for each in cause.recordings.values()
    ]
    pages = {path: _page(path, place) for path in dict.fromkeys(recorded)}
    _refuse_foreign(*pages.values())
    runs = {str(path): _one(path, page, place) for path, page in pages.items()}
    reports = {path: run.link for path, run in runs.items() if run.link}
    write_and_name(place, page_of(result, link.as_posix(), damaged, reports))
    for each in damaged:
        say(each)
    for cell in result.cells if damaged else ():
        if cell.incomplete:
            say(f"{cell.name}: {cell.incomplete}")
    return UNREADABLE if damaged else WRITTEN


def _recordings(place: Path) -> Iterator[Path]:
    """Yield the recordings in a folder, or the file itself."""
    if not is_folder(place):
        yield place
        return
    found = sorted(place.glob("*.mcap"))
    if not found:
        raise UsageError(f"there is no recording (*.mcap) in the folder '{place}'")
    yield from found


def _write_report(path: Path, place: Path, forecast: Path | None) -> int:
    if why := why_hidden(path):
        raise RecordingError(f"{path} cannot be read: {why}")
    _refuse_read_only(place)
    _refuse_foreign(place)
    with progress(f"reading {visible(str(path))}") as watch:
        recording = read_recording(path, watch)
        own = forecast_of(recording.header)
        earlier = None if forecast is None else read_forecast(forecast, own)
        text = html(report_of(recording, earlier))
    write_and_name(place, text)
    _warn(path, recording)
    return WRITTEN


def _write_index(paths: Sequence[Path], index: Path) -> int:
    _refuse_read_only(index)
    pages = [_page(path, index) for path in paths]
    for path, page in zip(paths, pages, strict=True):
        if index.resolve() in (path.resolve(), page.resolve()):
            raise UsageError(f"'{index}' is '{path}' or its page; name the list with --output")
        if pages.count(page) > 1:
            raise UsageError(f"'{page}' would be the page of several recordings: list one folder")
    _refuse_foreign(index, *pages)
    runs = [_one(path, page, index) for path, page in zip(paths, pages, strict=True)]
    lost = sum(run.outcome == "unreadable" for run in runs)
    if lost == len(runs):
        raise RecordingError("none of the recordings can be read")
    write_and_name(index, index_html(runs))
    if lost:
        say(f"{lost} of {len(runs)} recordings cannot be read")
    return UNREADABLE if lost else WRITTEN


def _page(path: Path, index: Path) -> Path:
    """Return the path of a recording's page: next to it, or next to the list if it is read-only."""
    page = path.with_suffix(".html")
    return page if _is_writable(page.parent) else index.parent / page.name


def _is_writable(folder: Path) -> bool:
    """Return whether a file can be made in a folder; a missing one is reported elsewhere."""
    return os.access(folder, os.W_OK) or not is_folder(folder)


def _refuse_read_only(place: Path) -> None:
    """Raise an error with advice if no file can be created in the page's folder."""
    if not _is_writable(place.parent):
        raise UsageError(
            f"the folder '{place.parent}' is read-only: name with --output a file in another one"
        )


def _one(path: Path, page: Path, index: Path) -> ListedRun:
    """Write the page of a run unless it is fresh; return its entry for the list."""
    link = quote(Path(os.path.relpath(page.resolve(), index.resolve().parent)).as_posix())
    text = ""
    try:
        with progress(f"reading {visible(str(path))}") as watch:
            recording = read_recording(path, watch)
            run = listed(recording, link)
            if not _is_fresh(page, recording):
                text = html(report_of(recording))
            _warn(path, recording)
    except RecordingError as error:
        say(str(error))
        return unreadable(path, str(error))
    except Exception as error:  # an internal error, which the other runs do not have
        why = f"no page can be made of it: {type(error).__name__}: {error}"
        say(f"{path}: {why}")
        return unreadable(path, why)
    if text:
        write_and_name(page, text)
    return run


def _warn(path: Path, recording: Recording) -> None:
    """Say what is wrong with a recording that could be read."""
    for notice in recording.notices:
        say(f"{path}: {notice}")


def _is_fresh(page: Path, recording: Recording) -> bool:
    """Return whether this version of the program made the page of this very recording."""
    head = begins(page, HEAD).decode(errors="replace")
    made_by = f'content="pirate-sm {__version__}"' in head
    return made_by and f'<meta name="recording" content="{recording.sha256}">' in head


def _refuse_foreign(*places: Path) -> None:
    """Check that only pages of this program are overwritten.

    Raises:
        UsageError: Another file would be overwritten; the message lists all.
    """
    problems = []
    for place in places:
        if is_recording(place):
            problems.append(f"'{place}' is a recording: no page is written over it")
        elif (head := begins(place, HEAD)) and GENERATOR not in head:
            problems.append(
                f"'{place}' is not a page of this program; not overwritten: "
                "move it away, or name another file with --output"
            )
    if problems:
        raise UsageError("\n".join(problems))
