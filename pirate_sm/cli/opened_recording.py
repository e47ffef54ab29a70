"""A recording that a command reads: progress on a terminal, and what is to be said of it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pirate_sm.cli.output.progress import progress
from pirate_sm.recording.read.reader import Recording, read_recording
from pirate_sm.visible import visible


@contextmanager
def opened_recording(path: str) -> Iterator[Recording]:
    """Open a recording and print its notices; a terminal shows how far the block has read it.

    Raises:
        RecordingError: It cannot be read.
    """
    with progress(f"reading {visible(path)}") as watch:
        recording = read_recording(Path(path), watch)
        for notice in recording.notices:
            print_visible(f"{path}: {notice}")
        yield recording


def title(recording: Recording) -> str:
    """Return the mission, the backend and the date of a recorded run, in a line."""
    header = recording.header
    return f"{header.mission} on {header.backend}, {header.began}"


def print_visible(text: str) -> None:
    """Print a text with everything written out that a terminal would not show."""
    print(visible(text))
