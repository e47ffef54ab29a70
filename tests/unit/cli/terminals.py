"""The command line on a terminal of its own, with a person who presses keys."""

from __future__ import annotations

import fcntl
import os
import pty
import select
import signal
import termios
from collections.abc import Callable

from .conftest import ROOT
from .forked import ForkedRun


def _take_the_terminal() -> None:
    """Ctrl-C on it reaches this process, whatever the tests were started to ignore."""
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def on_a_terminal(
    arguments: tuple[str, ...], reply: Callable[[str], str], size: tuple[int, int] = (80, 24)
) -> tuple[int, str, bool]:
    """Exit code, everything shown, and whether the terminal was left as it was found."""
    ours, theirs = pty.openpty()
    termios.tcsetwinsize(theirs, (size[1], size[0]))
    before = termios.tcgetattr(theirs)
    environment = {**os.environ, "TERM": "xterm-256color"}
    for name in ("COLUMNS", "LINES", "NO_COLOR"):
        environment.pop(name, None)
    process = ForkedRun(
        arguments,
        stdin=theirs, stdout=theirs, stderr=theirs, cwd=ROOT, env=environment,
        start_new_session=True, preexec_fn=_take_the_terminal,
    )  # fmt: skip
    shown = ""
    while True:
        ready, _, _ = select.select([ours], [], [], 0.05)
        if ready:
            shown += os.read(ours, 65536).decode("utf-8", errors="replace")
            if answer := reply(shown):
                os.write(ours, answer.encode())
        elif process.poll() is not None:
            break
    same = termios.tcgetattr(theirs) == before
    os.close(ours)
    os.close(theirs)
    return process.wait(), shown, same


def once(prompt: str, key: str) -> Callable[[str], str]:
    """Presses the key when the prompt is seen for the first time."""
    left = [key]
    return lambda shown: left.pop() if left and prompt in shown else ""
