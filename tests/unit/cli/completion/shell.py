"""An interactive shell on a pseudo-terminal, with the script of `pirate completion` in it."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import select
import struct
import subprocess
import sys
import termios
import time
from pathlib import Path

from ..conftest import ROOT

STARTED = {
    "bash": ["bash", "--norc", "--noprofile", "-i"],
    "zsh": ["zsh", "-f", "-i"],
    "fish": ["fish", "--no-config", "-i"],
}
USUAL = {
    "bash": "PS1='> '; bind 'set bell-style none'; bind 'set show-all-if-ambiguous on'",
    "zsh": "PS1='> '; bindkey -e; unsetopt beep",
    "fish": "function fish_prompt; echo -n '> '; end",
}
ON_TERMINAL = (
    "import fcntl, os, sys, termios; fcntl.ioctl(0, termios.TIOCSCTTY, 0); "
    "os.execvp(sys.argv[1], sys.argv[1:])"
)
"""Makes the terminal that of the session, as a fork could not beside threads."""

TO_START, DROP = "\x01", "\x15"
SIGNS = re.compile(r"\x1b\[[0-9;?>=]*[a-zA-Z]|\x1b[()][A-Z0-9]|\x1b\][^\x07]*\x07|\x1b[=>]")
WORDS = re.compile(r"<pirate(?:-run)?>(?:<[^>]*>)*")


class Shell:
    """A shell that has read the script."""

    def __init__(self, name: str, folder: Path) -> None:
        self.shown = ""
        self.folder = folder
        self._fd, its_own = pty.openpty()
        self._process = subprocess.Popen(
            [sys.executable, "-c", ON_TERMINAL, *STARTED[name]],
            stdin=its_own,
            stdout=its_own,
            stderr=its_own,
            start_new_session=True,
            cwd=folder,
            env={
                "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
                "PYTHONPATH": str(ROOT),
                "HOME": str(folder),
                "TERM": "xterm",
                "LANG": "C.UTF-8",
            },
        )
        os.close(its_own)
        fcntl.ioctl(self._fd, termios.TIOCSWINSZ, struct.pack("HHHH", 60, 200, 0, 0))
        self._type(f"{USUAL[name]}; pirate completion {name} > .script; source .script\n")
        self._read_until_done()

    def _type(self, keys: str) -> None:
        os.write(self._fd, keys.encode())

    def _read_until_done(self, within_s: float = 60.0) -> str:
        """What is shown until the shell has done what was typed before."""
        self._type("echo do''ne\n")
        return self.read_until("done", within_s)

    def read_until(self, word: str, within_s: float = 60.0) -> str:
        """What is shown up to and with the word."""
        give_up_s = time.monotonic() + within_s
        while word not in self.shown:
            assert time.monotonic() < give_up_s, f"'{word}' is not shown:\n{self.shown}"
            if select.select([self._fd], [], [], 0.05)[0]:
                read = os.read(self._fd, 65536).decode("utf-8", "replace")
                self.shown = SIGNS.sub("", self.shown + read)
        before, _, self.shown = self.shown.partition(word)
        return before + word

    def completed(self, line: str) -> list[str]:
        """The words of a line after the key, as the shell would hand them to the program."""
        self._type(f"{line}\t{TO_START}printf '<%s>' \n")
        words = WORDS.findall(self._read_until_done())
        assert words, self.shown
        return re.findall(r"<([^>]*)>", words[-1])

    def offers(self, line: str, last: str) -> str:
        """What is shown on the key, up to a word in it; the line is abandoned."""
        self._type(f"{line}\t\t")
        shown = self.read_until(last)
        self._type(DROP)
        self._read_until_done()
        return shown

    def end(self) -> None:
        os.close(self._fd)
        self._process.wait(timeout=60)
