"""The page of runs in a process of its own, which a command starts with its first run.

The two share the recording and two pipes. Over one the process learns which recording is shown;
closed, also by a death, it says that no run follows. Over the other come the names of the
buttons that viewers press, and nothing else that they send. What the process does, or does not do,
never holds up a run.
"""

from __future__ import annotations

import asyncio
import json
import os
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from functools import partial
from math import inf
from pathlib import Path
from socket import MSG_DONTWAIT, SHUT_RDWR, socket, socketpair
from threading import Thread
from typing import TYPE_CHECKING, Any, Literal, Self

from pirate_sm.core.companion import Companion, CompanionBase
from pirate_sm.core.effects import CommandStatus, Effect, PhaseChange
from pirate_sm.core.errors import PirateError, UsageError, not_installed
from pirate_sm.robot.control_panel.panel_file import Button, RunButton, WordButton
from pirate_sm.robot.control_panel.panel_reader import Connection, EndRun, Happening
from pirate_sm.robot.control_panel.presses import LinePress, Press
from pirate_sm.views.report.acting import LINE, STOP, Acting

if TYPE_CHECKING:
    from pirate_sm.views.report.page_server import PageServer

LINGER_S = 30.0
"""How long the page can still be opened after the run; it stays where it is open, s."""

BY = "page"
"""What events of the page are said to be by."""

_PATIENCE_S = 20.0
"""How long the process may take to start on a busy computer, s."""

_NICE = 10
"""The run comes first where processors are short."""

_SWITCH_EVERY_S = 0.001
"""How long the thread that makes reports may keep a press waiting, instead of 5 ms."""

_LOOK_EVERY_S = 1.0

_LONGEST = 200
"""No line about a press is longer, bytes."""

MOST_A_SECOND = 40
"""More presses than this come from a process that does not work: it lets through fewer."""


def page_buttons(words: Collection[str]) -> dict[str, Button]:
    """Return the buttons of the page: those of the run, and one for each of these words."""
    buttons: dict[str, Button] = {
        STOP: RunButton(do="stop"),
        "pause": RunButton(do="pause"),
        "continue": RunButton(do="go"),
        "step": RunButton(do="step"),
    }
    return buttons | {f"word {word}": WordButton(word=word) for word in words}


# --- in the process of the run --------------------------------------------------------------------


