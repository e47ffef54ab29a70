"""The library with the machine code that was built with the package, and its functions."""

from __future__ import annotations

import ctypes
import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from pirate_sm.simulation.machine_code.calls import callable_from_python
from pirate_sm.simulation.machine_code.entry_points import EntryPoint
from pirate_sm.simulation.machine_code.sources import PACKAGE, digest

FOLDER = Path(__file__).parent
FILE = "functions.library"
"""Name of the library, beside this file; one that Python does not take for a module."""

REASON_FILE = "not_built.txt"
"""Beside this file: why there is no library."""

MANIFEST = "built_from"
"""A symbol of the library: JSON with the files that it was made of and their digest."""


class Library:
    """The functions that were built from these sources.

    Args:
        path: The library's file.

    Raises:
        OSError: It cannot be loaded here.
    """

    def __init__(self, path: Path) -> None:
        # Most functions take microseconds, less than it takes to give the interpreter's lock away.
        self._library = ctypes.PyDLL(str(path))
        self._unlocked = ctypes.CDLL(str(path))
        try:
            start = ctypes.addressof(ctypes.c_char.in_dll(self._library, MANIFEST))
        except ValueError as error:
            raise OSError(f"{path} holds no list of its sources") from error
        manifest = json.loads(ctypes.string_at(start))
        self.files = tuple(manifest["files"])
        self._digest: str = manifest["digest"]

    def is_current(self, package: Path = PACKAGE) -> bool:
        """Return whether its sources are still what it was made of."""
        return digest(self.files, package) == self._digest

    def covers(self, module: str) -> bool:
        """Return whether what is compiled in a module is in the library."""
        return "/".join(module.split(".")[1:]) + ".py" in self.files

    def function(self, entry: EntryPoint) -> Callable[..., Any]:
        """Return a function of the library, for calls from Python."""
        library = self._unlocked if entry.long else self._library
        return callable_from_python(entry, getattr(library, entry.symbol))


class Found(NamedTuple):
    """The library, or why there is none.

    Attributes:
        library: None if there is none that can be used.
        why_not: A sentence; empty if there is one.
    """

    library: Library | None
    why_not: str = ""


@cache
def find_library(folder: Path = FOLDER, package: Path = PACKAGE) -> Found:
    """Return the library that was built with the package, if it fits the sources."""
    path = folder / FILE
    if not path.is_file():
        reason = folder / REASON_FILE
        why = reason.read_text("utf-8").strip() if reason.is_file() else ""
        return Found(None, why or "its machine code was not built with this copy of pirate_sm")
    try:
        library = Library(path)
    except (OSError, ValueError, KeyError) as error:
        return Found(None, f"its machine code cannot be loaded ({error})")
    if not library.is_current(package):
        return Found(
            None,
            "its source was changed after its machine code was built ('pip install -e .' builds "
            "it again)",
        )
    return Found(library)
