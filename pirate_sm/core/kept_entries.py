"""Keeps in folders of the user's cache what takes long: results of checks, and tables of charts.

A folder is used only if it is the user's and closed to others. An entry is text with a digest of
itself and of its key. One that cannot be used is made again, and where nothing can be written
nothing is kept.

What is asked of the disk here is not noted (`on_disk.py`): a result is the same without it.
"""

from __future__ import annotations

import json
import os
import re
import stat
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from hashlib import blake2b
from itertools import accumulate
from pathlib import Path
from typing import Any, Final, NamedTuple

from pirate_sm.core.on_disk import PART, here, open_regular

FOLDER_VARIABLE: Final = "PIRATE_SM_CACHE"
"""Names the folder, instead of the user's; empty: no results are kept."""

LARGEST: Final = 1 << 26
"""What all entries of a folder take together, bytes; the oldest are removed. [decided]"""

_AFTER_CLEARING: Final = LARGEST * 3 // 4
"""What is left when the oldest are removed, so that this is rare, bytes. [decided]"""

_ENTRY: Final = re.compile(rf"[0-9a-f]{{32}}(\.[0-9a-f]{{8}}{re.escape(PART)})?")


class KeptEntry(NamedTuple):
    """An entry in a folder."""

    used_s: float
    size: int
    path: str


@dataclass(frozen=True)
class Entries:
    """The entries in a folder, which may not exist."""

    folder: Path

    def read(self, key: str) -> Any:
        """Return what an entry holds, and count it as used; None without one."""
        path = self.folder / key
        try:
            if not self._is_ours():
                return None
            with open_regular(path) as file:
                digest, content = file.readline().strip(), file.read()
            if digest != _signature(key, content):
                return None
            os.utime(path)  # the oldest are removed first
            return json.loads(content)
        except (OSError, ValueError, RecursionError):
            return None

    def write(self, new: Mapping[str, Any]) -> None:
        """Write entries, each atomically, and remove the oldest if all together are too large."""
        with suppress(OSError):
            self.folder.parent.mkdir(parents=True, exist_ok=True)
            self.folder.mkdir(mode=0o700, exist_ok=True)
        if not self._is_ours():
            return
        for key, value in new.items():
            content = json.dumps(value).encode()
            part = self.folder / f"{key}.{os.urandom(4).hex()}{PART}"
            with suppress(OSError):
                try:
                    part.write_bytes(_signature(key, content) + b"\n" + content)
                    part.replace(self.folder / key)
                finally:
                    part.unlink(missing_ok=True)
        found = self.all()
        sizes = [*accumulate(each.size for each in reversed(found))]
        if sizes and sizes[-1] > LARGEST:
            with suppress(OSError):
                self.remove(found[: sum(size > _AFTER_CLEARING for size in sizes)])

    def all(self) -> list[KeptEntry]:
        """Return all entries, those first that have not been used for the longest time."""
        found = []
        with suppress(OSError), os.scandir(self.folder) as inside:
            for each in inside:
                with suppress(OSError):  # another process may have removed it
                    if _ENTRY.fullmatch(each.name) and not each.is_dir(follow_symlinks=False):
                        seen = each.stat(follow_symlinks=False)
                        found.append(KeptEntry(seen.st_mtime, seen.st_size, each.path))
        return sorted(found)

    def remove(self, unwanted: Iterable[KeptEntry]) -> None:
        """Remove entries.

        Raises:
            OSError: One cannot be removed; the others are.
        """
        failed = None
        for each in unwanted:
            try:
                Path(each.path).unlink(missing_ok=True)
            except OSError as error:
                failed = error
        if failed is not None:
            raise failed

    def refused(self) -> bool:
        """Return whether something is in the place of the folder that is not used."""
        return os.path.lexists(self.folder) and not self._is_ours()

    def _is_ours(self) -> bool:
        """Return whether there is the folder, it is the user's, and it is closed to others."""
        try:
            seen = os.lstat(self.folder)
        except OSError:
            return False
        closed = not stat.S_IMODE(seen.st_mode) & 0o077
        return stat.S_ISDIR(seen.st_mode) and seen.st_uid == os.geteuid() and closed


def results() -> Entries | None:
    """Return the results of checks; None if nothing is to be kept."""
    return None if os.environ.get(FOLDER_VARIABLE) == "" else Entries(_cache() / "checks")


def charts() -> Entries:
    """Return the tables of charts, which are kept in any case."""
    return Entries(_cache() / "charts")


def _cache() -> Path:
    if given := os.environ.get(FOLDER_VARIABLE):
        return Path(here(), given)
    from platformdirs import user_cache_path

    return user_cache_path("pirate_sm", appauthor=False)


def _signature(key: str, content: bytes) -> bytes:
    return digest(key.encode() + content).encode()


def digest(content: bytes) -> str:
    """Return a name of a content: a key of an entry."""
    return blake2b(content, digest_size=16).hexdigest()
