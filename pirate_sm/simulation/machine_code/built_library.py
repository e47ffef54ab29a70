"""Where the machine code of a function comes from: the library that was built with the package."""

from __future__ import annotations

import ast
import ctypes
import hashlib
import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache, partial
from itertools import accumulate
from operator import is_, itemgetter
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, NamedTuple, TypeVar, cast

from pirate_sm.core.errors import UsageError
from pirate_sm.simulation.machine_code.entry_points import ARRAYS, BY_PLACE, Argument, EntryPoint

# --- calls ---------------------------------------------------------------------------------------


_F = TypeVar("_F", bound=Callable[..., Any])

_NUMBERS: dict[str, Any] = {"float": ctypes.c_double, "int": ctypes.c_int64, "bool": ctypes.c_int64}


def callable_from_python(entry: EntryPoint, function: Any) -> Callable[..., Any]:
    """Return a function of a library as one that takes what its Python original takes.

    Args:
        entry: Its line of the table.
        function: The C function: `int f(int64 *arrays, numbers ..., void *result)`.

    Returns:
        It raises TypeError for an array that the machine code cannot take, and RuntimeError where
        the original would raise an exception. See :func:`own_call` for its attribute ``again``.
    """
    result = _NUMBERS.get(entry.result)
    function.restype = ctypes.c_int
    function.argtypes = [ctypes.c_void_p, *(_NUMBERS[each.kind] for each in entry.numbers)]
    if result is not None:
        function.argtypes.append(ctypes.c_void_p)
    expected = len(entry.flat)
    grouped = expected > len(entry.arguments)
    arrays_of = _picker([i for i, each in enumerate(entry.flat) if each.dimensions])
    numbers_of = _picker([i for i, each in enumerate(entry.flat) if not each.dimensions])
    places = _Places(entry)

    def call(*arguments: Any) -> Any:
        if grouped:
            flat: list[Any] = []
            for each in arguments:  # faster than by a generator; a glide has forty
                flat += each if isinstance(each, tuple) else (each,)
            arguments = tuple(flat)
        if len(arguments) != expected:
            raise TypeError(f"{entry.name} takes {expected} arguments, not {len(arguments)}")
        block = places.of(arrays_of(arguments))
        out = None
        if result is None:
            status = function(block, *numbers_of(arguments))
        else:
            out = result()
            status = function(block, *numbers_of(arguments), ctypes.byref(out))
        if status:
            raise RuntimeError(f"{entry.name} failed: out of memory, or shapes that do not fit")
        if out is not None:
            return bool(out.value) if entry.result == "bool" else out.value

    call.again = partial(callable_from_python, entry, function)  # type: ignore[attr-defined]
    return call


def own_call(function: _F) -> _F:
    """Return a compiled function for one caller among many.

    It remembers that caller's arrays, where the function itself would look at all of them again
    whenever another caller has come between.
    """
    again = getattr(function, "again", None)
    return function if again is None else cast(_F, again())


def _picker(positions: Sequence[int]) -> Callable[[Sequence[Any]], tuple[Any, ...]]:
    """Return a function that returns the items at these positions."""
    if len(positions) > 1:
        return itemgetter(*positions)
    return lambda items: tuple(items[position] for position in positions)


class _Places:
    """The places in memory of the arrays of a function's last call.

    A run calls with the same arrays all the time, so only one that was not there last time is
    looked at. What is remembered is replaced as a whole: threads do not disturb each other.
    """

    def __init__(self, entry: EntryPoint) -> None:
        self._entry = entry
        self._kinds = [each for each in entry.flat if each.dimensions]
        lengths = [1 + kind.dimensions for kind in self._kinds]
        self._starts = [0, *accumulate(lengths)]
        block = (ctypes.c_int64 * self._starts[-1])()
        # The arrays are kept, so that their places stay theirs.
        self._last: tuple[tuple[Any, ...], Any] = (None,) * len(lengths), block

    def of(self, arrays: tuple[Any, ...]) -> Any:
        """Return a block with the address and then the shape of each array.

        Raises:
            TypeError: One is not what the machine code takes.
        """
        known, block = self._last
        if all(map(is_, arrays, known)):
            return block
        block = type(block).from_buffer_copy(block)
        for i, (kind, array, old) in enumerate(zip(self._kinds, arrays, known, strict=True)):
            if array is not old:
                if not _fits(kind, array):
                    raise TypeError(self._wanted(i))
                start, end = self._starts[i : i + 2]
                block[start:end] = (_address(array), *array.shape)
        self._last = arrays, block
        return block

    def _wanted(self, index: int) -> str:
        kind = self._kinds[index]
        number = [i for i, each in enumerate(self._entry.flat, 1) if each.dimensions][index]
        return (
            f"argument {number} of {self._entry.name} must be {kind.kind} of {kind.dimensions} "
            "dimension(s), contiguous in C order, that can be written to"
        )


