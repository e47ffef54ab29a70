"""Reads a recording that still grows, from another process than the one that writes it.

The recorder writes whole pieces and syncs them, so a reader of the file hears of a run without the
run knowing: nothing that a reader does, or fails to do, can hold the run up.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from pirate_sm.core.on_disk import opened
from pirate_sm.running.recording.read.mcap_content import NotMcapError, read_content
from pirate_sm.running.recording.read.reader import Recording, read_recording

QUIET_S = 5.0
"""A run whose recording has not grown for this long may have ended; the recorder writes several
times a second, also while the robot stands."""


class GrowingRecording:
    """A recording with what has been added to it since it was opened.

    Args:
        path: The file.
        now: Reads a monotonic clock, s.

    Raises:
        RecordingError: There is no such file, it is not a recording, or its header is damaged.
    """

    def __init__(self, path: Path, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._recording = read_recording(path, damaged=True)
        self._grew_s = now() - max(0.0, time.time() - path.stat().st_mtime)

    @property
    def under_way(self) -> bool:
        """Whether the run may still continue: its end is not here, and something came just now."""
        content = self._recording.content
        return not (content.complete or content.damage or self._now() > self._grew_s + QUIET_S)

    @property
    def complete(self) -> bool:
        """Whether nothing more can come."""
        return bool(self._recording.content.complete or self._recording.content.damage)

    def grow(self) -> bool:
        """Take in the pieces that have been written since; return whether there are any."""
        before = self._recording.content
        if self.complete:
            return False
        try:
            with opened(self._recording.path) as file:
                now = read_content(file, before.whole)
        except (NotMcapError, OSError):
            return False
        new = [piece for piece in now.pieces if piece.at > before.whole]
        if new or now.complete:
            self._grew_s = self._now()
        before.pieces.extend(new)  # in place: its readers find them
        content = now._replace(
            pieces=before.pieces,
            attachments={**before.attachments, **now.attachments},
            metadata={**before.metadata, **now.metadata},
            whole=max(before.whole, now.whole),
            since=0,
        )
        self._recording = replace(self._recording, content=content)
        return bool(new)

    def so_far(self, more: Callable[[], bool] | None = None) -> Recording:
        """Return the recording as it is now.

        Args:
            more: Is called when all that is there has been read, so that it can wait for more;
                returns whether there is. None: the recording ends here.
        """
        content = self._recording.content
        if more is None:
            return replace(self._recording, content=content._replace(pieces=[*content.pieces]))
        return replace(self._recording, more=more)
