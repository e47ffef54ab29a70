"""The page of a run in a process of its own, which a command starts with the run.

The two share the recording and a pipe: closed, also by a death, it says that the run has ended.
"""

from __future__ import annotations

import asyncio
import json
import os
import select
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pirate_sm.core.errors import PirateError, UsageError, not_installed

if TYPE_CHECKING:
    from pirate_sm.views.report.page_server import Editions

LINGER_S = 30.0
"""How long the page can still be opened after the run; it stays where it is open, s."""

_PATIENCE_S = 20.0
"""How long the process may take to start on a busy computer, s."""

_NICE = 10
"""The run comes first where processors are short."""

_LOOK_EVERY_S = 1.0


class PageProcess:
    """Serves the page of a recording until the run has ended and no page is open.

    Args:
        path: The recording, which has its header.

    Attributes:
        address: The address for a browser.

    Raises:
        UsageError: It cannot be served.
    """

    def __init__(self, path: Path) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", __name__, str(path.resolve())],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C is for the run
        )
        self.address = self._hear()

    def _hear(self) -> str:
        out = self._process.stdout
        assert out is not None
        line = out.readline() if select.select([out], [], [], _PATIENCE_S)[0] else b""
        try:
            said = json.loads(line)
        except ValueError:
            self._process.kill()
            said = {"problem": "the page cannot be served: its process does not answer"}
        if "problem" in said:
            raise UsageError(said["problem"])
        return str(said["address"])

    def close(self) -> None:
        """Say that the run has ended."""
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                pipe.close()


def _say(**what: Any) -> None:
    sys.stdout.write(f"{json.dumps(what)}\n")
    sys.stdout.flush()


async def _until_unwatched(editions: Editions) -> None:
    """Return when the run has ended and no page has been open for a while."""
    await asyncio.to_thread(sys.stdin.read)
    unseen_s = 0.0
    while unseen_s < LINGER_S:
        await asyncio.sleep(_LOOK_EVERY_S)
        unseen_s = 0.0 if editions.viewers else unseen_s + _LOOK_EVERY_S


def main() -> None:
    """Serve the page of the recording on the command line."""
    os.nice(_NICE)
    try:
        from pirate_sm.views.report.page_server import serve  # noqa: PLC0415 - an extra
    except ModuleNotFoundError:
        _say(problem=str(not_installed("the page", "tornado", "page")))
        return
    path = Path(sys.argv[1])
    try:
        asyncio.run(serve(path, None, lambda address: _say(address=address), _until_unwatched))
    except PirateError as error:
        _say(problem=str(error))


if __name__ == "__main__":
    main()