def _fits(kind: Argument, array: Any) -> bool:
    return bool(
        array.ndim == kind.dimensions
        and array.dtype.char in ARRAYS[kind.kind].letters
        and array.dtype.isnative
        and array.flags.carray
    )


def _address(array: Any) -> int:
    # numpy's own ways to say it take five times as long.
    return ctypes.addressof(ctypes.c_char.from_buffer(array)) if array.size else 0


# --- sources -------------------------------------------------------------------------------------


PACKAGE = Path(__file__).parents[2]
"""The folder of the package."""


def files_behind(modules: Iterable[str], package: Path = PACKAGE) -> tuple[str, ...]:
    """Return the files of modules and of all they import from the package, themselves included.

    Of a module that only hands a name on, its file counts, but not what else it imports.

    Args:
        modules: Full names of modules; one of another package is passed over.
        package: The folder of the package.

    Returns:
        Sorted paths below the package, with `/`.
    """
    tree_of = cache(_tree_of)
    found: set[Path] = set()
    handing_on: set[Path] = set()
    left = [file for name in modules if (file := _file_of(name, package))]
    while left:
        file = left.pop()
        if file in found:
            continue
        found.add(file)
        for imported in _imports(tree_of(file)):
            module, name = imported
            while (via := _file_of(module, package)) and (origin := _origin(tree_of(via), name)):
                if origin == (module, name):
                    break
                handing_on.add(via)
                module, name = origin
            names = (module, f"{module}.{name}")
            left += [each for full in names if (each := _file_of(full, package))]
    every = found | handing_on
    return tuple(sorted(file.relative_to(package).as_posix() for file in every))


def digest(files: Iterable[str], package: Path = PACKAGE) -> str:
    """Return a number for names and contents of files; empty if one of them cannot be read."""
    hashed = hashlib.sha256()
    try:
        for name in files:
            content = (package / name).read_bytes()
            hashed.update(f"{name} {len(content)}\n".encode())
            hashed.update(content)
    except OSError:
        return ""
    return hashed.hexdigest()


def _file_of(module: str, package: Path) -> Path | None:
    first, *rest = module.split(".")
    if first != package.name or not rest:
        return None
    place = package.joinpath(*rest)
    for file in (place.with_name(f"{place.name}.py"), place / "__init__.py"):
        if file.is_file():
            return file
    return None


def _tree_of(file: Path) -> ast.Module:
    return ast.parse(file.read_bytes())


def _imports(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """Yield what a module imports: the module, and the name in it, which is empty for a module."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((each.name, "") for each in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield from ((node.module, each.name) for each in node.names)


def _origin(tree: ast.Module, name: str) -> tuple[str, str] | None:
    """Return from where a module has a name, and its name there; None for one of its own."""
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and node.module:
            for each in node.names:
                if (each.asname or each.name) == name:
                    return node.module, each.name
    return None


# --- the library ---------------------------------------------------------------------------------


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


# --- the decorator -------------------------------------------------------------------------------


JIT_VARIABLE = "PIRATE_SM_JIT"
"""Environment variable; if it is set, functions are compiled when called, built or not."""


def compiled(function: _F) -> _F:
    """Return the function by its machine code, built or to be compiled on its first call.

    In a module whose machine code was built, a function of the table of entry points runs as
    machine code. All others there are called by those, inside the library. Called from Python they
    are Python.

    Raises:
        UsageError: It is not built, and numba is not installed.
    """
    found, entry = find_library(), BY_PLACE.get((function.__module__, function.__name__))
    if found.library is not None and not os.environ.get(JIT_VARIABLE):
        if entry is not None:
            built = found.library.function(entry)
            built.__doc__ = function.__doc__
            return cast(_F, built)
        if found.library.covers(function.__module__):
            return function
    try:
        from pirate_sm.simulation.machine_code.just_in_time import compiled_when_called
    except ModuleNotFoundError as error:
        if error.name not in ("numba", "llvmlite"):
            raise
        why = found.why_not or f"{JIT_VARIABLE} is set"
        raise UsageError(
            f"the simulator cannot run here: {why}; pip install 'pirate-sm[jit]' lets it compile "
            "itself when it is first used (or use the backend trace)"
        ) from None
    return compiled_when_called(function, long=entry is not None and entry.long)


def compiled_module(module: ModuleType) -> Mapping[str, Callable[..., Any]]:
    """Return the functions of a module by name, as machine code that calls each other's.

    So the core's own source is compiled for the simulator, without knowing of it. Each function
    comes after those that it calls.
    """
    names = dict(vars(module))
    for name, own in vars(module).items():
        if isinstance(own, FunctionType) and own.__module__ == module.__name__:
            names[name] = compiled(FunctionType(own.__code__, names, name))
    return names


def is_kept(function: Callable[..., Any]) -> bool:
    """Return whether a compiled function can run at once; if not, its first call takes seconds."""
    if not hasattr(function, "py_func"):
        return True
    from pirate_sm.simulation.machine_code import just_in_time

    return just_in_time.is_kept(function)
