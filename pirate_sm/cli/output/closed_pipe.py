"""Notices that nobody reads standard output any more, before something is written."""

from __future__ import annotations

import errno
import os
import select
import stat
from typing import TextIO


class PipeWatch:
    """A watcher that notices when the other end of a pipe has been closed.

    A mission may wait for minutes without output. It must not go on unseen until the next line.
    """

    def __init__(self, out: TextIO) -> None:
        self._poll = select.poll()
        # No event is requested: the closed other end is always reported.
        self._poll.register(out.fileno(), 0)

    def pulse(self, now_s: float) -> None:
        """Check that the output is still read.

        Raises:
            BrokenPipeError: The other end is closed.
        """
        if self._poll.poll(0):
            raise BrokenPipeError(errno.EPIPE, os.strerror(errno.EPIPE))


def watch_pipe(out: TextIO) -> PipeWatch | None:
    """Return a watcher of the output if it is a pipe or a socket."""
    try:
        mode = os.fstat(out.fileno()).st_mode
    except (OSError, ValueError):  # not a file
        return None
    return PipeWatch(out) if stat.S_ISFIFO(mode) or stat.S_ISSOCK(mode) else None
