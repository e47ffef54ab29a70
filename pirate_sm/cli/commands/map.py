"""`pirate map`: writes the pipe file that a recorded robot has driven through."""

from __future__ import annotations

import sys
from pathlib import Path

from pirate_sm.cli.commands.replay import opened_recording
from pirate_sm.cli.options.declaring import read_length
from pirate_sm.cli.options.recordings import MapOptions
from pirate_sm.cli.output.files import refuse_losses, write_or_print
from pirate_sm.lab.mapping.mapper import mapped
from pirate_sm.lab.mapping.pipe_text import pipe_text


def write_map(options: MapOptions) -> int:
    """Write the map to the file, or to standard output; return the exit code.

    Raises:
        RecordingError: The recording cannot be read.
        UsageError: An option does not have the right form, or the file cannot be written.
    """
    first_wheel_m = read_length("--start-at", options.start_at)
    recorded = Path(options.recording)
    refuse_losses([options.output], inputs=[recorded], overwrite=options.overwrite)
    with opened_recording(options.recording) as recording:
        made = mapped(recording)
    name = options.output.stem if options.output is not None else f"{recorded.stem}_map"
    write_or_print(options.output, pipe_text(made, name, recorded.name, first_wheel_m))
    for note in made.notes:
        print(f"the map is incomplete: {note}", file=sys.stderr)
    return 1 if made.notes else 0
