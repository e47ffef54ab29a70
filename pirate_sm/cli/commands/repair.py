"""`pirate repair`: completes a recording that was cut short."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from pirate_sm.cli.options.recordings import RepairOptions
from pirate_sm.cli.output.terminal import progress
from pirate_sm.core.errors import RecordingError, UsageError
from pirate_sm.core.library import shown
from pirate_sm.core.visible import visible
from pirate_sm.running.recording.read.reader import Recording, read_recording
from pirate_sm.running.recording.read.repair import Repaired, is_whole, repair


def run_repair(options: RepairOptions) -> int:
    """Write everything whole to a new file and print what is lost; return the exit code.

    Raises:
        RecordingError: The recording cannot be read, or holds nothing that can be used.
        UsageError: The new file cannot be written.
    """
    path = Path(options.recording)
    place = options.output or path.with_suffix(f".repaired{path.suffix}")
    with progress(f"reading {visible(options.recording)}") as watch:
        found = read_recording(path, watch, damaged=True)
        if is_whole(found):
            print(visible(f"{shown(path)} is whole: there is nothing to repair"))
            return 0
        try:
            done = repair(found, place)
        except FileExistsError:
            raise UsageError(f"{shown(place)} exists already; --output names another") from None
        except OSError as error:
            raise UsageError(f"{shown(place)} cannot be written: {error.strerror}") from None
    if not done.steps:
        place.unlink()
        message = f"no input of the run is whole in {shown(path)}, so there is nothing to repair"
        raise RecordingError(f"{message}; no file is written")
    print(visible(f"{shown(place)} holds {done.steps} inputs, until {done.until_s:.3f} s"))
    if done.complete:
        print("nothing is lost: only the index at the end of the file was missing or wrong")
    for line in _lost(done, found):
        print(visible(f"lost: {line}"))
    return 0


def _lost(done: Repaired, of: Recording) -> Iterator[str]:
    for gap in done.gaps:
        yield f"what came from {gap.from_s:.3f} s to {gap.until_s:.3f} s"
    if done.damage:
        yield f"what is damaged {done.damage}"
    elif not (of.complete or of.gaps):
        yield "whatever came after that: it is not in the file"
    if done.torn_bytes:
        why = "nothing after damage can be used" if done.damage else "which are not whole"
        yield f"the last {done.torn_bytes} bytes of the file, {why}"