class PageProcess:
    """Serves the page of the runs of a command until none follows and no page is open.

    Presses that stop the run act in a thread of this class; all others wait for :meth:`taken`.

    Args:
        words: The detector's words that viewers may say.
        end_run: Ends the current run.

    Attributes:
        address: The address for a browser, with which viewers may also act.

    Raises:
        UsageError: It cannot be served.
    """

    def __init__(self, words: Collection[str], end_run: EndRun) -> None:
        self._buttons = page_buttons(words)
        self._end_run = end_run
        self._happened: deque[Happening] = deque(maxlen=MOST_A_SECOND)
        self._pressed_s: deque[float] = deque(maxlen=MOST_A_SECOND)
        self._shows = self._closing = False
        self._presses, other = socketpair()
        with other:
            self._process = subprocess.Popen(
                [sys.executable, "-m", __name__, *self._buttons],
                stdin=subprocess.PIPE,
                stdout=other.fileno(),
                stderr=subprocess.DEVNULL,
                start_new_session=True,  # Ctrl-C is for the run
            )
        self.address, rest = self._hear()
        self._thread = Thread(target=self._work, args=(rest,), name="page", daemon=True)
        self._thread.start()

    def __enter__(self) -> Self:
        """Serve it."""
        return self

    def __exit__(self, *_: object) -> None:
        """Say that no run follows; what is pressed from now on is not heard."""
        self._closing = True
        with suppress(OSError):  # its other end may be closed
            self._presses.shutdown(SHUT_RDWR)
        self._thread.join()
        self._presses.close()
        if self._process.stdin is not None:
            self._process.stdin.close()

    @property
    def buttons(self) -> Collection[Button]:
        """Return what its buttons do."""
        return self._buttons.values()

    def taken(self) -> list[Happening]:
        """Return what has happened since the last call, oldest first."""
        found = []
        while self._happened:
            found.append(self._happened.popleft())
        return found

    def follow(self, recording: Path, forecast: Path | None = None) -> Companion:
        """Show the run of this recording, a later one as soon as it does something.

        Args:
            recording: The recording.
            forecast: File with earlier runs to compare it with.

        Returns:
            The companion that the run needs for that.
        """
        if not self._shows:
            self._shows = True
            self._show(recording, forecast)
            return FirstDeed(lambda: None)
        return FirstDeed(partial(self._show, recording, forecast))

    def _show(self, *files: Path | None) -> None:
        line = json.dumps([None if each is None else str(each.resolve()) for each in files])
        if self._process.stdin is not None:
            with suppress(OSError):  # the process has ended, or takes nothing
                os.set_blocking(self._process.stdin.fileno(), False)
                os.write(self._process.stdin.fileno(), f"{line}\n".encode())

    def _hear(self) -> tuple[str, bytes]:
        """Return the address that the process says first, and what it has said after it."""
        said = b""
        self._presses.settimeout(_PATIENCE_S)
        with suppress(OSError):
            while b"\n" not in said and (more := self._presses.recv(4096)):
                said += more
        self._presses.settimeout(None)
        line, _, rest = said.partition(b"\n")
        try:
            found = json.loads(line)
        except ValueError:
            found = {"problem": "the page cannot be served: its process does not answer"}
        if "problem" in found:
            self._process.kill()
            self._process.communicate()
            self._presses.close()
            raise UsageError(found["problem"])
        return str(found["address"]), rest

    # --- in its own thread --------------------------------------------------------------------

    def _work(self, more: bytes) -> None:
        why, waiting = "its process has ended", b""
        with suppress(OSError):  # as if it had closed it
            while True:
                *lines, waiting = (waiting + more).split(b"\n")
                if len(waiting) > _LONGEST or not all(map(self._take, lines)):
                    why = "its process does not work"
                    self._process.kill()
                    break
                if not (more := self._presses.recv(4096)):
                    break
        if not self._closing:
            self._happened.append(Connection("lost", f"the page cannot be used any more: {why}"))

    def _take(self, line: bytes) -> bool:
        """Act on a press; return whether a process that works can have sent it."""
        name, now_s = line.decode(errors="replace"), time.monotonic()
        button, asked = self._buttons.get(name), LINE.fullmatch(name)
        if asked is not None:
            do: Literal["break", "until"] = "break" if asked["do"] == "break" else "until"
            self._happened.append(LinePress(do, asked["line"], BY))
        elif button is None:
            return False
        elif isinstance(button, RunButton) and button.do == "stop":
            self._end_run(f"stopped on the {BY}")
        else:
            self._happened.append(Press(BY, button, by=BY))
        crowded = len(self._pressed_s) == MOST_A_SECOND and now_s < self._pressed_s[0] + 1.0
        self._pressed_s.append(now_s)
        return not crowded


class FirstDeed(CompanionBase):
    """A companion that calls a function once, when its run enters a phase or gives a command.

    A run that waits for its operator would else take the place of the one that has just ended.
    """

    due_s = inf

    def __init__(self, call: Callable[[], object]) -> None:
        self._call: Callable[[], object] | None = call

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Call the function at the first deed."""
        if self._call is not None and any(
            isinstance(each, PhaseChange | CommandStatus) for each in effects
        ):
            call, self._call = self._call, None
            call()


# --- in the process of the page -------------------------------------------------------------------


def _say(**what: Any) -> None:
    sys.stdout.write(f"{json.dumps(what)}\n")
    sys.stdout.flush()


def _press(name: str) -> bool:
    """Pass a press on to the run; return whether it takes it."""
    line = f"{name}\n".encode()
    with suppress(OSError), socket(fileno=os.dup(sys.stdout.fileno())) as run:
        return run.send(line, MSG_DONTWAIT) == len(line)
    return False


async def _until_unwatched(server: PageServer) -> None:
    """Show what is to be shown; return when no run follows and no page was open for a while."""
    unseen_s = LINGER_S
    while line := await asyncio.to_thread(sys.stdin.readline):
        recording, forecast = json.loads(line)
        await server.show(Path(recording), forecast and Path(forecast))
        unseen_s = 0.0
    while unseen_s < LINGER_S:
        await asyncio.sleep(_LOOK_EVERY_S)
        unseen_s = 0.0 if server.editions.viewers else unseen_s + _LOOK_EVERY_S


def main() -> None:
    """Serve a page with the buttons on the command line."""
    os.nice(_NICE)
    sys.setswitchinterval(_SWITCH_EVERY_S)
    try:
        from pirate_sm.views.report.page_server import serve  # noqa: PLC0415 - an extra
    except ModuleNotFoundError:
        _say(problem=str(not_installed("the page", "tornado", "page")))
        return
    acting = Acting(sys.argv[1:], _press)

    def said(address: str) -> None:
        _say(address=f"{address}#{acting.token}")

    try:
        asyncio.run(serve(None, None, said, _until_unwatched, acting))
    except PirateError as error:
        _say(problem=str(error))


if __name__ == "__main__":
    main()
