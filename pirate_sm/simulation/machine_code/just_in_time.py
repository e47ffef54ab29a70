"""Compiles functions when they are first called, keeps their machine code, and mends damaged code.

This needs numba (the extra `jit`). It serves source trees whose functions have changed, and
platforms for which nothing is built.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, TypeVar, cast

import numba

from pirate_sm.simulation.machine_code.built_library import digest, files_behind

_F = TypeVar("_F", bound=Callable[..., Any])


def compiled_when_called(function: _F, *, long: bool = False) -> _F:
    """Return a function that is compiled on its first call, with its machine code kept on disk.

    numba keeps it beside the function's file or else in the user's cache folder. If neither is
    writable, each process compiles for itself. It is compiled again after an edit of its file, of
    the file of a compiled function that it calls, or of a constant that it uses.

    Args:
        function: The function.
        long: Whether other threads of Python go on while it runs.
    """
    options = {"error_model": "numpy", "nogil": long}
    try:
        dispatcher = numba.njit(cache=True, **options)(function)
    except RuntimeError:
        return cast(_F, numba.njit(**options)(function))
    _notice_edits(dispatcher, function.__module__)
    _forgive_damage(dispatcher)
    return cast(_F, dispatcher)


def is_kept(function: Callable[..., Any]) -> bool:
    """Return whether a compiled function can run at once; if not, its first call takes seconds.

    This reads numba's cache for machine code of this processor, as numba has no public call for it.
    """
    dispatcher: Any = function
    if dispatcher.signatures:
        return True
    try:
        index = dispatcher._cache._cache_file._load_index()
        machine = dispatcher.targetctx.codegen().magic_tuple()
        return any(machine in key for key in index)
    except Exception:  # unpickling a damaged index can raise anything
        return False


def _notice_edits(dispatcher: Any, module: str) -> None:
    """Compile again after an edit in any file that the function's module imports.

    numba itself looks at the function's own file only, and would go on with an old copy of what is
    called from another file.
    """
    kept = getattr(getattr(dispatcher, "_cache", None), "_cache_file", None)
    if kept is not None:
        kept._source_stamp = (kept._source_stamp, _stamp(module))


@cache
def _stamp(module: str) -> str:
    return digest(files_behind([module]))


def _forgive_damage(dispatcher: Any) -> None:
    """Drop machine code that cannot be loaded, so that it is compiled again.

    numba itself raises for an unreadable file. A file cut short, by a full disk for example, would
    stop this run and all later ones.
    """
    cache = getattr(dispatcher, "_cache", None)
    load = getattr(cache, "load_overload", None)
    if cache is None or load is None:
        return

    def load_or_drop(signature: Any, target: Any) -> Any:
        try:
            return load(signature, target)
        except Exception:  # unpickling damaged code can raise anything
            try:
                cache.flush()
            except OSError:  # it cannot be written either
                cache.disable()
            return None

    cache.load_overload = load_or_drop
