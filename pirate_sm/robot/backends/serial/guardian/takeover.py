"""Takes the port over from a guardian that has outlived its runner.

Each such guardian keeps a file in the user's runtime folder, locked as long as it lives. The file
names the guardian's port and the array that would stop the robot. SIGUSR1 asks for the port.
"""

from __future__ import annotations

import fcntl
import json
import os
import signal
import time
import warnings
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple, Self

from platformdirs import user_runtime_path

_PATTERN = "guardian-*.json"
_YIELDS_WITHIN_S = 2.0
_DIES_WITHIN_S = 2.0
_LOOK_EVERY_S = 0.02


class LeftBehind(NamedTuple):
    """A guardian that has no runner any more.

    Attributes:
        pid: Its process id.
        url: The port, as its runner was given it.
        device: The device that this name stood for.
        md5: Checksum of the definition of an array of setpoints.
        payload: The array that stops the robot.
    """

    pid: int
    url: str
    device: str
    md5: str
    payload: bytes

    @classmethod
    def of(cls, url: str, md5: str, payload: bytes) -> Self:
        """Return the description of this process as such a guardian."""
        return cls(os.getpid(), url, os.path.realpath(url), md5, payload)

    def holds(self, url: str) -> bool:
        """Return whether it holds this port, under any of its names."""
        return os.path.realpath(url) in (self.device, os.path.realpath(self.url))


class Registration:
    """The file that registers this process as a guardian without a runner.

    If no file can be written, nothing is registered, and others can only wait for the port.
    """

    def __init__(self, left: LeftBehind) -> None:
        self._descriptor: int | None = None
        self._path = _folder() / f"guardian-{left.pid}.json"
        draft = self._path.with_suffix(".draft")
        with suppress(OSError):
            self._path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            opened = os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
            self._descriptor = opened
            fcntl.flock(opened, fcntl.LOCK_EX)
            fields = left._replace(payload=b"")._asdict() | {"payload": left.payload.hex()}
            os.write(opened, json.dumps(fields).encode())
            draft.rename(self._path)

    def remove(self) -> None:
        """Delete the file and release its lock."""
        with suppress(OSError):
            self._path.unlink()
        if self._descriptor is not None:
            os.close(self._descriptor)


def take_over(url: str, md5: str) -> LeftBehind | None:
    """Make the guardian on this port give it up, and return it; None if there is none.

    A guardian that does not answer is killed. A guardian whose arrays have another definition is
    left alone, because the new run could not write its safe array.

    Args:
        url: The port.
        md5: Checksum of the definition of an array of setpoints.
    """
    for path in sorted(_folder().glob(_PATTERN)):
        left = _read(path)
        if left is None or left.md5 != md5 or not left.holds(url):
            continue
        lives = _ask(path, left.pid)
        with suppress(OSError):
            path.unlink()
        if lives:
            return left
    return None


def _folder() -> Path:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a machine without such a folder gets a substitute
        return user_runtime_path("pirate_sm")


def _read(path: Path) -> LeftBehind | None:
    try:
        if path.stat().st_uid != os.getuid():
            return None  # other users must not choose what the robot gets
        fields = json.loads(path.read_bytes())
        return LeftBehind(**fields | {"payload": bytes.fromhex(fields["payload"])})
    except (OSError, ValueError, TypeError, KeyError):
        return None


def _ask(path: Path, pid: int) -> bool:
    """Ask a guardian for the port; return whether it held the lock. Afterwards nobody holds it."""
    try:
        file = path.open("rb")
    except OSError:
        return False
    with file:
        if _locked(file.fileno(), 0.0):
            return False  # it has died, and its knowledge of the robot with it
        for number, within_s in (
            (signal.SIGUSR1, _YIELDS_WITHIN_S),
            (signal.SIGKILL, _DIES_WITHIN_S),
        ):
            with suppress(ProcessLookupError, PermissionError):
                os.kill(pid, number)
            if _locked(file.fileno(), within_s):
                return True
    return True


def _locked(descriptor: int, within_s: float) -> bool:
    """Return whether the lock was obtained within this time."""
    give_up_s = time.monotonic() + within_s
    while True:
        with suppress(OSError):
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
        if time.monotonic() >= give_up_s:
            return False
        time.sleep(_LOOK_EVERY_S)
