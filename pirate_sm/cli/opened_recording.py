"""Opens a recording for a command: with progress on a terminal, and its notices."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pirate_sm.cli.output.progress import progress
from pirate_sm.core.visible import visible
from pirate_sm.running.recording.read.reader import Recording, read_recording


@contextmanager
def opened_recording(path: str) -> Iterator[Recording]:
    """Open a recording and print its notices; show on a terminal how far it has been read.

    Raises:
        RecordingError: The recording cannot be read.
    """
    with progress(f"reading {visible(path)}") as watch:
        recording = read_recording(Path(path), watch)
        for notice in recording.notices:
            print_visible(f"{path}: {notice}")
        yield recording


def title(recording: Recording) -> str:
    """Return the mission, the backend, its fidelity if coarser, and the date, in one line."""
    header = recording.header
    fidelity = "".join(f" ({name})" for name in header.coarser)
    return f"{header.mission} on {header.backend}{fidelity}, {header.began}"


def print_visible(text: str) -> None:
    """Print a text with all invisible characters written out."""
    print(visible(text))
