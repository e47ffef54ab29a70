"""Compiles functions to machine code, keeps it on disk, and recompiles it if it is damaged."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

_F = TypeVar("_F", bound=Callable[..., Any])


def compiled(function: _F) -> _F:
    """Return a function that is compiled on its first call, with its machine code kept on disk.

    numba keeps it beside the function's file or else in the user's cache folder. If neither is
    writable, each process compiles for itself.
    """
    try:
        dispatcher = numba.njit(cache=True, error_model="numpy")(function)
    except RuntimeError:
        return cast(_F, numba.njit(error_model="numpy")(function))
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
