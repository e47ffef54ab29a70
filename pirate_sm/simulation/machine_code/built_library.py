"""The library with the machine code that was built with the package, and its functions."""

from __future__ import annotations

import ctypes
import json
from collections.abc import Callable, Sequence
from functools import cache
from operator import is_
from pathlib import Path
from typing import Any, NamedTuple

from pirate_sm.simulation.machine_code.entry_points import ARRAYS, EntryPoint
from pirate_sm.simulation.machine_code.sources import PACKAGE, digest

FOLDER = Path(__file__).parent
FILE = "functions.library"
"""Name of the library, beside this file; one that Python does not take for a module."""

REASON_FILE = "not_built.txt"
"""Beside this file: why there is no library."""

MANIFEST = "built_from"
"""A symbol of the library: JSON with the files that it was made of and their digest."""

_SCALARS: dict[str, Any] = {"float": ctypes.c_double, "int": ctypes.c_int64, "bool": ctypes.c_int64}


class Library:
    """The functions that were built from these sources.

    Args:
        path: The library's file.

    Raises:
        OSError: It cannot be loaded here.
    """

    def __init__(self, path: Path) -> None:
        # Its functions take microseconds, less than it takes to give the interpreter's lock away.
        self._library = ctypes.PyDLL(str(path))
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
        return _callable(entry, getattr(self._library, entry.symbol))


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


class _Bound(NamedTuple):
    """Arrays, and where they are in memory.

    Attributes:
        arrays: Kept, so that the places stay theirs.
        block: Of each array its address and then its shape.
    """

    arrays: Sequence[Any]
    block: Any


def _callable(entry: EntryPoint, function: Any) -> Callable[..., Any]:
    """Return a function that checks arrays when it first sees them, and passes them on.

    It remembers the arrays of its last call, because a run calls with the same ones all the time.
    What was remembered is replaced as a whole, so threads do not disturb each other.
    """
    kinds = entry.arguments
    arrays_at = tuple(i for i, kind in enumerate(kinds) if kind.dimensions)
    numbers_at = tuple(i for i, kind in enumerate(kinds) if not kind.dimensions)
    result = _SCALARS.get(entry.result)
    function.restype = ctypes.c_int
    function.argtypes = [ctypes.c_void_p, *(_SCALARS[kinds[i].kind] for i in numbers_at)]
    if result is not None:
        function.argtypes.append(ctypes.c_void_p)
    bound = _Bound((), None)

    def call(*arguments: Any) -> Any:
        nonlocal bound
        if len(arguments) != len(kinds):
            raise TypeError(f"{entry.name} takes {len(kinds)} arguments, not {len(arguments)}")
        arrays = [arguments[i] for i in arrays_at]
        now = bound
        if len(now.arrays) != len(arrays) or not all(map(is_, arrays, now.arrays)):
            now = bound = _Bound(arrays, _block(entry, arguments))
        numbers = [arguments[i] for i in numbers_at]
        if result is None:
            status = function(now.block, *numbers)
        else:
            out = result()
            status = function(now.block, *numbers, ctypes.byref(out))
        if status:
            raise RuntimeError(f"{entry.name} failed: out of memory, or shapes that do not fit")
        if result is not None:
            return bool(out.value) if entry.result == "bool" else out.value

    return call


def _block(entry: EntryPoint, arguments: Sequence[Any]) -> Any:
    """Return where the arrays of a call are.

    Raises:
        TypeError: One is not what the machine code takes.
    """
    words: list[int] = []
    for number, (kind, array) in enumerate(zip(entry.arguments, arguments, strict=True), 1):
        if not kind.dimensions:
            continue
        wanted = ARRAYS[kind.kind]
        if (
            array.ndim != kind.dimensions
            or array.dtype.str[1:] != wanted
            or not (array.dtype.isnative and array.flags.carray)
        ):
            raise TypeError(
                f"argument {number} of {entry.name} must be a contiguous array that can be written "
                f"to, with {kind.dimensions} dimension(s) of {wanted}"
            )
        words += [array.ctypes.data, *array.shape]
    return (ctypes.c_int64 * len(words))(*words)
