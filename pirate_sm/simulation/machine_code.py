"""Compiles functions to machine code, keeps it on disk, and recompiles it if it is damaged."""

from __future__ import annotations

from collections.abc import Callable
from hashlib import sha256
from typing import Any, TypeVar, cast

import numba

_F = TypeVar("_F", bound=Callable[..., Any])


def compiled(function: _F) -> _F:
    """Return a function that is compiled on its first call, with its machine code kept on disk.

    numba keeps it beside the function's file or else in the user's cache folder. If neither is
    writable, each process compiles for itself. It is compiled again after an edit of its file, of
    the file of a compiled function that it calls, or of a constant that it uses.
    """
    try:
        dispatcher = numba.njit(cache=True, error_model="numpy")(function)
    except RuntimeError:
        return cast(_F, numba.njit(error_model="numpy")(function))
    _notice_edits(dispatcher, function)
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


def _notice_edits(dispatcher: Any, function: Callable[..., Any]) -> None:
    """Make the kept machine code depend on everything that was compiled into it.

    numba itself looks at the function's own file only, and takes constants as they were.
    """
    kept = _kept(dispatcher)
    if kept is None:
        return
    used = [function.__globals__.get(name) for name in function.__code__.co_names]
    constants = [repr(each) for each in used if isinstance(each, int | float | tuple)]
    called = [_kept(each)._source_stamp for each in used if _kept(each) is not None]
    made_of = repr((kept._source_stamp, constants, called))
    kept._source_stamp = sha256(made_of.encode()).hexdigest()


def _kept(function: Any) -> Any:
    """Return numba's record of a compiled function's machine code on disk; None without one."""
    return getattr(getattr(function, "_cache", None), "_cache_file", None)


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
