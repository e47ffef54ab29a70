"""Lists the MIDI devices of this machine, and opens one."""

from __future__ import annotations

import errno
import grp
import os
import re
import stat
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pirate_sm.core.errors import UsageError

_CARDS = Path("/proc/asound/cards")
_DEVICES = Path("/dev/snd")

_CARD = re.compile(r"^ *(\d+) \[.*?\]: (.*)$")
_DEVICE = re.compile(r"midiC(\d+)D(\d+)")

_AT_ONCE = 4096

_TAKEN = {errno.EBUSY, errno.EAGAIN}


@dataclass(frozen=True)
class MidiDevice:
    """A MIDI device.

    Attributes:
        path: Its file.
        card: Name of its sound card, as the system shows it.
    """

    path: Path
    card: str

    def __str__(self) -> str:
        return f"{self.path} ({self.card})"


@dataclass(frozen=True)
class MidiSystem:
    """Where the system lists its sound cards and keeps their devices (ALSA, on Linux).

    Attributes:
        cards: The file with the names of the sound cards.
        devices: The folder with the files of their devices.
    """

    cards: Path = _CARDS
    devices: Path = _DEVICES

    def listed(self) -> list[MidiDevice]:
        """Return all MIDI devices, in the order of their cards; empty on a machine without any."""
        try:
            names = card_names(self.cards.read_text("utf-8", errors="replace"))
            files = [(_DEVICE.fullmatch(path.name), path) for path in self.devices.iterdir()]
        except OSError:
            return []
        found = sorted((int(m[1]), int(m[2]), path) for m, path in files if m is not None)
        return [MidiDevice(path, names.get(card, "unknown card")) for card, _, path in found]

    def find(self, name: str) -> Path:
        """Return the file of the first device whose card has this text in its name.

        Raises:
            UsageError: There is none; says which devices there are.
        """
        there = self.listed()
        for device in there:
            if name.casefold() in device.card.casefold():
                return device.path
        raise UsageError(f"no MIDI device is named '{name}'; {devices_text(there)}")


def devices_text(devices: Sequence[MidiDevice]) -> str:
    """Return which devices there are, for messages."""
    return (
        f"connected: {', '.join(map(str, devices))}" if devices else "no MIDI device is connected"
    )


def card_names(text: str) -> dict[int, str]:
    """Return the names of sound cards by their numbers, from the text of ``/proc/asound/cards``.

    A card has two lines: a number, an id and a short name; then its long name.
    """
    names: dict[int, str] = {}
    card = None
    for line in text.splitlines():
        match = _CARD.match(line)
        if match is not None:
            card = int(match[1])
            names[card] = match[2].partition(" - ")[2].strip() or match[2].strip()
        elif card is not None and line.strip():
            names[card] = f"{names[card]}: {line.strip()}"
            card = None
    return names


def open_device(path: Path) -> int:
    """Return a file descriptor that reads the device without blocking.

    Raises:
        UsageError: It is no device, or cannot be opened; says what to do.
    """
    try:
        if not stat.S_ISCHR(path.stat().st_mode):
            raise UsageError(f"{path} is not a device; MIDI devices are /dev/snd/midiC*D*")
        return os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC)
    except PermissionError:
        raise UsageError(f"{path} may not be read: {_who_may(path)}") from None
    except OSError as error:
        taken = error.errno in _TAKEN
        why = "another program uses it" if taken else (error.strerror or str(error))
        raise UsageError(f"{path} cannot be opened: {why}") from None


def read_device(fd: int) -> bytes | str:
    """Return the bytes that wait in a device, perhaps none; why it is gone, if it is."""
    try:
        return os.read(fd, _AT_ONCE) or "its device has closed"
    except BlockingIOError:
        return b""
    except OSError as error:
        return error.strerror or str(error)


def _who_may(path: Path) -> str:
    """Return which users may read a file that this one may not."""
    try:
        status = path.stat()
        group = grp.getgrgid(status.st_gid).gr_name
    except (OSError, KeyError):
        return "permission denied"
    if not status.st_mode & stat.S_IRGRP:
        return "permission denied, also to its group"
    return f"only the group '{group}' may; `sudo usermod -aG {group} $USER`, then log in again"
