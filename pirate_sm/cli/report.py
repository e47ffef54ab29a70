"""`pirate report`: a recording as one page."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.cli.progress import progress
from pirate_sm.errors import UsageError
from pirate_sm.recording.reader import read_recording
from pirate_sm.report.page import html
from pirate_sm.report.recorded import report_of
from pirate_sm.showing.visible import visible


def write_report(recording: str, output: Path | None) -> int:
    """The page stands in the file.

    Args:
        recording: The recording.
        output: The file; None: beside the recording, with ``.html`` in place of its ending.

    Raises:
        RecordingError: The recording cannot be read.
        UsageError: The page cannot be written, or what plots is not installed.
    """
    path = Path(recording)
    place = output or path.with_suffix(".html")
    if place.resolve() == path.resolve():
        raise UsageError(f"'{place}' is the recording itself")
    with progress(f"reading {visible(recording)}") as watch:
        text = html(report_of(read_recording(path, watch)))
    try:
        place.write_text(text, encoding="utf-8")
    except OSError as error:
        raise UsageError(f"'{place}' cannot be written: {error.strerror}") from None
    print(visible(str(place)))
    return 0
